"""The verdict of the hypotheses of `observers.quality.hypotheses`: mu, s and whether they are known."""

from functools import cache

import casadi as ca
import numpy as np

from observers.layout import Expression, Parts, named, symbols, vector_of
from observers.quality.hypotheses import (
    LIMITS,
    MOST_ERROR,
    RATIOS,
    STEP,
    factor_name,
    per_hypothesis,
    variance_of,
)
from symbolic.functions import named_function

EVEN = 0.1
"""Share of the prior of ln mu that is even over all hypotheses [1]."""
LEAST_GAIN = 0.02
"""Least s of a hypothesis [1]."""
ALLOWED = 3.0
"""Deviations of `Tuning.stiffness_std` in ln s that are no other scale [1]."""
SURE = (1.5, 2.0)
"""Deviations by which ln s lies within what is allowed once verified, and beyond it if suspect."""
UNEXPLAINED = 60.0
"""The best hypothesis does not explain the torque where its sum of squares exceeds by this much what
errors and noise explain [1]."""
WIPED = 0.1
"""Share of the torque that the twist before the first sample may make at the handover [1]."""
VERDICT = (
    *("log_mu", "variance", "log_ratio", "zero", "var_zero", "log_gain", "var_log_gain"),
    *("verified", "suspect", "unexplained", "wiped", "gear", "var_gear"),
)
"""Mean and variance of ln mu under the declared stiffness, and ln mu at the declared k; mean and
variance of M_0 [N m]; mean and variance of ln s from the torque alone; whether s is what the tolerances
allow, whether it is not, whether no hypothesis explains the torque, and whether the twist before the
first sample no longer matters: 0 or 1; mean and variance of the gear's friction over the declared one
[1], 0 where there is none."""


def _weights(log_weight: Expression) -> Expression:
    """Weights (G,) that sum to 1."""
    weight = ca.exp(log_weight - ca.mmax(log_weight))
    return weight / ca.sum1(weight)


def _moments(
    log_weight: Expression, value: Expression, variance: Expression
) -> tuple[Expression, Expression]:
    """Mean and variance of a quantity with this value and variance under each hypothesis (G,).

    Where the weight is narrower than the hypotheses are apart, its logarithm is a parabola through the
    best and its neighbours.
    """
    count, grid, numbers = len(RATIOS), ca.DM(np.log(RATIOS)), ca.DM(range(len(RATIOS)))
    best, weight = ca.mmax(log_weight), _weights(log_weight)
    mean = ca.dot(weight, value)
    broad = ca.dot(weight, (value - mean) ** 2 + variance)
    width = ca.dot(weight, (grid - ca.dot(weight, grid)) ** 2)
    place = ca.fmin(ca.fmax(ca.mmax((log_weight >= best) * numbers), 1), count - 2)
    selections = [numbers == place + i for i in (-1, 0, 1)]
    left, middle, right = (
        (ca.dot(chosen, log_weight), ca.dot(chosen, value), ca.dot(chosen, variance))
        for chosen in selections
    )
    curvature = ca.fmax(2 * middle[0] - left[0] - right[0], 1e-6)
    shift = ca.fmin(ca.fmax((right[0] - left[0]) / (2 * curvature), -1), 1)
    slope, bend = (right[1] - left[1]) / 2, (right[1] - 2 * middle[1] + left[1]) / 2
    vertex = middle[1] + shift * (slope + shift * bend)
    narrow = (slope + 2 * shift * bend) ** 2 / curvature + middle[2]
    is_broad = width > (0.7 * STEP) ** 2
    return ca.if_else(is_broad, mean, vertex), ca.if_else(is_broad, broad, narrow)


@cache
def build_verdict(gear: bool = False) -> ca.Function:
    """What the hypotheses say together: (hypotheses, explained, reach, limits) -> `VERDICT`.

    hypotheses has a row for each of `per_hypothesis`, explained and reach are as in `TRACK`, limits is
    in the order of `LIMITS`. `EVEN` of the prior of ln mu is even over all hypotheses: the tuning's
    alone would exclude ice.
    """
    names = per_hypothesis(gear)
    count = (len(names), len(RATIOS))
    inputs = symbols(ca.MX, hypotheses=count, explained=1, reach=1, limits=len(LIMITS))
    limits, grid = named(LIMITS, inputs["limits"]), ca.DM(np.log(RATIOS))
    rows = (row.T for row in ca.vertsplit(inputs["hypotheses"]))
    parts = dict(zip(names, rows, strict=True))
    stiffness, log_std = limits["stiffness_std"] ** 2, limits["mu_std"] / limits["mu"]
    gain, variance = ca.fmax(parts["gain"], LEAST_GAIN), parts["D_gain"]
    usual = ca.exp(-(((grid - ca.log(limits["mu"])) / log_std) ** 2) / 2) / (
        log_std * np.sqrt(2 * np.pi)
    )
    prior = ca.log((1 - EVEN) * usual + EVEN / (STEP * len(RATIOS)))
    declared = parts["log_likelihood"] + prior + ca.log(variance / (variance + stiffness)) / 2
    declared -= (parts["gain"] - 1) ** 2 / (variance + stiffness) / 2
    joint = 1 / (1 / variance + 1 / stiffness)
    known = ca.fmax((parts["gain"] / variance + 1 / stiffness) * joint, LEAST_GAIN)
    log_mu, var_log_mu = _moments(declared, grid + ca.log(known), joint / known**2)
    log_ratio, _ = _moments(declared, ca.MX(grid), 0 * gain)
    level, var_level = ca.MX(0), ca.MX(0)
    zero, var_zero = _given_gain(declared, parts, known, joint, "zero")
    if gear:
        level, var_level = _given_gain(declared, parts, known, joint, "gear")
    # Without a prior of s: even in ln s.
    even = parts["log_likelihood"] + ca.log(variance) / 2 - ca.log(gain)
    log_gain, var_gain = _moments(even, ca.log(gain), ca.fmin(variance / gain**2, 2))
    error = ca.fmin(limits["error"], MOST_ERROR) ** 2
    deviation, allowed = ca.sqrt(var_gain + error), ALLOWED * limits["stiffness_std"]
    inside = (allowed - ca.fabs(log_gain)) / deviation
    squares = -2 * ca.mmax(parts["log_likelihood"])
    outputs = {
        "log_mu": log_mu, "variance": var_log_mu, "log_ratio": log_ratio, "zero": zero,
        "var_zero": var_zero, "log_gain": log_gain, "var_log_gain": var_gain,
        "verified": inside > SURE[0], "suspect": inside < -SURE[1],
        "unexplained": squares > inputs["explained"] + UNEXPLAINED,
        "wiped": ca.dot(_weights(declared), parts["left"]) <= WIPED * inputs["reach"],
        "gear": level, "var_gear": var_level,
    }  # fmt: skip
    return named_function("verdict", inputs, {"verdict": vector_of(VERDICT, outputs)}, cse=True)


def _given_gain(
    log_weight: Expression, parts: Parts, known: Expression, variance: Expression, name: str
) -> tuple[Expression, Expression]:
    """Mean and variance of an unknown where s is `known` with a variance under each hypothesis."""
    slope = parts[factor_name(name, "gain")]
    value = parts[name] + slope * (known - parts["gain"])
    left = variance_of(parts, name, given=("gain",)) + slope**2 * variance
    return _moments(log_weight, value, left)
