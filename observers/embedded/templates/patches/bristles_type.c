/* The contact patch: deformation of the bristles over the half-length, see the code. */
typedef struct {
    ${real} q[${bristles}], q_by_mu[${bristles}];
%% if by_k
    ${real} stiffness; /* k over its nominal value */
    ${real} ${part}_by_k[${bristles}]; %% for part in parts
%% endif
    ${real} branch[${bristles}], branch_by_mu[${bristles}]; /* stress of the Maxwell branches */ %% if relaxation
    ${real} own[${own}]; /* of the effects */ %% if own
%% if compliant
    ${real} follows[${bristles}], further, further_by_mu${", further_by_k" if by_k}${", gain" if relaxation}; /* against the turn; what the last turn lacked */
    ${real} angle_by_mu, M_z_by_mu${", angle_by_k, M_z_by_k" if by_k}, slope;
%% endif
    ${real} angle, mu, M_z, retained; /* M_z${" at the nominal k" if by_k}, of the patch alone */
} ${name}_patch_t;

