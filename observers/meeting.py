"""The model meets a sample: its memory advanced, the torque, and the slopes of the torque.

Where the memory depends on the tyre's states, as under effects that break the parabola, its derivative
is carried along, and the memory is moved to first order to the tyre that it meets. The declared model's
memory depends on neither mu nor k; then nothing needs to be carried.
"""

from functools import cache

import casadi as ca

from observers.linear import TYRE
from observers.sensing import CLEAN, Sensing
from symbolic import SIGNALS, Model

_COORDINATES = dict(zip(TYRE, ("mu", "k"), strict=True))
"""The model's parameter that a state of the tyre moves."""


def tyre(sensing: Sensing) -> tuple[str, ...]:
    """The states that are the tyre's."""
    return tuple(name for name in TYRE if name in sensing.states)


def carries(model: Model, sensing: Sensing) -> bool:
    """True where the memory depends on a state of the tyre."""
    return any(model.remembers(_COORDINATES[name]) for name in tyre(sensing))


def history_fields(model: Model, sensing: Sensing) -> tuple[tuple[str, int, int], ...]:
    """Names and shapes of a memory and what is carried along with it."""
    size, count = model.memory_size, len(tyre(sensing))
    carried = (("carried", size, count), ("held_at", count, 1)) if carries(model, sensing) else ()
    return (("memory", size, 1), *carried)


@cache
def build_meeting(model: Model, sensing: Sensing) -> ca.Function:
    """(*history, signals, tyre, theta, geometry) -> (*history, M_z, slopes).

    history as in `history_fields`; signals as in `symbolic.SIGNALS`; tyre (t,) the states of the tyre;
    theta the nominal parameters; slopes (d,) in the order of `directions`.
    """
    names = [name for name, *_ in history_fields(model, sensing)]
    history = [ca.MX.sym(*field) for field in history_fields(model, sensing)]
    signals, now = ca.MX.sym("signals", len(SIGNALS)), ca.MX.sym("tyre", len(tyre(sensing)))
    theta, geometry = ca.MX.sym("theta", len(model.parameters)), ca.MX.sym("geometry", 2)
    memory, seeds = history[0], ca.MX(model.memory_size, now.numel())
    if len(history) > 1:
        memory, seeds = memory + history[1] @ (now - history[2]), history[1]
    after, carried, M_z, slopes = _linearised(model, sensing)(
        memory, seeds, signals, now, theta, geometry
    )
    inputs = [*history, signals, now, theta, geometry]
    return ca.Function(
        "meeting",
        inputs,
        [after, *((carried, now) if len(history) > 1 else ()), M_z, slopes],
        [*names, "signals", "tyre", "theta", "geometry"],
        [*(f"{name}_next" for name in names), "M_z", "slopes"],
    )


@cache
def _linearised(model: Model, sensing: Sensing) -> ca.Function:
    """(memory, seeds, signals, tyre, theta, geometry) -> (after, carried, M_z, slopes)."""
    size, count = model.memory_size, len(tyre(sensing))
    theta, geometry = ca.MX.sym("theta", len(model.parameters)), ca.MX.sym("geometry", 2)
    everything = ca.MX.sym("everything", size + len(SIGNALS) + count)
    memory, signals, now = ca.vertsplit(everything, [0, size, size + len(SIGNALS), everything.numel()])
    after, M_z = model.step.call([memory, signals, at_tyre(sensing, theta, now), geometry], True, False)
    seeds = ca.MX.sym("seeds", size, count) if carries(model, sensing) else ca.MX(size, count)
    along = ca.vertcat(seeds, ca.MX(len(SIGNALS), count), ca.MX(ca.DM.eye(count)))
    if sensing.turns:
        turning = ca.vertcat(ca.MX(size, 1), ca.DM.eye(len(SIGNALS))[:, 0], ca.MX(count, 1))
        along = ca.horzcat(turning, along)
    slopes = ca.jtimes(ca.vertcat(after, M_z), everything, along)
    carried = slopes[:size, int(sensing.turns) :]
    given = seeds if carries(model, sensing) else ca.MX.sym("seeds", ca.Sparsity(size, count))
    flat = ca.Function(
        "linearised_flat",
        [everything, given, theta, geometry],
        [
            after,
            ca.densify(carried) if carries(model, sensing) else ca.MX(size, count),
            M_z,
            ca.densify(slopes[size, :].T),
        ],
        {"cse": True},
    )
    parts = [
        ca.MX.sym("memory", size),
        given,
        ca.MX.sym("signals", len(SIGNALS)),
        ca.MX.sym("tyre", count),
    ]
    made = flat.call([ca.vertcat(parts[0], parts[2], parts[3]), given, theta, geometry], True, False)
    return ca.Function(
        "linearised",
        [*parts, theta, geometry],
        made,
        ["memory", "seeds", "signals", "tyre", "theta", "geometry"],
        ["after", "carried", "M_z", "slopes"],
    )


@cache
def build_torque(model: Model, sensing: Sensing) -> ca.Function:
    """(memory, seen, tyre, theta, geometry) -> (M_z, slopes), of a memory already advanced.

    Only where nothing is carried and the angle is no state.
    """
    memory, seen = ca.MX.sym("memory", model.memory_size), ca.MX.sym("seen", len(SIGNALS))
    now = ca.MX.sym("tyre", len(tyre(sensing)))
    theta, geometry = ca.MX.sym("theta", len(model.parameters)), ca.MX.sym("geometry", 2)
    M_z = model.torque.call([memory, seen, at_tyre(sensing, theta, now), geometry], True, False)[0]
    return ca.Function(
        "torque_along",
        [memory, seen, now, theta, geometry],
        [M_z, ca.densify(ca.jacobian(M_z, now).T)],
        ["memory", "seen", "tyre", "theta", "geometry"],
        ["M_z", "slopes"],
        {"cse": True},
    )


def at_tyre(sensing: Sensing, theta: ca.MX, now: ca.MX) -> ca.MX:
    """The parameter vector with mu, and k where it is a state, as the states have them."""
    stiff = theta[1] * now[1] if "stiffness" in sensing.states else theta[1]
    return ca.vertcat(now[0], stiff, theta[2:])


def states_of_tyre(sensing: Sensing, x: ca.MX) -> ca.MX:
    """The rows of x, (n,) or (n, N), that are the tyre's."""
    return x[[sensing.states.index(name) for name in tyre(sensing)], :]


def signals_of(sensing: Sensing, x: ca.MX, now: ca.MX) -> ca.MX:
    """What the patch sees of a sample, or of a row of them: its own angle where that is a state."""
    seen = {name: now[CLEAN.index(name), :] for name in SIGNALS}
    if sensing.turns:
        seen |= {name: x[sensing.states.index(name), :] for name in ("psi", "psi_dot")}
    return ca.vertcat(*(seen[name] for name in SIGNALS))
