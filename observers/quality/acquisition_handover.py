"""When and what acquisition hands over to an estimator, and values read from an estimator's state."""

from itertools import combinations_with_replacement

import casadi as ca

from observers.layout import Expression, Layout, Parts, named
from observers.measurement.measurement_model import CLEAN, ROWS, MeasurementModel
from observers.measurement.torque_error import is_known
from observers.quality.mu_and_scale_from_hypotheses import ALLOWED
from observers.quality.outlier_or_ground_change import COUNTS
from observers.udu import factor_of

DECIDED = 0.15
"""Standard deviation of ln mu at which the filter takes over [1]."""
SLIPPERY = (0.015, 0.3)
"""Standard deviations of mu and of ln mu at which friction of a car is known too, whatever s may be [1]:
on ice the contacts slide at once, and nothing tells how stiff they are."""
AGREES = 2.0
"""Deviations of the error of a sample to which the estimator predicts the torque at the handover of
another ground's friction [1]."""


def states_handed_over(states: tuple[str, ...]) -> tuple[str, ...]:
    """States that are handed over; with a gear the stiffness too, which is 1 beside s."""
    handed = ("log_mu", "M_0", *(("stiffness", "gear") if "gear" in states else ()))
    return tuple(name for name in states if name in handed)


def handover_names(states: tuple[str, ...]) -> tuple[str, ...]:
    """What is handed over of `states_handed_over`: means, covariances and their factor.

    Covariances are P_i_j, i <= j; those of the factor U D U', see `observers.udu`, are F_i_j.
    """
    pairs = [f"{one}_{other}" for one, other in covariance_pairs(states)]
    return (*states, *(f"P_{pair}" for pair in pairs), *(f"F_{pair}" for pair in pairs))


def covariance_pairs(states: tuple[str, ...]) -> list[tuple[str, str]]:
    """Every state with itself and with those after it."""
    return list(combinations_with_replacement(states, 2))


def handover_vector(states: tuple[str, ...], means: Parts, covariances: Parts) -> Expression:
    """The vector of `handover_names`."""
    P = ca.SX.zeros(len(states), len(states))
    for (i, one), (j, other) in combinations_with_replacement(enumerate(states), 2):
        P[i, j] = P[j, i] = covariances.get(f"{one}_{other}", 0)
    factor, upper = factor_of(P), [(i, j) for i in range(len(states)) for j in range(i, len(states))]
    entries = [matrix[i, j] for matrix in (P, factor) for i, j in upper]
    return ca.vertcat(*(means[name] for name in states), *entries)


def newest_state(
    parts: Layout, measurement_model: MeasurementModel, state: Expression, name: str
) -> Expression:
    """A state of the newest sample by its name, 0 where there is none."""
    if name not in measurement_model.states:
        return ca.MX(0)
    at, (rows, columns) = parts.places["x"]
    return state[at.start + rows * (columns - 1) + measurement_model.states.index(name)]


def newest_sample_values(parts: Layout, state: Expression, names: tuple[str, ...]) -> Expression:
    """Numbers of the newest sample, cleaned, by their names."""
    at, (rows, columns) = parts.places["samples" if "samples" in parts.places else "last"]
    first = at.start + rows * (columns - 1)
    return ca.vertcat(*(state[first + CLEAN.index(name)] for name in names))


def insert_acquired_state(
    parts: Layout, states: tuple[str, ...], state: Expression, handed: Expression
) -> Expression:
    """An estimator's state with what was acquired (`states_handed_over`), not correlated with the rest.

    A window is emptied: its samples led to states that do not count. The memory of bristles stays as it
    is, whatever mu was.
    """
    after, names = parts.split(state), states_handed_over(states)
    given = named(handover_names(names), handed)
    is_window = "P_newest" in after
    for name in names:
        at = states.index(name)
        after["P_newest" if is_window else "factor"][at, :] = 0
        after["P_newest" if is_window else "factor"][:, at] = 0
        after["x"][at, :] = given[name]
    if is_window:
        after["factor"] = ca.diag(ca.diag(after["P_newest"]))
    for one, other in covariance_pairs(names):
        i, j = states.index(one), states.index(other)
        after["factor"][i, j] = given[f"F_{one}_{other}"]
        if is_window:
            after["P_newest"][i, j] = after["P_newest"][j, i] = given[f"P_{one}_{other}"]
    if "samples" in after:
        after |= _empty_window(after)
    streak = after["counts"][COUNTS.index("streak")]
    for name in ("counts", "monitor", "memory_sensitivity"):
        if name in after:
            after[name] = ca.MX(ca.DM.zeros(*after[name].shape))
    if "psi" in states:
        # Angles that all are rejected count on: after some, the estimated angle begins anew.
        after["counts"][COUNTS.index("streak")] = streak
    return parts.join(after)


def _empty_window(window: Parts) -> dict[str, ca.MX]:
    """A window of the newest states and the last step alone: no measurement, no motion before it."""
    columns = window["x"].shape[1]
    before = window["x"][:, max(columns - 2, 0)]
    samples = ca.MX(window["samples"])
    samples[[ROWS.index("accepted"), ROWS.index("jump")], :] = 0
    samples[[ROWS.index("dt"), ROWS.index("interval")], : columns - 1] = 0
    x = ca.horzcat(ca.repmat(before, 1, columns - 1), window["x"][:, -1])
    return {"x": x, "mean": before, "samples": samples}


def may_hand_over(
    own: Parts, verdict: Parts, output: Parts, limits: Parts, sample: Parts, unsure: Expression,
    zero: Expression, *, memoryless_share: float, gear: bool,
) -> Expression:  # fmt: skip
    """Whether friction is handed over: it is known, and the estimator's patch is as the wheel's.

    sample has M_z [N m], the variance of its noise, `added` [N^2 m^2], and that of the model's `error`
    [1]; unsure is the variance of ln mu [1], zero that of the torque [N m], memoryless_share as in
    `EquivalentPatch`.
    """
    decided = _is_friction_known(verdict, unsure, limits, gear)
    # The estimator begins with a patch free of torque.
    decided = ca.logic_and(ca.logic_and(decided, verdict["wiped"]), own["phase"] == 1)
    if memoryless_share:
        torque = ca.fabs(output["M_z_predicted"] - zero)
        decided = ca.logic_and(decided, torque > memoryless_share * output["M_slide"])
    # After a change of the ground the estimator's patch remembers the old one until it slides.
    return ca.logic_and(
        decided, ca.logic_or(own["again"] != 1, _is_torque_predicted(own, output, sample))
    )


def _is_friction_known(verdict: Parts, unsure: Expression, limits: Parts, gear: bool) -> Expression:
    known = ca.logic_and(unsure < DECIDED**2, verdict["verified"])
    if not gear:
        return known
    most = ca.fmin(SLIPPERY[1], SLIPPERY[0] * ca.exp(-verdict["log_mu"]))
    possible = ca.fabs(verdict["log_gain"]) < ALLOWED * limits["stiffness_std"]
    return ca.logic_or(known, ca.logic_and(unsure < most**2, possible))


def _is_torque_predicted(own: Parts, output: Parts, sample: Parts) -> Expression:
    """Whether the estimator predicts the torque, if one is known."""
    slide, predicted = (output[name] * own["scale"] for name in ("M_slide", "M_z_predicted"))
    off = ca.if_else(is_known(sample["M_z"]), sample["M_z"] - predicted, 0)
    return off**2 <= AGREES**2 * (sample["added"] + sample["error"] * slide**2)
