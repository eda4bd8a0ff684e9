/* Observers in threads, each with a state of its own and the same samples: they have to say the same.

   Compiled with TORQUE, the name of the torque in a sample; for a compiler that watches who writes where. */
#include <pthread.h>
#include <stdio.h>

#include "brushgrip.h"

enum { THREADS = 4, SAMPLES = 400 };

typedef struct {
    brushgrip_state_t state;
    brushgrip_estimate_t said;
} job_t;

static void *follow(void *given) {
    job_t *job = given;
    brushgrip_sample_t sample = {0};
    int i;
    brushgrip_init(&job->state);
    for (i = 0; i < SAMPLES; ++i) {
        /* A wheel that goes to and fro, its torque against it. */
        const int phase = i % 100, turn = phase < 50 ? phase : 100 - phase;
        sample.psi = (REAL)(turn - 25) / 100, sample.F_N = 400, sample.dt = (REAL)0.01;
        sample.TORQUE = (REAL)(phase < 50 ? -7 : 7);
        brushgrip_step(&job->state, &sample);
    }
    brushgrip_estimate(&job->state, &job->said);
    return NULL;
}

int main(void) {
    static job_t jobs[THREADS];
    pthread_t threads[THREADS];
    int i, other = 0;
    for (i = 0; i < THREADS; ++i)
        if (pthread_create(&threads[i], NULL, follow, &jobs[i]) != 0) return 2;
    for (i = 0; i < THREADS; ++i) {
        pthread_join(threads[i], NULL);
        other += jobs[i].said.mu != jobs[0].said.mu || !jobs[i].said.informed;
    }
    printf("mu %g, %d say something else\n", (double)jobs[0].said.mu, other);
    return other;
}
