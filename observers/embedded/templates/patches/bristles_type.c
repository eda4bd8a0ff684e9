/* The contact patch: deformation of the bristles over the half-length, see the code. */
typedef struct {
    ${real} q[${bristles}], q_by_mu[${bristles}];
%% if by_k
    ${real} stiffness; /* k over its nominal value */
%% for part in parts
    ${real} ${part}_by_k[${bristles}];
%% endfor
%% endif
%% if relaxation
    ${real} branch[${bristles}], branch_by_mu[${bristles}]; /* stress of the Maxwell branches */
%% endif
%% if own
    ${real} own[${own}]; /* of the effects */
%% endif
%% if compliant
    ${real} follows[${bristles}], further, further_by_mu${", gain" if relaxation}; /* against the turn; what the last turn lacked */
%% endif
    ${real} angle, angle_by_mu, mu, M_z, M_z_by_mu, slope, retained;
} ${name}_patch_t;

