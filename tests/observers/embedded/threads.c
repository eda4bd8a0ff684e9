/* Observers in threads, each with a state of its own and the same samples: their estimates must be equal.

   Compiled with TORQUE, the name of the torque in a sample; for the thread sanitiser. */
#include <pthread.h>
#include <stdio.h>

#include "brushgrip.h"

enum { THREADS = 4, SAMPLES = 400 };

typedef struct {
    brushgrip_state_t state;
    brushgrip_estimate_t estimate;
} job_t;

static void *run(void *argument) {
    job_t *job = argument;
    brushgrip_sample_t sample = {0};
    int i;
    brushgrip_init(&job->state);
    for (i = 0; i < SAMPLES; ++i) {
        /* The wheel swings, the torque opposes it. */
        const int phase = i % 100, turn = phase < 50 ? phase : 100 - phase;
        sample.psi = (REAL)(turn - 25) / 100, sample.F_N = 400, sample.dt = (REAL)0.01;
        sample.TORQUE = (REAL)(phase < 50 ? -7 : 7) + (REAL)0.01 * (REAL)(i % 7);
        brushgrip_step(&job->state, &sample);
    }
    brushgrip_estimate(&job->state, &job->estimate);
    return NULL;
}

int main(void) {
    static job_t jobs[THREADS];
    pthread_t threads[THREADS];
    int i, other = 0;
    for (i = 0; i < THREADS; ++i)
        if (pthread_create(&threads[i], NULL, run, &jobs[i]) != 0) return 2;
    for (i = 0; i < THREADS; ++i) {
        pthread_join(threads[i], NULL);
        other += jobs[i].estimate.mu != jobs[0].estimate.mu || !jobs[i].estimate.informed;
    }
    printf("mu %g, %d differ\n", (double)jobs[0].estimate.mu, other);
    return other;
}
