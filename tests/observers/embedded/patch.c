/* Functions for tests of what is static in generated code. */
#include "brushgrip.c"

void patch_init(brushgrip_patch_t *patch, REAL psi) { brushgrip_clear_patch(patch, psi); }

int64_t patch_size(void) { return (int64_t)sizeof(brushgrip_patch_t); }

/* Along angles and limits: moment over k, its derivatives by scale and by the angle, and corners in use. */
void patch_run(brushgrip_patch_t *patch, int64_t count, const REAL *psi, const REAL *level, REAL scale, REAL *rows) {
    int64_t i;
    for (i = 0; i < count; ++i) {
        brushgrip_turn_patch(patch, psi[i], level[i], scale);
        brushgrip_patch_moment(patch, scale, rows + 4 * i);
        rows[4 * i + 3] = (REAL)patch->corners;
    }
}

/* Functions of numbers that generated code has of its own. */
REAL exp_of(REAL x) { return brushgrip_any_exp(x); }
REAL log_of(REAL x) { return brushgrip_any_log(x); }
