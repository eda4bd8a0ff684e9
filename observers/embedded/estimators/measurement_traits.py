"""What C needs to know of a measurement model, from its expressions alone."""

from functools import cache

from observers.embedded.scalar_function import inputs_used
from observers.estimators.mhe_terms import build_forward
from observers.measurement.linearisation import angle_is_state, build_motion
from observers.measurement.measurement_model import ROWS, MeasurementModel


def follows_correction(model: MeasurementModel) -> bool:
    """True where the patch is advanced at the corrected states, not at the sample."""
    return angle_is_state(model)


@cache
def torque_moves_states(model: MeasurementModel) -> bool:
    """True where the motion of the states depends on the torque of the patch."""
    return not inputs_used(build_motion(model)).isdisjoint(("M_z", "slopes"))


@cache
def rows_used(model: MeasurementModel) -> tuple[str, ...]:
    """Those of `ROWS` that the terms of a window depend on: what C stores of a sample."""
    forward = build_forward(model)
    used = {ROWS.index(name) for name in ("F_N", "dt", "accepted", "jump")}
    for name in ("row", "row_next"):
        at = forward.index_in(name)
        for i in range(forward.n_out()):
            used.update(forward.jac_sparsity(i, at).get_triplet()[1])
    return tuple(name for i, name in enumerate(ROWS) if i in used)
