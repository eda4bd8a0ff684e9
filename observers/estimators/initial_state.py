"""The state before the first sample, as a Function of that sample, for Python and for generated C."""

from functools import cache

import casadi as ca

from observers.layout import Layout, named, symbols, vector_of
from observers.measurement.directional_friction import OTHER
from observers.measurement.measurement_model import CLEAN, RIG, MeasurementModel
from observers.measurement.torque_error import is_known, share_of_full_slide
from observers.patch.patch_protocol import (
    PatchModel,
    observer_constants_size,
    output_vector,
    split_theta_rig_tuning,
)
from observers.patch.update import tyre_states
from observers.protocol import SAMPLE
from observers.quality.acquisition_and_tracking import initial_supervision
from observers.tuning import TUNING_FIELDS
from observers.udu import symbolic_covariance_from_udu
from symbolic import GEOMETRY, SIGNALS, full_slide_torque
from symbolic.named_and_buffered_functions import named_function


@cache
def build_initial_state(
    model: PatchModel, measurement_model: MeasurementModel, layout: Layout
) -> ca.Function:
    """(sample, constants) -> state: the prior, the patch at rest, an empty window.

    In a window one column of a part stands for all; parts that are not named here begin as zeros.
    """
    inputs = symbols(ca.MX, sample=len(SAMPLE), constants=observer_constants_size(model))
    theta, rig, vector = split_theta_rig_tuning(model, inputs["constants"])
    tuning, first = named(TUNING_FIELDS, vector), named(SAMPLE, inputs["sample"])
    first["psi_dot"] = ca.if_else(is_known(first["psi_dot"]), first["psi_dot"], 0)
    signals = vector_of(SIGNALS, first)
    numbers = named(RIG, rig)
    slide = full_slide_torque(first["F_N"], numbers["a"])
    tuning["zero_std"] = share_of_full_slide(numbers["zero_std"], slide, tuning["zero_std"])
    prior = measurement_model.prior(tuning, first, slide)
    states = measurement_model.states
    mean, variance = (ca.vertcat(*(prior[name][i] for name in states)) for i in range(2))
    point = [tuning["mu"] if name == "log_mu" else 1 for name in tyre_states(measurement_model)]
    last, P = _values_at_rest(CLEAN, first), ca.diag(variance)
    factor = P
    if OTHER in states:
        # The other direction has the friction of this one and a difference: U D U' of both.
        at, other = states.index("log_mu"), states.index(OTHER)
        share = variance[at] / variance[other]
        factor = ca.MX(P)
        factor[at, other], factor[at, at] = share, (1 - share) * variance[at]
        P = symbolic_covariance_from_udu(factor)
    parts = {
        "memory": model.initial(signals, theta, rig[: len(GEOMETRY)]),
        "linearisation_point": ca.vertcat(*point),
        "x": mean,
        "factor": factor,
        "last": last,
        "output": output_vector(mu=tuning["mu"], mu_std=tuning["mu_std"]),
        "patch_signals": _values_at_rest(SIGNALS, first),
        "angle_slope": ca.vertcat(first["psi"], 0),
        "mean": mean,
        "P_newest": P,
    }
    if "own" in layout.places:
        std = tuning["zero_std"] * slide
        parts |= initial_supervision(measurement_model, first["psi"], first["F_N"], std)
    if "samples" in layout.places:
        # The rows of a window's samples continue those of a cleaned sample.
        rows = layout.places["samples"][1][0]
        parts["samples"] = ca.vertcat(last, ca.DM.zeros(rows - len(CLEAN)))
    return named_function("start", inputs, {"state": layout.join_missing_as_zero(parts)})


def _values_at_rest(names: tuple[str, ...], first: dict[str, ca.MX]) -> ca.MX:
    """The angle and the load of the first sample, 0 for everything else."""
    given = {"psi": first["psi"], "F_N": first["F_N"], "F_N_first": first["F_N"]}
    return ca.vertcat(*(given.get(name, 0) for name in names))
