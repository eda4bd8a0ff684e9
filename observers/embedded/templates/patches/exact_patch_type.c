/* The contact patch, see the code. */
typedef struct {
    ${real} xi[${depth}], r[${depth}], d[${depth}], angle, rest;
    ${real} k, geometry[2], level, still_moment; %% if rig_at_run_time
    int32_t corners, is_turning;
    int8_t clipped[${depth}];
    ${real} own[${own}]; /* of the effects */ %% if own
} ${name}_patch_t;

