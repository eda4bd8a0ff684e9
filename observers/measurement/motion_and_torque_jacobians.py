"""Motion and measurement of one sample for any measurement model, linearised.

Each Function is built from the expressions of a measurement model with casadi's Jacobians. M_z enters
linearised, M_z + slopes (x - x_0), with slopes by the states in `slope_states`.
"""

from functools import cache

import casadi as ca

from observers.layout import named, symbols, vector_of
from observers.measurement.measurement_model import CLEAN, RIG, MeasurementModel
from observers.measurement.torque_error import is_known
from observers.protocol import SAMPLE
from observers.tuning import TUNING_FIELDS
from symbolic.named_and_buffered_functions import named_function

TYRE = ("log_mu", "stiffness")
"""States that are parameters of the tyre."""


def state_index(measurement_model: MeasurementModel, name: str = "log_mu") -> int:
    """Index of a state in x."""
    return measurement_model.states.index(name)


def slope_states(measurement_model: MeasurementModel) -> tuple[str, ...]:
    """The states that M_z depends on, in the order of its slopes: the angle first, then the tyre's."""
    return tuple(name for name in ("psi", *TYRE) if name in measurement_model.states)


def _slope_selection_matrix(measurement_model: MeasurementModel) -> ca.SX:
    """Selection matrix (n, d) from the order of `slope_states` to that of the states."""
    names = slope_states(measurement_model)
    selection = ca.SX.zeros(len(measurement_model.states), len(names))
    for j, name in enumerate(names):
        selection[state_index(measurement_model, name), j] = 1
    return selection


def angle_is_state(measurement_model: MeasurementModel) -> bool:
    """True where the patch follows the estimated angle: it is then updated after the correction."""
    return "psi" in measurement_model.states


def _symbols(measurement_model: MeasurementModel, *names: str) -> dict[str, ca.SX]:
    sizes = {
        "x": len(measurement_model.states),
        "M_z": 1,
        "slopes": len(slope_states(measurement_model)),
        "last": len(CLEAN),
        "now": len(CLEAN),
        "rig": len(RIG),
        "tuning": len(TUNING_FIELDS),
    }
    return symbols(ca.SX, **{name: sizes[name] for name in names})


@cache
def build_clean(measurement_model: MeasurementModel) -> ca.Function:
    """(sample, last) -> (now, imputed): the sample as `CLEAN`, and whether a value of it is imputed."""
    inputs = symbols(ca.SX, sample=len(SAMPLE), last=len(CLEAN))
    now, imputed = measurement_model.clean(named(SAMPLE, inputs["sample"]), named(CLEAN, inputs["last"]))
    return named_function("clean", inputs, {"now": vector_of(CLEAN, now), "imputed": imputed})


@cache
def build_linearised_motion(measurement_model: MeasurementModel) -> ca.Function:
    """(x, M_z, slopes, last, now, rig, tuning) -> (x_next, A, Q, b): to the sample now, from the last.

    A (n, n) is the derivative of x_next by x, Q (n,) the variances on the way, b = x_next - A x.
    """
    states = measurement_model.states
    inputs = _symbols(measurement_model, "x", "M_z", "slopes", "last", "now", "rig", "tuning")
    x, M_z, slopes, last, now, rig, tuning = inputs.values()
    after, variance = measurement_model.motion(
        named(states, x), M_z, named(CLEAN, last), named(CLEAN, now), named(RIG, rig),
        named(TUNING_FIELDS, tuning),
    )  # fmt: skip
    x_next = vector_of(states, after)
    A = (
        ca.jacobian(x_next, x)
        + ca.jacobian(x_next, M_z) @ (_slope_selection_matrix(measurement_model) @ slopes).T
    )
    outputs = {"x_next": x_next, "A": A, "Q": vector_of(states, variance), "b": x_next - A @ x}
    return named_function("motion", inputs, {name: ca.densify(part) for name, part in outputs.items()})


@cache
def build_linearised_measurement(measurement_model: MeasurementModel) -> ca.Function:
    """The measurement of the sample now.

    (x, M_z, slopes, now, rig, tuning) -> (innovation, H, weight, expected, huber_scale, independent).
    The last three as in `Measurement`, H (n,) the derivative of expected by x; innovation is measured -
    expected and weight the inverse variance of its error, both 0 where it is missing.
    """
    inputs = _symbols(measurement_model, "x", "M_z", "slopes", "now", "rig", "tuning")
    x, M_z, slopes, now, rig, tuning = inputs.values()
    measurement = measurement_model.measurement(
        named(measurement_model.states, x), M_z, named(CLEAN, now), named(RIG, rig),
        named(TUNING_FIELDS, tuning),
    )  # fmt: skip
    known = is_known(measurement.measured)
    H = ca.jacobian(measurement.expected, x).T
    H = H + _slope_selection_matrix(measurement_model) @ slopes * ca.jacobian(measurement.expected, M_z)
    outputs = {
        "innovation": ca.if_else(known, measurement.measured - measurement.expected, 0),
        "H": ca.densify(H),
        "weight": ca.if_else(known, measurement.precision, 0),
        "expected": measurement.expected,
        "huber_scale": measurement.huber_scale,
        "independent": measurement.independent,
    }
    return named_function("measurement", inputs, outputs)
