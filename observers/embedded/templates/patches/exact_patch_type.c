/* The contact patch, see the code. */
typedef struct {
    ${real} xi[${depth}], r[${depth}], d[${depth}], angle, rest;
%% if rig_at_run_time
    ${real} k, geometry[2], level, still_moment;
%% endif
    int32_t corners, is_turning;
    int8_t clipped[${depth}];
%% if own
    ${real} own[${own}]; /* of the effects */
%% endif
} ${name}_patch_t;

