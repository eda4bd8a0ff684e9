"""Hypotheses about the ratio of mu to k, each with an exact filter of what is left.

The torque of the declared patch is homogeneous of degree 1 in (mu, k), so that under a hypothesis it is
linear in what is left,

    M_z + M_0 = s g_i(psi) + M_0,    g_i the torque at mu = RATIOS[i] and the declared k,

and a Kalman filter of s and M_0 linearises nothing. Two more states are the share in which the patch was
twisted before the first sample, see `observers.quality.hysteresis_branches`, and, with a steering gear,
the level of its dry friction over the declared one. s is the stiffness over the declared one, and s
RATIOS[i] is mu. The hypotheses are weighed by the likelihood of their innovations [Magill 1965]; their
mixture is a Gaussian sum [Alspach 1972]. Without a prior of s the same mixture tells whether the torque
has the scale that k, half-length and load allow: a torque in another unit, or before a gear, is s times
too large.
"""

from collections.abc import Mapping
from functools import cache
from itertools import combinations_with_replacement

import casadi as ca
import numpy as np

from observers.layout import Expression, Layout, Parts, named, symbols, vector_of
from observers.measurement.torque_error import SENSOR, forgetting_factor, has_stated_model_error
from observers.quality.hysteresis_branches import (
    FORGETTING_SAMPLES,
    PATHS,
    POINTS,
    TRACK,
    build_branch_torque,
    build_new_ground_branches,
)
from observers.udu import update_covariance
from symbolic import full_slide_torque
from symbolic.named_and_buffered_functions import named_function

RATIOS = np.geomspace(0.012, 6.0, 14)
"""Hypotheses about mu at the declared k [1]."""
GRID_SPACING = float(np.log(RATIOS[1] / RATIOS[0]))
"""Distance of two hypotheses in ln mu [1]."""
RELATIVE_SENSOR = 0.01
"""Noise that grows with the torque, as a share of the greatest torque so far [1]."""
VAGUE = 10.0
"""Standard deviation of s before any torque [1]."""
ROBUST = 4.0
"""Normalised innovation beyond which the cost of a sample grows linearly, as in Huber's loss [1]."""
MAX_MODEL_ERROR = 0.2
"""Upper limit of the model error that is assumed [1]."""
NOISIER = 4.0
"""Squares of the noise, over its variance, that a sample may have: a sensor is twice as noisy [1]."""
SETTINGS = (
    *("mu", "mu_std", "stiffness_std", "error", "psi_noise", "zero_std"),
    *("mu_floor", "least", "greatest", "explained"),
)
"""Fields of the tuning that acquisition and supervision need."""
TWIST_STD = 0.5
"""Standard deviation of the share in which the patch was twisted before the first sample, over s [1]."""
RESTART_STD = 0.1
"""Prior standard deviation of s in an acquisition that follows one which determined s [1]."""
PATH_ERROR = 0.05
"""Least error of a model on a path that began on another ground [1]."""


def hypothesis_states(gear: bool) -> tuple[str, ...]:
    """What a hypothesis leaves open, in the order of the factor of its covariance.

    s times the share of the twist [1], where there is a gear its friction over the declared one [1],
    M_0 [N m], and s [1], which is last: the others given s are then entries of the factor.
    """
    return ("twist", *(("gear",) if gear else ()), "zero", "gain")


def udu_entry_name(one: str, other: str) -> str:
    """Name of an entry of the factor U D U' of the covariance of a hypothesis."""
    return f"D_{one}" if one == other else f"U_{one}_{other}"


def hypothesis_variance(
    parts: Mapping[str, Expression], name: str, given: tuple[str, ...] = ()
) -> Expression:
    """Variance of an unknown; `given` are those after it whose values are known."""
    order = hypothesis_states(gear="gear" in parts)
    others = [other for other in order[order.index(name) + 1 :] if other not in given]
    return sum(
        (parts[udu_entry_name(name, o)] ** 2 * parts[udu_entry_name(o, o)] for o in others),
        parts[udu_entry_name(name, name)],
    )


def hypothesis_fields(gear: bool) -> tuple[str, ...]:
    """Numbers of a hypothesis.

    Logarithm of its likelihood, the unknowns with the factor of their covariance, see `observers.udu`,
    and the torque that the twist may make [N m].
    """
    pairs = combinations_with_replacement(hypothesis_states(gear), 2)
    return (
        "log_likelihood",
        *hypothesis_states(gear),
        *(udu_entry_name(*pair) for pair in pairs),
        "left",
    )


@cache
def search_layout(gear: bool) -> Layout:
    """State of the acquisition."""
    hypotheses = (len(hypothesis_fields(gear)), len(RATIOS))
    return Layout.of(track=len(TRACK), points=(POINTS, PATHS), hypotheses=hypotheses)


def acquisition_settings(tuning: Parts, misfit: float, again: Expression) -> Expression:
    """Values of the tuning in the order of `SETTINGS`; misfit is the model's least error [1].

    again is 1 where the ground has changed: what the patch was before is then known roughly. An error
    that is stated for no turn is that of the noise, `Tuning.error_travel`.
    """
    error = tuning["error"]
    error = ca.if_else(has_stated_model_error(tuning), error, ca.fmin(error, tuning["noise"]))
    least = ca.if_else(again, ca.fmax(misfit, PATH_ERROR), misfit)
    return vector_of(SETTINGS, {**tuning, "error": ca.fmax(least, error)})


@cache
def build_hypothesis_search_start(gear: bool = False) -> ca.Function:
    """The search at a place of rest: (psi, gain, gain_std, zero, zero_std) -> search.

    psi [rad]; mean and standard deviation of s [1] and of M_0 [N m]; standard deviation of the gear's
    friction over the declared one, whose mean is 1, is a further input with a gear [1].
    """
    spread = {"spread": 1} if gear else {}
    inputs = symbols(ca.MX, psi=1, gain=1, gain_std=1, zero=1, zero_std=1, **spread)
    psi, gain, gain_std, zero, zero_std, *gear_std = inputs.values()
    names = hypothesis_fields(gear)
    part: dict[str, Expression] = dict.fromkeys(names, 0)
    part |= {"gain": gain, "zero": zero, "D_gain": gain_std**2, "D_zero": zero_std**2}
    part |= {"gear": 1, "D_gear": gear_std[0] ** 2} if gear else {}
    part["D_twist"] = TWIST_STD**2
    track: dict[str, Expression] = dict.fromkeys(TRACK, 0)
    track |= {"count": 1, "count_slid": 1, "extreme": psi, "origin": psi}
    parts = {
        "track": vector_of(TRACK, track),
        "points": ca.repmat(psi, POINTS, PATHS),
        "hypotheses": ca.repmat(vector_of(names, part), 1, len(RATIOS)),
    }
    return named_function("search_start", inputs, {"search": search_layout(gear).join(parts)})


@cache
def build_hypothesis_search_restart(gear: bool = False) -> ca.Function:
    """The search anew: (search, M_z, slide, tyre, gain, gain_std, zero, zero_std) -> search.

    M_z, slide and tyre are as for `build_new_ground_branches`. The hypotheses begin anew about s and the
    torque's zero [N m], which are known.
    """
    layout = search_layout(gear)
    inputs = symbols(
        ca.MX, search=layout.size, M_z=1, slide=1, tyre=3, gain=1, gain_std=1, zero=1, zero_std=1,
        **({"spread": 1} if gear else {}),
    )  # fmt: skip
    search, M_z, slide, tyre, gain, *known = inputs.values()
    track, points = build_new_ground_branches()(layout.split(search)["track"], M_z, slide, tyre)
    fresh = layout.split(build_hypothesis_search_start(gear)(0, gain, *known))
    hypotheses = ca.MX(fresh["hypotheses"])
    hypotheses[hypothesis_fields(gear).index("twist"), :] = gain / 2
    parts = {"track": track, "points": points, "hypotheses": hypotheses}
    return named_function("restart", inputs, {"search_next": layout.join(parts)})


@cache
def build_torque_error_variance() -> ca.Function:
    """Size of a torque less its noise, variance of its error, and the squares that noise explains.

    M_z and the greatest torque so far, reach, are in N m, the load in N, a in m, the variance added of
    the torque's noise in N^2 m^2; share is of an independent sample, error the model's as a share of the
    torque [1].
    """
    inputs = symbols(ca.SX, M_z=1, F_N=1, a=1, added=1, reach=1, share=1, error=1)
    M_z, F_N, a, added, reach, share, error = inputs.values()
    noise = SENSOR * full_slide_torque(F_N, a)
    white = ca.fmax(added, noise**2) + (RELATIVE_SENSOR * reach) ** 2
    variance = white + (ca.fmin(error, 1) * reach) ** 2 / share
    size = ca.fmax(ca.fabs(M_z) - 2 * noise, 0)
    outputs = {"size": size, "variance": variance, "noisy": NOISIER * white / variance}
    return named_function("torque_error", inputs, outputs)


@cache
def build_one_hypothesis_update(gear: bool = False) -> ca.Function:
    """One hypothesis after a torque: (part, free, slid, measured, variance, share, dry) -> part_next.

    part is in the order of `hypothesis_fields`; free and slid are the torques at s = 1 of a patch that
    was free of torque before the first sample, and of one that slid [N m]; variance is that of the
    measurement's error [N^2 m^2], share that of an independent sample; dry is the torque of the gear's
    declared friction [N m], which there is with a gear alone.
    """
    names = hypothesis_fields(gear)
    inputs = symbols(ca.SX, part=len(names), free=1, slid=1, measured=1, variance=1, share=1)
    part, free, slid, measured, variance, share = inputs.values()
    older, was = forgetting_factor(share, FORGETTING_SAMPLES), named(names, part)
    order = hypothesis_states(gear)
    # The measured torque by each unknown.
    by: dict[str, Expression] = {"gain": free, "zero": 1, "twist": slid - free}
    if gear:
        inputs["dry"] = by["gear"] = ca.SX.sym("dry")
    H, mean, factor = vector_of(order, by), vector_of(order, was), ca.SX.zeros(len(order), len(order))
    for (i, one), (j, other) in combinations_with_replacement(enumerate(order), 2):
        factor[i, j] = was[udu_entry_name(one, other)] / (older if i == j else 1)
    f = (ca.triu(factor, False) + ca.SX.eye(len(order))).T @ H
    spread = ca.dot(f, ca.diag(factor) * f)
    innovation = measured - ca.dot(mean, H)
    size = ca.fabs(innovation) / ca.sqrt(spread + variance)
    # Huber's loss, and as a variance that grows with the innovation.
    within = ca.fmin(size, ROBUST)
    cost = within * (size - within / 2)
    variance = variance + (spread + variance) * (size - within) / ROBUST
    factor, K, share_left = update_covariance(factor, H, 1 / variance)
    log_likelihood = older * was["log_likelihood"] - cost + ca.log(share_left * variance) / 2
    after = {"log_likelihood": log_likelihood, **named(order, mean + K * innovation)}
    for (i, one), (j, other) in combinations_with_replacement(enumerate(order), 2):
        after[udu_entry_name(one, other)] = factor[i, j]
    after["D_gain"] = ca.fmax(after["D_gain"], 1e-9)
    # A twist that moves the torque no longer would be forgotten without a limit, the zero with it.
    after["D_twist"] = ca.fmin(after["D_twist"], TWIST_STD**2)
    may_be = ca.fabs(after["twist"]) + ca.sqrt(hypothesis_variance(after, "twist"))
    after["left"] = may_be * ca.fabs(slid - free)
    outputs = {"part_next": vector_of(names, after)}
    return named_function("hypothesis", inputs, outputs, cse=True)


@cache
def build_hypotheses_update(gear: bool = False) -> ca.Function:
    """Update the hypotheses with a measured torque, those within so many of the likeliest.

    (hypotheses, beside, turns, loads, M_z, variance, share, tyre) -> hypotheses; turns [rad] and loads
    [N] (POINTS, PATHS). The others stay as they are, as much less likely than the likeliest as they
    were. With a gear the torque of its declared friction [N m] is a further input.
    """
    count, rows = len(RATIOS), build_one_hypothesis_update(gear).numel_in(0)
    inputs = symbols(
        ca.MX, hypotheses=(rows, count), beside=1, turns=(POINTS, PATHS), loads=(POINTS, PATHS), M_z=1,
        variance=1, share=1, tyre=3, **gear_friction_input_sizes(gear),
    )  # fmt: skip
    hypotheses, beside, turns, loads, M_z, variance, share, tyre, *dry = inputs.values()
    lanes = count * POINTS * PATHS
    branches = build_branch_torque().map(lanes)(
        ca.vec(ca.repmat(ca.vec(turns), 1, count)).T, ca.DM([*range(POINTS)] * count * PATHS).T,
        ca.DM(RATIOS.repeat(POINTS * PATHS)).T, ca.vec(ca.repmat(ca.vec(loads), 1, count)).T,
        ca.repmat(tyre, 1, lanes),
    )  # fmt: skip
    expected = ca.reshape(ca.sum1(ca.reshape(branches, POINTS, PATHS * count)), PATHS, count)
    given = (ca.repmat(each, 1, count) for each in (M_z, variance, share, *(d[0] for d in dry)))
    after = build_one_hypothesis_update(gear).map(count)(hypotheses, *ca.vertsplit(expected), *given)
    at = hypothesis_fields(gear).index("log_likelihood")
    places, likelihood = ca.DM(range(count)).T, hypotheses[at, :]
    likeliest = ca.mmax((likelihood >= ca.mmax(likelihood)) * places)
    change = ca.dot(places == likeliest, after[at, :] - likelihood)
    shifted = ca.vertcat(hypotheses[:at, :], likelihood + change, hypotheses[at + 1 :, :])
    near = ca.repmat(ca.fabs(places - likeliest) <= beside, rows, 1)
    after = ca.if_else(near, after, shifted)
    return named_function("weigh", inputs, {"hypotheses_next": after})


def gear_friction_input_sizes(gear: bool) -> dict[str, int]:
    """Size of the torque of a gear's friction with its deviation, where there is a gear."""
    return {"dry": 2} if gear else {}
