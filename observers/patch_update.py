"""The model meets a sample: its memory advanced, the torque, and the slopes of the torque.

The memory of the patch is no state of its own. It is what the history made of it under the tyre that the
observer believes in.

The exact patch keeps it in units in which it depends on neither mu nor k, so that a correction of mu
corrects all of the past: exact for a ground that stays the same, however late it is known. Where the
memory depends on the tyre, as that of bristles does, its derivative by the tyre is carried along exactly
and the memory moves with the corrections; and when mu walks, what the ground did before does not: of the
derivative only that part stays which the past mu still shares with the present one, the regression
P (P + Q)^-1 of the one on the other. So bristles, `Model(discretised=True)`, suit a ground that changes
under the wheel from second to second.
"""

from functools import cache

import casadi as ca

from observers.linearisation import TYRE
from observers.measurement_model import CLEAN, MeasurementModel
from symbolic import SIGNALS, Model

Parts = tuple[tuple[str, int, int], ...]
PARAMETERS = dict(zip(TYRE, ("mu", "k"), strict=True))
"""The model's parameter that a state of the tyre moves."""


def tyre(measurement_model: MeasurementModel) -> tuple[str, ...]:
    """The states that are the tyre's."""
    return tuple(name for name in TYRE if name in measurement_model.states)


def history_fields(model: Model, measurement_model: MeasurementModel) -> Parts:
    """Names and shapes: memory and, where it depends on the tyre, its derivative and that tyre."""
    size, count = model.memory_size, len(tyre(measurement_model))
    if not carries(model, measurement_model):
        return (("memory", size, 1),)
    return (("memory", size, 1), ("carried", size, count), ("held_at", count, 1))


@cache
def carries(model: Model, measurement_model: MeasurementModel) -> bool:
    """True where the memory depends on what the states say of the tyre."""
    return any(model.memory_depends_on(PARAMETERS[name]) for name in tyre(measurement_model))


@cache
def build_meeting(model: Model, measurement_model: MeasurementModel) -> ca.Function:
    """(*history, signals, tyre, theta, geometry) -> (*history, seen, M_z, slopes).

    history as in `history_fields`; signals as in `symbolic.SIGNALS`, seen what reaches the patch;
    tyre (t,) is mu and, where it is a state, k over its nominal value; theta the nominal parameters;
    slopes (d,) of M_z by the angle, where that is a state, and by the tyre.
    """
    size, count = model.memory_size, len(tyre(measurement_model))
    theta, geometry = ca.MX.sym("theta", len(model.parameters)), ca.MX.sym("geometry", 2)
    everything = ca.MX.sym("everything", size + len(SIGNALS) + count)
    memory, signals, now = ca.vertsplit(everything, [0, size, size + len(SIGNALS), everything.numel()])
    at = at_tyre(measurement_model, theta, now)
    after, seen = model.advance.call([memory, signals, at, geometry], True, False)
    M_z = model.torque.call([after, seen, at, geometry], True, False)[0]
    seeds = ca.MX.sym("seeds", size, count) if carries(model, measurement_model) else ca.MX(size, count)
    along = ca.vertcat(seeds, ca.MX(len(SIGNALS), count), ca.MX(ca.DM.eye(count)))
    if measurement_model.turns:
        turning = ca.vertcat(ca.MX(size, 1), ca.DM.eye(len(SIGNALS))[:, 0], ca.MX(count, 1))
        along = ca.horzcat(turning, along)
    slopes = ca.jtimes(ca.vertcat(after, M_z), everything, along)
    carried = [seeds] if carries(model, measurement_model) else []
    flat = ca.Function(
        "flat",
        [everything, *carried, theta, geometry],
        [
            after,
            *(slopes[:size, int(measurement_model.turns) :] for _ in carried),
            seen,
            M_z,
            slopes[size, :].T,
        ],
        {"cse": True},
    )
    history = [ca.MX.sym(*field) for field in history_fields(model, measurement_model)]
    signals, now = ca.MX.sym("signals", len(SIGNALS)), ca.MX.sym("tyre", count)
    moved = moved_memory(history, now)
    after, *carried, seen, M_z, slopes = flat.call(
        [ca.vertcat(moved, signals, now), *history[1:2], theta, geometry], True, False
    )
    held_at = [now for _ in carried]
    names = [name for name, *_ in history_fields(model, measurement_model)]
    return ca.Function(
        "meeting",
        [*history, signals, now, theta, geometry],
        [after, *map(ca.densify, carried), *held_at, seen, M_z, ca.densify(slopes)],
        [*names, "signals", "tyre", "theta", "geometry"],
        [*(f"{name}_next" for name in names), "seen", "M_z", "slopes"],
    )


@cache
def build_torque(model: Model, measurement_model: MeasurementModel) -> ca.Function:
    """(*history, seen, tyre, theta, geometry) -> (M_z, slopes), of a history already advanced.

    slopes (t,) are by the tyre alone.
    """
    history = [ca.MX.sym(*field) for field in history_fields(model, measurement_model)]
    seen, now = ca.MX.sym("seen", len(SIGNALS)), ca.MX.sym("tyre", len(tyre(measurement_model)))
    theta, geometry = ca.MX.sym("theta", len(model.parameters)), ca.MX.sym("geometry", 2)
    at = at_tyre(measurement_model, theta, now)
    M_z = model.torque.call([moved_memory(history, now), seen, at, geometry], True, False)[0]
    return ca.Function(
        "torque_along",
        [*history, seen, now, theta, geometry],
        [M_z, ca.densify(ca.jacobian(M_z, now).T)],
        [
            *(name for name, *_ in history_fields(model, measurement_model)),
            "seen",
            "tyre",
            "theta",
            "geometry",
        ],
        ["M_z", "slopes"],
        {"cse": True},
    )


def moved_memory(history: list[ca.MX], now: ca.MX) -> ca.MX:
    """The memory at the tyre `now`, to first order where it depends on it."""
    if len(history) == 1:
        return history[0]
    memory, carried, held_at = history
    return memory + carried @ (now - held_at)


def kept_share(measurement_model: MeasurementModel, P: ca.MX, Q: ca.MX, x: ca.MX) -> ca.MX:
    """(t, t) by which `carried` is multiplied from the right when the tyre's states walk by Q (n,).

    P (n, n) is their covariance and x (n,) the states, before the walk.
    """
    at = [measurement_model.states.index(name) for name in tyre(measurement_model)]
    before, walk = P[at, at], ca.diag(Q[at])
    # Nothing is lost where nothing walks, not even where nothing is known.
    total = before + walk
    if len(at) == 1:
        share = ca.if_else(walk > 0, before / ca.if_else(walk > 0, total, 1), 1)
    else:
        determinant = total[0, 0] * total[1, 1] - total[0, 1] * total[1, 0]
        inverse = ca.blockcat([[total[1, 1], -total[0, 1]], [-total[1, 0], total[0, 0]]]) / determinant
        share = ca.if_else(ca.trace(walk) > 0, before @ inverse, ca.DM.eye(2))
    # By the states first, then from there to the tyre's own numbers.
    scale = tyre_by_state(measurement_model, x)
    return ca.diag(scale) @ share @ ca.diag(1 / scale) if len(at) > 1 else share


def at_tyre(measurement_model: MeasurementModel, theta: ca.MX, now: ca.MX) -> ca.MX:
    """The parameter vector with mu, and k where it is a state, as the states have them."""
    stiff = theta[1] * now[1] if "stiffness" in measurement_model.states else theta[1]
    return ca.vertcat(now[0], stiff, theta[2:])


def tyre_of(measurement_model: MeasurementModel, x: ca.MX) -> ca.MX:
    """mu, and k over its nominal value where it is a state, of states (n,) or a row of them (n, N)."""
    rows = [x[measurement_model.states.index(name), :] for name in tyre(measurement_model)]
    return ca.vertcat(ca.exp(rows[0]), *rows[1:])


def tyre_by_state(measurement_model: MeasurementModel, x: ca.MX) -> ca.MX:
    """The derivative of `tyre_of` by its own states, element by element."""
    now = tyre_of(measurement_model, x)
    return ca.vertcat(now[0, :], ca.MX.ones(now.shape[0] - 1, now.shape[1]))


def by_states(measurement_model: MeasurementModel, slopes: ca.MX, x: ca.MX) -> ca.MX:
    """Slopes of `build_meeting` turned into slopes by the states."""
    scale = tyre_by_state(measurement_model, x)
    if measurement_model.turns:
        scale = ca.vertcat(ca.MX.ones(1, scale.shape[1]), scale)
    return slopes * scale


def signals_of(measurement_model: MeasurementModel, x: ca.MX, now: ca.MX) -> ca.MX:
    """What the patch sees of a sample: its own angle where that is a state."""
    seen = {name: now[CLEAN.index(name), :] for name in SIGNALS}
    if measurement_model.turns:
        seen |= {name: x[measurement_model.states.index(name), :] for name in ("psi", "psi_dot")}
    return ca.vertcat(*(seen[name] for name in SIGNALS))
