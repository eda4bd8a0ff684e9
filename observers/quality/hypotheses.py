"""Hypotheses about the ratio of mu to k, each with an exact filter of what is left, and their verdict.

The torque of the declared patch is homogeneous of degree 1 in (mu, k), so that under a hypothesis it is
linear in what is left,

    M_z + M_0 = s g_i(psi) + M_0,    g_i the torque at mu = RATIOS[i] and the declared k,

and a Kalman filter of two states, s and M_0, linearises nothing. s is the stiffness over the declared
one, and s RATIOS[i] is mu. The hypotheses are weighed by the likelihood of their innovations
[Magill 1965]; their mixture is a Gaussian sum [Alspach 1972]. Without a prior of s the same mixture
tells whether the torque has the scale that k, half-length and load allow: a torque in another unit, or
before a gear, is s times too large.
"""

from functools import cache

import casadi as ca
import numpy as np

from observers.layout import (
    Expression,
    Layout,
    Parts,
    named,
    symbols,
    vector_of,
)
from observers.measurement.torque_error import is_stated, retained
from observers.quality.branches import MEMORY, PATHS, POINTS, SLID, TRACK
from symbolic import full_slide_torque
from symbolic.functions import named_function

RATIOS = np.geomspace(0.012, 6.0, 14)
"""Hypotheses about mu at the declared k [1]."""
STEP = float(np.log(RATIOS[1] / RATIOS[0]))
"""Distance of two hypotheses in ln mu [1]."""
SENSOR = 0.005
"""White torque noise of a sensor of which nothing is declared, as a share of 3/8 F_N a [1]."""
RELATIVE_SENSOR = 0.01
"""What noise adds that grows with the torque, as a share of the greatest one so far [1]."""
VAGUE = 10.0
"""Standard deviation of s before any torque [1]."""
ROBUST = 4.0
"""Normalised innovation beyond which the cost of a sample grows linearly, as in Huber's loss [1]."""
MOST_ERROR = 0.2
"""Largest error of the model that is reckoned with [1]."""
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
NOISIER = 4.0
"""Squares of the noise, over its variance, that a sample may have: a sensor is twice as noisy [1]."""
UNKNOWN = ("gain", "zero", "twist")
"""What a hypothesis leaves open: s [1], M_0 [N m], and s times the share of the twist [1]."""
COVARIANCE = (
    *("var_gain", "cov_gain_zero", "cov_gain_twist"),
    *("var_zero", "cov_zero_twist", "var_twist"),
)
PER_HYPOTHESIS = ("log_likelihood", *UNKNOWN, *COVARIANCE, "left")
"""Logarithm of the likelihood; the unknowns with their covariance; torque that the twist may
make [N m]."""
PLACES = tuple((i, j) for j in range(len(UNKNOWN)) for i in range(j, len(UNKNOWN)))
"""Row and column of each element of `COVARIANCE`."""
SEARCH = Layout(
    (
        ("track", len(TRACK), 1),
        ("points", POINTS, PATHS),
        ("hypotheses", len(PER_HYPOTHESIS), len(RATIOS)),
    )
)
"""State of the acquisition."""
LIMITS = (
    *("mu", "mu_std", "stiffness_std", "error", "psi_noise", "zero_std"),
    *("mu_floor", "least", "greatest", "explained"),
)
"""Fields of the tuning that acquisition and supervision need."""
TWIST_STD = 0.5
"""Standard deviation of the share in which the patch was twisted before the first sample, over s [1]."""
WIPED = 0.1
"""Share of the torque that the twist before the first sample may make at the handover [1]."""
RESTART_STD = 0.1
"""Standard deviation of s, known once, in a later acquisition [1]."""
PATH_ERROR = 0.05
"""Least error of a model on a path that began on another ground [1]."""
VERDICT = (
    *("log_mu", "variance", "log_ratio", "zero", "var_zero", "log_gain", "var_log_gain"),
    *("verified", "suspect", "unexplained", "wiped"),
)
"""Mean and variance of ln mu under the declared stiffness, and ln mu at the declared k; mean and
variance of M_0 [N m]; mean and variance of ln s from the torque alone; whether s is what the tolerances
allow, whether it is not, whether no hypothesis explains the torque, and whether the twist before the
first sample no longer matters: 0 or 1."""


def limits_of(tuning: Parts, misfit: float, again: Expression) -> Expression:
    """The tuning in the order of `LIMITS`; misfit is the least error of the model [1].

    again is 1 where the ground has changed: what the patch was before is then known roughly. An error
    that is stated for no turn is that of the noise, `Tuning.error_travel`.
    """
    error = tuning["error"]
    error = ca.if_else(is_stated(tuning), error, ca.fmin(error, tuning["noise"]))
    least = ca.if_else(again, ca.fmax(misfit, PATH_ERROR), misfit)
    return vector_of(LIMITS, {**tuning, "error": ca.fmax(least, error)})


@cache
def build_start() -> ca.Function:
    """The search at a place of rest: (psi, gain, gain_std, zero, zero_std) -> search.

    psi [rad]; mean and standard deviation of s [1] and of M_0 [N m].
    """
    inputs = symbols(ca.MX, psi=1, gain=1, gain_std=1, zero=1, zero_std=1)
    psi, gain, gain_std, zero, zero_std = inputs.values()
    part: dict[str, Expression] = dict.fromkeys(PER_HYPOTHESIS, 0)
    part |= {"gain": gain, "zero": zero, "var_gain": gain_std**2, "var_zero": zero_std**2}
    part["var_twist"] = TWIST_STD**2
    track: dict[str, Expression] = dict.fromkeys(TRACK, 0)
    track |= {"count": 1, "count_slid": 1, "extreme": psi, "origin": psi}
    parts = {
        "track": vector_of(TRACK, track),
        "points": ca.repmat(psi, POINTS, PATHS),
        "hypotheses": ca.repmat(vector_of(PER_HYPOTHESIS, part), 1, len(RATIOS)),
    }
    return named_function("search_start", inputs, {"search": SEARCH.join(parts)})


@cache
def build_restart() -> ca.Function:
    """The search anew: (search, gain, gain_std, zero, zero_std) -> search.

    What the patch was before its last turn back is forgotten: it slid to the other side. The hypotheses
    begin anew about s and the torque's zero [N m], which are known.
    """
    inputs = symbols(ca.MX, search=SEARCH.size, gain=1, gain_std=1, zero=1, zero_std=1)
    search, gain, gain_std, zero, zero_std = inputs.values()
    track = named(TRACK, SEARCH.split(search)["track"])
    origin, direction = track["origin"], track["direction"]
    fresh = SEARCH.split(build_start()(origin, gain, gain_std, zero, zero_std))
    count = ca.if_else(direction == 0, 1, 2)
    track |= {"count": count, "count_slid": count, "explained": 0, "widest": 0}
    points = ca.vertcat(origin + direction * SLID, ca.repmat(origin, POINTS - 1))
    # What the patch was before is no question.
    hypotheses = ca.MX(fresh["hypotheses"])
    hypotheses[PER_HYPOTHESIS.index("var_twist"), :] = 0
    parts = {
        "track": vector_of(TRACK, track),
        "points": ca.repmat(points, 1, PATHS),
        "hypotheses": hypotheses,
    }
    return named_function("restart", inputs, {"search_next": SEARCH.join(parts)})


@cache
def build_error() -> ca.Function:
    """Size of a torque less its noise, variance of its error, and the squares that noise explains.

    (M_z, F_N, a, added, reach, share, error) -> (size, variance, noisy): torque [N m], load [N], half-
    length [m]; variance added on the way to the torque [N^2 m^2]; greatest torque so far [N m]; share of
    an independent sample; model's error as a share of the torque [1].
    """
    inputs = symbols(ca.SX, M_z=1, F_N=1, a=1, added=1, reach=1, share=1, error=1)
    M_z, F_N, a, added, reach, share, error = inputs.values()
    noise = SENSOR * full_slide_torque(F_N, a)
    white = added + noise**2 + (RELATIVE_SENSOR * reach) ** 2
    variance = white + (ca.fmin(error, 1) * reach) ** 2 / share
    size = ca.fmax(ca.fabs(M_z) - 2 * noise, 0)
    outputs = {"size": size, "variance": variance, "noisy": NOISIER * white / variance}
    return named_function("torque_error", inputs, outputs)


@cache
def build_hypothesis() -> ca.Function:
    """One hypothesis after a torque: (part, free, slid, measured, variance, share) -> part_next.

    part is in the order of `PER_HYPOTHESIS`; free and slid are the torques at s = 1 of a patch that was
    free of torque before the first sample, and of one that slid [N m]; variance is that of the
    measurement's error [N^2 m^2], share that of an independent sample.
    """
    inputs = symbols(ca.SX, part=len(PER_HYPOTHESIS), free=1, slid=1, measured=1, variance=1, share=1)
    part, free, slid, measured, variance, share = inputs.values()
    older, was = retained(share, MEMORY), named(PER_HYPOTHESIS, part)
    x = ca.vertcat(*(was[name] for name in UNKNOWN))
    P = _symmetric([was[name] / older for name in COVARIANCE])
    H = ca.vertcat(free, 1, slid - free)
    by = P @ H
    spread, innovation = ca.dot(H, by), measured - ca.dot(H, x)
    size = ca.fabs(innovation) / ca.sqrt(spread + variance)
    # Huber's loss as a variance that grows with the innovation.
    variance = variance + (spread + variance) * ca.fmax(size / ROBUST - 1, 0)
    total = spread + variance
    cost = ca.if_else(size > ROBUST, ROBUST * size - ROBUST**2 / 2, size**2 / 2)
    x, P = x + by / total * innovation, P - by @ by.T / total
    after = dict(zip(UNKNOWN, ca.vertsplit(x), strict=True))
    after |= {name: P[place] for name, place in zip(COVARIANCE, PLACES, strict=True)}
    after |= {name: ca.fmax(after[name], 0) for name in ("var_zero", "var_twist")}
    after |= {
        "log_likelihood": older * was["log_likelihood"] - cost - ca.log(total / variance) / 2,
        "var_gain": ca.fmax(after["var_gain"], 1e-9),
        "left": (ca.fabs(after["twist"]) + ca.sqrt(after["var_twist"])) * ca.fabs(slid - free),
    }
    outputs = {"part_next": vector_of(PER_HYPOTHESIS, after)}
    return named_function("hypothesis", inputs, outputs, cse=True)


def _symmetric(values: list[Expression]) -> Expression:
    """The matrix with these elements in `PLACES`, and below them."""
    matrix = ca.SX.zeros(len(UNKNOWN), len(UNKNOWN))
    for (i, j), value in zip(PLACES, values, strict=True):
        matrix[i, j] = matrix[j, i] = value
    return matrix


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
def build_verdict() -> ca.Function:
    """What the hypotheses say together: (hypotheses, explained, reach, limits) -> `VERDICT`.

    hypotheses (11, G) has a row for each of `PER_HYPOTHESIS`, explained and reach are as in `TRACK`,
    limits is in the order of `LIMITS`. `EVEN`
    of the prior of ln mu is even over all hypotheses: the tuning's alone would exclude ice.
    """
    count = (len(PER_HYPOTHESIS), len(RATIOS))
    inputs = symbols(ca.MX, hypotheses=count, explained=1, reach=1, limits=len(LIMITS))
    limits, grid = named(LIMITS, inputs["limits"]), ca.DM(np.log(RATIOS))
    rows = (row.T for row in ca.vertsplit(inputs["hypotheses"]))
    parts = dict(zip(PER_HYPOTHESIS, rows, strict=True))
    stiffness, log_std = limits["stiffness_std"] ** 2, limits["mu_std"] / limits["mu"]
    gain, variance = ca.fmax(parts["gain"], LEAST_GAIN), parts["var_gain"]
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
    slope = parts["cov_gain_zero"] / variance
    zero, var_zero = _moments(
        declared,
        parts["zero"] + slope * (known - parts["gain"]),
        ca.fmax(parts["var_zero"] - slope * parts["cov_gain_zero"] + slope**2 * joint, 0),
    )
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
    }  # fmt: skip
    return named_function("verdict", inputs, {"verdict": vector_of(VERDICT, outputs)}, cse=True)
