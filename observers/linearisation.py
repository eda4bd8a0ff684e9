"""Linear algebra of one sample for any measurement model: motion, measurement and correction.

Each is built from the expressions of `observers.measurement_model` with casadi's Jacobians; M_z
enters linearised, M_z + slopes (x - x_0), where slopes are by the angle, where that is a state, and by
the tyre's states.
"""

from functools import cache

import casadi as ca

from observers.layout import named
from observers.measurement_model import CLEAN, RIG, MeasurementModel, is_known
from observers.protocol import SAMPLE
from observers.tuning import BELIEFS
from observers.udu import measured, moved

TYRE = ("log_mu", "stiffness")
"""States that the torque of the patch depends on beside the angle."""


def directions(measurement_model: MeasurementModel) -> tuple[str, ...]:
    """The states that M_z depends on, in the order of its slopes."""
    return ("psi",) * measurement_model.turns + tuple(
        name for name in TYRE if name in measurement_model.states
    )


def _places(measurement_model: MeasurementModel) -> ca.SX:
    """Puts slopes in the order of `directions` at their states, (n, d)."""
    names = directions(measurement_model)
    places = ca.SX.zeros(len(measurement_model.states), len(names))
    for j, name in enumerate(names):
        places[measurement_model.states.index(name), j] = 1
    return places


def _symbols(measurement_model: MeasurementModel, *names: str) -> list[ca.SX]:
    sizes = {
        "x": len(measurement_model.states),
        "M_z": 1,
        "slopes": len(directions(measurement_model)),
        "last": len(CLEAN),
        "now": len(CLEAN),
        "rig": len(RIG),
        "beliefs": len(BELIEFS),
    }
    return [ca.SX.sym(name, sizes[name]) for name in names]


@cache
def build_clean(measurement_model: MeasurementModel) -> ca.Function:
    """(sample, last) -> (now, held): the sample as `CLEAN`, held where a sensor gave none."""
    sample, last = ca.SX.sym("sample", len(SAMPLE)), ca.SX.sym("last", len(CLEAN))
    now, held = measurement_model.clean(named(SAMPLE, sample), named(CLEAN, last))
    clean = ca.vertcat(*(now[name] for name in CLEAN))
    return ca.Function("clean", [sample, last], [clean, held], ["sample", "last"], ["now", "held"])


@cache
def build_motion(measurement_model: MeasurementModel) -> ca.Function:
    """(x, M_z, slopes, last, now, rig, beliefs) -> (x_next, A, Q, b): to the sample now, from the last.

    A (n, n) is the derivative of x_next by x, Q (n,) the variances on the way, b = x_next - A x.
    """
    names = ("x", "M_z", "slopes", "last", "now", "rig", "beliefs")
    x, M_z, slopes, last, now, rig, beliefs = inputs = _symbols(measurement_model, *names)
    after, variance = measurement_model.motion(
        named(measurement_model.states, x), M_z, named(CLEAN, last), named(CLEAN, now), named(RIG, rig),
        named(BELIEFS, beliefs),
    )  # fmt: skip
    x_next = ca.vertcat(*(after[name] for name in measurement_model.states))
    A = ca.jacobian(x_next, x) + ca.jacobian(x_next, M_z) @ (_places(measurement_model) @ slopes).T
    Q = ca.vertcat(*(variance[name] for name in measurement_model.states))
    made = [ca.densify(part) for part in (x_next, A, Q, x_next - A @ x)]
    return ca.Function("motion", inputs, made, list(names), ["x_next", "A", "Q", "b"])


@cache
def build_reading(measurement_model: MeasurementModel) -> ca.Function:
    """(x, M_z, slopes, now, rig, beliefs) -> (innovation, H, weight, expected, ordinary), for now.

    expected is what x makes of the measurement, H (n,) its derivative by x; innovation what was measured
    less that, 0 where nothing was; weight the inverse variance of its error, 0 for nothing; ordinary the
    square of an error of ordinary size.
    """
    names = ("x", "M_z", "slopes", "now", "rig", "beliefs")
    x, M_z, slopes, now, rig, beliefs = inputs = _symbols(measurement_model, *names)
    reading = measurement_model.reading(
        named(measurement_model.states, x),
        M_z,
        named(CLEAN, now),
        named(RIG, rig),
        named(BELIEFS, beliefs),
    )
    known = is_known(reading.measured)
    H = ca.jacobian(reading.expected, x).T
    H = H + _places(measurement_model) @ slopes * ca.jacobian(reading.expected, M_z)
    innovation = ca.if_else(known, reading.measured - reading.expected, 0)
    weight = ca.if_else(known, reading.precision, 0)
    return ca.Function(
        "reading",
        inputs,
        [innovation, ca.densify(H), weight, reading.expected, reading.ordinary],
        list(names),
        ["innovation", "H", "weight", "expected", "ordinary"],
    )


@cache
def build_moved(states: int) -> ca.Function:
    """(factor, A, Q) -> factor of A P A' + diag(Q)."""
    factor, A, Q = (
        ca.SX.sym("factor", states, states),
        ca.SX.sym("A", states, states),
        ca.SX.sym("Q", states),
    )
    return ca.Function(
        "moved", [factor, A, Q], [moved(factor, A, Q)], ["factor", "A", "Q"], ["factor_next"]
    )


@cache
def build_measured(states: int) -> ca.Function:
    """(factor, H, weight) -> (factor_next, K, share), share being 1 / (R + H P H'), 0 for none."""
    factor, H = ca.SX.sym("factor", states, states), ca.SX.sym("H", states)
    weight = ca.SX.sym("weight")
    return ca.Function(
        "measured",
        [factor, H, weight],
        list(measured(factor, H, weight)),
        ["factor", "H", "weight"],
        ["factor_next", "K", "share"],
    )
