"""The verdict of all `observers.quality.mu_over_k_hypotheses`: mu, s and whether they are known."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import casadi as ca
import numpy as np

from observers.layout import Expression, Parts, named, symbols, vector_of
from observers.quality.mu_over_k_hypotheses import (
    GRID_SPACING,
    MAX_MODEL_ERROR,
    RATIOS,
    SETTINGS,
    hypothesis_fields,
    hypothesis_variance,
    udu_entry_name,
)
from symbolic.named_and_buffered_functions import named_function

EVEN = 0.1
"""Share of the prior of ln mu that is even over all hypotheses [1]."""
MIN_GAIN = 0.02
"""Least s of a hypothesis [1]."""
ALLOWED = 3.0
"""|ln s| up to this many `Tuning.stiffness_std` is tolerance of k, not the torque's scale [1]."""
GAIN_FREE = 0.5
"""|s - 1| up to this many `stiffness_std` is k's own [1]; beyond, see `MeasurementModel.gain_share`."""
FOUND_GAIN_FREE = 0.25
"""The same of a model that was found: the declared patch that stands for it may hide part of s."""
VERDICT_MARGINS = (1.5, 2.0)
"""Margins to that limit in standard deviations of ln s: verified if further inside than the first,
suspect if further outside than the second."""
HIDDEN = 3.0
"""Deviations of s by which it is off 1 where it is suspect: of a torque below its noise, ln s tells
nothing [1]."""
UNEXPLAINED = 60.0
"""`unexplained`: -2 ln L of the best hypothesis exceeds the sum of squares that errors and noise explain
by more than this [1]."""
MAX_TWIST_SHARE = 0.1
"""Largest share of the torque from the twist before the first sample at handover [1]."""
VERDICT = (
    *("log_mu", "variance", "log_ratio", "zero", "var_zero", "log_gain", "var_log_gain"),
    *("verified", "suspect", "unexplained", "wiped", "gear", "var_gear"),
    *("log_mu_zero", "log_mu_gear", "zero_gear"),
)
"""Mean and variance of ln mu under the declared stiffness, and ln mu at the declared k; mean and
variance of M_0 [N m]; mean and variance of ln s from the torque alone; whether s is what the tolerances
allow, whether it is not, whether no hypothesis explains the torque, and whether the twist before the
first sample no longer matters: 0 or 1; mean and variance of the gear's friction over the declared one
[1]; covariances of ln mu with M_0 [N m] and with the gear, and of both [N m]. All of a gear is 0 where
there is none."""


Quantity = Callable[[Parts], tuple[Expression, Expression]]
"""Value and variance of something under a hypothesis, from its parts: of all (G,), or of one."""
Pair = Callable[[Parts], tuple[Expression, Expression, Expression]]
"""Values of two, and their covariance."""


@dataclass(frozen=True)
class HypothesisMixture:
    """The hypotheses with weights exp(exponent) factor, of which logarithms are taken where they matter.

    Parts are vectors (G,), with ln mu at the declared k as `grid`; a factor is computed from its parts.
    """

    parts: Parts
    exponent: Expression
    factor: Callable[[Parts], Expression]

    @property
    def unnormalised_weights(self) -> Expression:
        """The weights (G,), not normalised."""
        return ca.exp(self.exponent - ca.mmax(self.exponent)) * self.factor(self.parts)

    def mean(self, value: Expression) -> Expression:
        """Mean of a value under each hypothesis (G,)."""
        return ca.dot(self.unnormalised_weights, value) / ca.sum1(self.unnormalised_weights)

    def at_mode(self, name: str) -> Expression:
        """A part of the hypothesis with the greatest exponent."""
        return _element_at(_last_argmax(self.exponent), self.parts[name])

    def moments(self, quantity: Quantity, about: Expression) -> tuple[Expression, Expression]:
        """Mean and variance of a quantity, the latter as `covariance` has it."""

        def twice(parts: Parts) -> tuple[Expression, Expression, Expression]:
            value, variance = quantity(parts)
            return value, value, variance

        mean, _, variance = self.covariance(twice, about, about)
        return mean, variance

    def covariance(
        self, pair: Pair, about: Expression, about_other: Expression
    ) -> tuple[Expression, Expression, Expression]:
        """Means of two quantities, and their covariance.

        Where the weight is narrower than the hypotheses are apart, its logarithm is a parabola through
        the best and its neighbours. `about` is near the mean: little is lost where squares are
        subtracted.
        """
        one, other, both = pair(self.parts)
        offset = self.parts["grid"] - self.at_mode("grid")
        mean, mean_other = self.mean(one - about), self.mean(other - about_other)
        along = self.mean(offset)
        broad = self.mean((one - about) * (other - about_other) + both) - mean * mean_other
        width = self.mean(offset**2) - along**2
        place = ca.fmin(ca.fmax(_last_argmax(self.unnormalised_weights), 1), len(RATIOS) - 2)
        places = [place + i for i in (-1, 0, 1)]
        beside = [{name: _element_at(at, part) for name, part in self.parts.items()} for at in places]
        left, middle, right = (
            _element_at(at, self.exponent) + ca.log(self.factor(parts))
            for at, parts in zip(places, beside, strict=True)
        )
        curvature = ca.fmax(2 * middle - left - right, 1e-6)
        shift = ca.fmin(ca.fmax((right - left) / (2 * curvature), -1), 1)
        vertices, slopes = [], []
        for value in (one, other):
            left, middle, right = (_element_at(at, value) for at in places)
            slope, bend = (right - left) / 2, (right - 2 * middle + left) / 2
            vertices.append(middle + shift * (slope + shift * bend))
            slopes.append(slope + 2 * shift * bend)
        narrow = slopes[0] * slopes[1] / curvature + pair(beside[1])[2]
        is_broad = width > (0.7 * GRID_SPACING) ** 2
        return (
            ca.if_else(is_broad, about + mean, vertices[0]),
            ca.if_else(is_broad, about_other + mean_other, vertices[1]),
            ca.if_else(is_broad, broad, narrow),
        )


def _last_argmax(vector: Expression) -> Expression:
    """The last place of the maximum of a vector (G,)."""
    return ca.mmax((vector >= ca.mmax(vector)) * ca.DM(range(len(RATIOS))))


def _element_at(place: Expression, vector: Expression) -> Expression:
    return ca.dot(ca.DM(range(len(RATIOS))) == place, vector)


@cache
def build_hypotheses_verdict(gear: bool = False) -> ca.Function:
    """Verdict of all hypotheses together: (hypotheses, explained, reach, limits) -> `VERDICT`.

    hypotheses has a row for each of `hypothesis_fields`, explained and reach are as in `TRACK`, limits
    is in the order of `SETTINGS`. `EVEN` of the prior of ln mu is even over all hypotheses: the tuning's
    alone would exclude ice.
    """
    names = hypothesis_fields(gear)
    count = (len(names), len(RATIOS))
    inputs = symbols(ca.MX, hypotheses=count, explained=1, reach=1, limits=len(SETTINGS))
    limits, grid = named(SETTINGS, inputs["limits"]), ca.DM(np.log(RATIOS))
    rows = (row.T for row in ca.vertsplit(inputs["hypotheses"]))
    parts = {"grid": ca.MX(grid), **dict(zip(names, rows, strict=True))}
    stiffness, log_std = limits["stiffness_std"] ** 2, limits["mu_std"] / limits["mu"]
    exponent = -(((grid - ca.log(limits["mu"])) / log_std) ** 2) / 2
    usual = ca.exp(exponent) / (log_std * np.sqrt(2 * np.pi))
    prior = ca.log((1 - EVEN) * usual + EVEN / (GRID_SPACING * len(RATIOS)))
    misfit = (parts["gain"] - 1) ** 2 / (parts["D_gain"] + stiffness) / 2
    likelihood = parts["log_likelihood"]
    declared = HypothesisMixture(
        parts, likelihood + prior - misfit, lambda of: ca.sqrt(1 / (1 + stiffness / of["D_gain"]))
    )
    log_mu, var_log_mu = declared.moments(partial(_log_mu_moments, stiffness), declared.at_mode("grid"))
    log_ratio, _ = declared.moments(lambda of: (of["grid"], 0), declared.at_mode("grid"))
    level, var_level, covariances = ca.MX(0), ca.MX(0), [ca.MX(0)] * 3
    of_zero = partial(_unknown_moments, "zero", stiffness)
    zero, var_zero = declared.moments(of_zero, declared.at_mode("zero"))
    if gear:
        level, var_level = declared.moments(
            partial(_unknown_moments, "gear", stiffness), declared.at_mode("gear")
        )
        covariances = [
            declared.covariance(partial(_joint_moments, *of, stiffness), *map(declared.at_mode, near))[2]
            for of, near in (
                (("log_mu", "zero"), ("grid", "zero")),
                (("log_mu", "gear"), ("grid", "gear")),
                (("zero", "gear"), ("zero", "gear")),
            )
        ]
    # Without a prior of s: even in ln s.
    even = HypothesisMixture(
        parts, likelihood, lambda of: ca.sqrt(of["D_gain"]) / ca.fmax(of["gain"], MIN_GAIN)
    )
    log_gain, var_gain = even.moments(_log_gain_moments, ca.log(ca.fmax(even.at_mode("gain"), MIN_GAIN)))
    error = ca.fmin(limits["error"], MAX_MODEL_ERROR) ** 2
    deviation, allowed = ca.sqrt(var_gain + error), ALLOWED * limits["stiffness_std"]
    inside = (allowed - ca.fabs(log_gain)) / deviation
    # While noise hides the torque, ln s may be far off although s may well be 1.
    off = (even.at_mode("gain") - 1) ** 2 > HIDDEN**2 * even.at_mode("D_gain")
    suspect = ca.logic_and(off, inside < -VERDICT_MARGINS[1])
    squares = -2 * ca.mmax(likelihood)
    outputs = {
        "log_mu": log_mu, "variance": var_log_mu, "log_ratio": log_ratio, "zero": zero,
        "var_zero": var_zero, "log_gain": log_gain, "var_log_gain": var_gain,
        "verified": inside > VERDICT_MARGINS[0], "suspect": suspect,
        "unexplained": squares > inputs["explained"] + UNEXPLAINED,
        "wiped": declared.mean(parts["left"]) <= MAX_TWIST_SHARE * inputs["reach"],
        "gear": level, "var_gear": var_level, **dict(zip(VERDICT[-3:], covariances, strict=True)),
    }  # fmt: skip
    return named_function("verdict", inputs, {"verdict": vector_of(VERDICT, outputs)}, cse=True)


def _gain_moments(stiffness: Expression, parts: Parts) -> tuple[Expression, Expression]:
    """Mean and variance of s with the prior 1 of this variance."""
    variance = 1 / (1 / parts["D_gain"] + 1 / stiffness)
    return ca.fmax((parts["gain"] / parts["D_gain"] + 1 / stiffness) * variance, MIN_GAIN), variance


def _log_mu_moments(stiffness_variance: Expression, hypotheses: Parts) -> tuple[Expression, Expression]:
    gain, variance = _gain_moments(stiffness_variance, hypotheses)
    return hypotheses["grid"] + ca.log(gain), variance / gain**2


def _unknown_moments(name: str, stiffness: Expression, parts: Parts) -> tuple[Expression, Expression]:
    """Mean and variance of an unknown beside s."""
    gain, variance = _gain_moments(stiffness, parts)
    slope = parts[udu_entry_name(name, "gain")]
    value = parts[name] + slope * (gain - parts["gain"])
    return value, hypothesis_variance(parts, name, given=("gain",)) + slope**2 * variance


def _joint_moments(
    one: str, other: str, stiffness: Expression, parts: Parts
) -> tuple[Expression, Expression, Expression]:
    """Means of two of ln mu, M_0 and the gear, in this order, and their covariance."""
    gain, variance = _gain_moments(stiffness, parts)
    last = _unknown_moments(other, stiffness, parts)[0]
    by_gain = parts[udu_entry_name(other, "gain")] * variance
    if one == "log_mu":
        return _log_mu_moments(stiffness, parts)[0], last, by_gain / gain
    # The gear comes before M_0 in the factor.
    given = parts[udu_entry_name(other, one)] * parts[udu_entry_name(one, one)]
    first = _unknown_moments(one, stiffness, parts)[0]
    return first, last, given + by_gain * parts[udu_entry_name(one, "gain")]


def _log_gain_moments(parts: Parts) -> tuple[Expression, Expression]:
    """Mean and variance of ln s from the torque alone."""
    gain = ca.fmax(parts["gain"], MIN_GAIN)
    return ca.log(gain), ca.fmin(parts["D_gain"] / gain**2, 2)


def log_torque_scale_variance(verdict: Parts, stiffness_std: Expression) -> Expression:
    """Variance of ln s from the torque and from the tolerances together [1]."""
    variance, spread = verdict["var_log_gain"], stiffness_std**2
    return variance * spread / (variance + spread)


@cache
def build_mu_std_from_torque_scale(found: bool, gain_share: float) -> ca.Function:
    """What the scale adds to the relative deviation of mu [1]: (verdict, limits) -> excess.

    It is the torque's share of what s may be off by beyond what is k's own, from its value and its
    deviation. The deviation may hide what adds to the value: the two are correlated by half. Of a model
    that was found, the declared patch that stands for it makes part of the value: there they are
    independent.
    """
    inputs = symbols(ca.SX, verdict=len(VERDICT), limits=len(SETTINGS))
    verdict = named(VERDICT, inputs["verdict"])
    stiffness_std = named(SETTINGS, inputs["limits"])["stiffness_std"]
    value, variance = ca.fabs(verdict["log_gain"]), log_torque_scale_variance(verdict, stiffness_std)
    off = ca.sqrt(value**2 + variance + (0 if found else value * ca.sqrt(variance)))
    free = FOUND_GAIN_FREE if found else GAIN_FREE
    excess = gain_share * ca.fmax(0, ca.exp(off) - 1 - free * stiffness_std)
    return named_function("scale_excess", inputs, {"excess": excess})
