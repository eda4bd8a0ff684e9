"""The pieces of a window's step as casadi Functions of scalars, one sample each.

They are cut from `observers.mhe_step` and `observers.mhe_terms` so that C may loop over the samples: the
same terms, the same filter forth and back. `templates/window.c` calls them in the same order.
"""

from collections.abc import Mapping
from typing import Any

import casadi as ca

from observers.base import flags, on_bound, projected, says
from observers.embedded.scalarise import scalars
from observers.innovation_gate import COUNTS, build_gate
from observers.linearisation import build_clean, build_motion, build_reading
from observers.measurement_model import CLEAN, RIG
from observers.mhe import Mhe
from observers.mhe_solver import build_back, build_update
from observers.mhe_terms import build_counted
from observers.patch_update import by_states
from observers.protocol import SAMPLE
from observers.tuning import BELIEFS
from symbolic import full_slide_torque

ROW = ("F_N", "dt", "M_z", "believed", "jump")
"""What is kept of a sample: all that its terms depend on where the angle is known."""


def window_functions(observer: Mhe) -> list[ca.Function]:
    """What C calls: begin_window, clean, limit, predict, judge, forth, back and say."""
    at = len(observer.model.parameters)
    numbers = {
        "rig": observer.constants[at : at + len(RIG)],
        "beliefs": observer.constants[at + len(RIG) :],
    }
    makers = (_begin, _clean, _limit, _predict, _judge, _forth, _back, _say)
    return [_with_numbers(maker(observer), numbers) for maker in makers]


def made_size(observer: Mhe) -> int:
    """Length of what the filter leaves at a sample."""
    n = len(observer.states)
    return n + n * n + n + 1 + n


def prior_variance_of(observer: Mhe) -> float:
    """Variance of ln mu before anything is known of the ground."""
    return float(observer.tuning.log_std**2)


def _with_numbers(function: ca.Function, numbers: Mapping[str, Any]) -> ca.Function:
    used = {name: numbers[name] for name in function.name_in() if name in numbers}
    return scalars(function.name(), function, used)


def _symbols(observer: Mhe, *names: str) -> list[ca.MX]:
    n = len(observer.states)
    shapes = {
        "sample": (len(SAMPLE), 1), "last": (len(CLEAN), 1), "now": (len(CLEAN), 1), "x": (n, 1),
        "mean": (n, 1), "factor": (n, n), "P": (n, n), "torque": (3, 1), "row": (len(ROW), 1),
        "next": (len(ROW), 1), "counts": (len(COUNTS), 1), "made": (made_size(observer), 1),
        "costate": (n, 1), "newest": (n, 1), "judged": (5, 1), "held": (1, 1), "rig": (len(RIG), 1),
        "beliefs": (len(BELIEFS), 1),
    }  # fmt: skip
    return [ca.MX.sym(name, *shapes[name]) for name in names]


def _function(name: str, inputs: list[ca.MX], outputs: list[Any]) -> ca.Function:
    outputs = [ca.densify(ca.vec(ca.MX(output))) for output in outputs]
    return ca.Function(
        name, inputs, outputs, [s.name() for s in inputs], [f"o{i}" for i in range(len(outputs))]
    )


def _row(row: ca.MX) -> tuple[ca.MX, dict[str, ca.MX]]:
    """A cleaned sample of a row, and the row by name."""
    named = dict(zip(ROW, ca.vertsplit(row), strict=True))
    return ca.vertcat(*(named.get(name, ca.MX(0)) for name in CLEAN)), named


def _slopes(observer: Mhe, torque: ca.MX, x: ca.MX) -> ca.MX:
    """Slopes of the torque by the states of the tyre, from those by mu and by k."""
    by_tyre = torque[1:3] if "stiffness" in observer.states else torque[1]
    return by_states(observer.measurement_model, by_tyre, x)


def _begin(observer: Mhe) -> ca.Function:
    """(sample) -> mean, factor, last."""
    sample, rig = _symbols(observer, "sample", "rig")
    given = dict(zip(SAMPLE, ca.vertsplit(sample), strict=True))
    nothing: Any = _NoSample()
    slide: Any = full_slide_torque(given["F_N"], rig[0])
    prior = observer.measurement_model.prior(observer.tuning, nothing, slide)
    mean, std = (ca.vertcat(*(prior[name][i] for name in observer.states)) for i in range(2))
    last = ca.vertcat(*(given[n] if n in ("psi", "F_N") else 0 for n in CLEAN))
    return _function("begin_window", [sample, rig], [mean, ca.diag(std**2), last])


class _NoSample:
    """Where the angle is known, a prior asks nothing of the first sample."""


def _clean(observer: Mhe) -> ca.Function:
    """(sample, last) -> the sample cleaned, and whether something is held."""
    sample, last = _symbols(observer, "sample", "last")
    return _function(
        "clean", [sample, last], list(build_clean(observer.measurement_model)(sample, last))
    )


def _limit(observer: Mhe) -> ca.Function:
    """(x) -> within bounds."""
    x, beliefs = _symbols(observer, "x", "beliefs")
    return _function("limit", [x, beliefs], [projected(observer.measurement_model, x, beliefs)])


def _motion(observer: Mhe, x: ca.MX, last: ca.MX, now: ca.MX, rig: ca.MX, beliefs: ca.MX) -> Any:
    """x_next, A, Q and b; the torque does not move the states where the angle is known."""
    move = build_motion(observer.measurement_model)
    return move(x, 0, ca.DM(move.size1_in("slopes"), 1), last, now, rig, beliefs)


def _predict(observer: Mhe) -> ca.Function:
    """(x, P, last, now) -> newest, P at it; see `Horizon.predict`."""
    x, P, last, now, rig, beliefs = inputs = _symbols(
        observer, "x", "P", "last", "now", "rig", "beliefs"
    )
    newest, A, Q, _ = _motion(observer, x, last, now, rig, beliefs)
    return _function(
        "predict",
        inputs,
        [projected(observer.measurement_model, newest, beliefs), A @ P @ A.T + ca.diag(Q)],
    )


def _judge(observer: Mhe) -> ca.Function:
    """(newest, torque, now, P, counts) -> (believed, reset, run, missing, expected), counts."""
    names = ("newest", "torque", "now", "P", "counts", "rig", "beliefs")
    newest, torque, now, P, counts, rig, beliefs = inputs = _symbols(observer, *names)
    slopes = _slopes(observer, torque, newest)
    read = build_reading(observer.measurement_model)(newest, torque[0], slopes, now, rig, beliefs)
    innovation, H, weight, expected, ordinary = read
    verdict = build_gate()(innovation, ca.dot(H, P @ H), weight, ordinary, counts, beliefs)
    believed, reset, run, after = verdict
    return _function("judge", inputs, [ca.vertcat(believed, reset, run, weight <= 0, expected), after])


def _forth(observer: Mhe) -> ca.Function:
    """(mean, factor, x, torque, row, next) -> mean, factor, what is made; see `Horizon.terms`."""
    names = ("mean", "factor", "x", "torque", "row", "next", "rig", "beliefs")
    mean, factor, x, torque, row, after, rig, beliefs = inputs = _symbols(observer, *names)
    slopes = _slopes(observer, torque, x)
    (now, kept), (coming, then) = _row(row), _row(after)
    columns = ca.vertcat(now, kept["believed"], kept["jump"])
    z, H, weight = build_counted(observer.measurement_model)(x, torque[0], slopes, columns, rig, beliefs)
    _, A, Q, b = _motion(observer, x, now, coming, rig, beliefs)
    Q = ca.vertcat(Q[0] + then["jump"], Q[1:])
    update = build_update(len(observer.states))(mean, factor, z, H, weight, A, b, Q)
    mean_next, factor_next, filtered, spread, K, score = update
    return _function(
        "forth", inputs, [mean_next, factor_next, ca.vertcat(filtered, ca.vec(spread), K, score, H)]
    )


def _back(observer: Mhe) -> ca.Function:
    """(costate, made, row, next) -> costate before, smoothed x within bounds."""
    n = len(observer.states)
    costate, made, row, after, rig, beliefs = inputs = _symbols(
        observer, "costate", "made", "row", "next", "rig", "beliefs"
    )
    x, spread, K, score, H = ca.vertsplit(
        made, [0, n, n + n * n, 2 * n + n * n, 2 * n + n * n + 1, made.numel()]
    )
    _, A, _, _ = _motion(observer, x, _row(row)[0], _row(after)[0], rig, beliefs)
    before, smoothed = build_back(n)(costate, x, ca.reshape(spread, n, n), H, K, score, A)
    return _function("back", inputs, [before, projected(observer.measurement_model, smoothed, beliefs)])


def _say(observer: Mhe) -> ca.Function:
    """(x, P, newest, judged, held) -> what is said."""
    names = ("x", "P", "newest", "judged", "held", "beliefs")
    x, P, newest, judged, held, beliefs = inputs = _symbols(observer, *names)
    believed, reset, _, missing, expected = ca.vertsplit(judged)
    status = flags(
        missing=missing, held=held, rejected=ca.logic_not(believed), reset=reset,
        bound=on_bound(x[0], beliefs), unsettled=(x[0] - newest[0]) ** 2 > P[0, 0],
    )  # fmt: skip
    return _function("say", inputs, [ca.vertcat(says(x[0], P[0, 0]), expected, status)])
