"""The most likely unknowns by noise continuation, and their covariance by the jackknife.

A large noise makes an objective without local minima. Where quantisation is the only error, an estimate
is unbiased only for a noise scale near zero: a larger scale expects readings to flicker close to the
borders of the encoder's cells, and they do not. So the scale decreases from the most likely one at the
first guess to the most likely one of all, and every stage begins where the one before it ended.

Quantisation errors are correlated as long as the angle moves in one direction, so the inverse of the
likelihood's curvature is not the variance of the estimate. The variance comes from the changes of the
estimate when one half swing after the other is left out, as half swings meet the encoder's steps at
unrelated places: the grouped jackknife to first order, or Huber's sandwich with the correction HC3
(MacKinnon and White 1985).
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize

from identification.free_decay.likelihood import Likelihood, LikelihoodEvaluation, neg_log_likelihood
from symbolic.float_array_type import Array

_MAX_FACTOR, _SAME = 3.0, 0.02
"""Largest factor of the scale between stages, and the relative change at which it has converged."""
_MAX_STAGES, _MAX_STEPS = 20, 40
_SLOPE = 0.01
"""Length of the gradient at which a stage ends, in the units of `_conditional_std_of_unknowns`."""
_RADIUS, _MAX_RADIUS = 1e3, 1e9
"""Radius of the trust region at the start and at most, in these units."""
_MAX_LEVERAGE = 0.99
"""Leverage of a half swing in one direction is cut to this, so that something determines it without."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LikelihoodMaximum:
    """The maximum of a likelihood."""

    x: Array  # Unknowns in units of its scales.
    noise: float  # Scale of the noise besides the encoder's step [rad].
    evaluation: LikelihoodEvaluation
    converged: bool  # Whether scale and unknowns both ended by their tolerances.
    steps: int  # Of the solver in all.


class JackknifeCovariance(NamedTuple):
    """Covariance of the shared unknowns in units of the likelihood's scales, shape (m, m)."""

    covariance: Array
    information: Array  # Hessian of the objective with all other unknowns eliminated.
    degrees_of_freedom: int  # Half swings less shared unknowns, at least 1.


def maximise_likelihood(likelihood: Likelihood) -> LikelihoodMaximum:
    """The most likely unknowns; LinAlgError where the readings do not depend on one of them."""
    x, steps = likelihood.start(), 0
    first = likelihood.evaluate(x, 1.0)
    _conditional_std_of_unknowns(first)
    noise = likelihood.likeliest_noise(first.responses)
    for _ in range(_MAX_STAGES):
        stage = _minimise_at_noise(likelihood, x, noise)
        x, steps = stage.x, steps + stage.steps
        likeliest = likelihood.likeliest_noise(stage.evaluation.responses)
        following = max(likeliest, noise / _MAX_FACTOR)
        same = abs(following - noise) < _SAME * noise
        if same:
            break
        noise = following
    return replace(stage, converged=same and stage.converged, steps=steps)


def _minimise_at_noise(likelihood: Likelihood, x: Array, noise: float) -> LikelihoodMaximum:
    """The minimum for one scale of the noise, by a trust region."""
    unit = _conditional_std_of_unknowns(likelihood.evaluate(x, noise))

    @lru_cache(maxsize=2)
    def evaluate(point: bytes) -> LikelihoodEvaluation:
        return likelihood.evaluate(x + unit * np.frombuffer(point), noise)

    minimum = minimize(
        lambda z: evaluate(z.tobytes()).cost,
        np.zeros(x.size),
        jac=lambda z: unit * evaluate(z.tobytes()).gradient,
        hess=lambda z: np.outer(unit, unit) * evaluate(z.tobytes()).hessian,
        method="trust-exact",
        options={
            "gtol": _SLOPE,
            "maxiter": _MAX_STEPS,
            "initial_trust_radius": _RADIUS,
            "max_trust_radius": _MAX_RADIUS,
        },
    )
    return LikelihoodMaximum(
        x=x + unit * minimum.x,
        noise=noise,
        evaluation=evaluate(minimum.x.tobytes()),
        converged=bool(minimum.success),
        steps=int(minimum.nit),
    )


def _conditional_std_of_unknowns(evaluation: LikelihoodEvaluation) -> Array:
    """Standard deviation of each unknown if all others were known."""
    information = np.diag(evaluation.hessian)
    if not (information > 0).all():
        raise np.linalg.LinAlgError("the readings do not depend on one of the unknowns")
    return np.asarray(1 / np.sqrt(information))


def jackknife_covariance(likelihood: Likelihood, solution: LikelihoodMaximum) -> JackknifeCovariance:
    """The covariance of the shared unknowns at a solution."""
    inverse = np.asarray(np.linalg.inv(solution.evaluation.hessian), dtype=np.float64)
    shared = slice(likelihood.shared)
    changes = []
    pairs = zip(likelihood.vibrations, solution.evaluation.responses, strict=True)
    for i, (vibration, response) in enumerate(pairs):
        losses = neg_log_likelihood(vibration.psi, response.psi, vibration.step, solution.noise)
        columns = likelihood.columns(i)
        for part in half_swings(response.psi):
            slopes = response.sensitivities[part]
            curvature = slopes.T @ (slopes * losses.curvature[part, None])
            score = slopes.T @ losses.slope[part]
            amplified = _leverage_corrected_score(inverse[np.ix_(columns, columns)], curvature, score)
            changes.append(inverse[shared, columns] @ amplified)
    return JackknifeCovariance(
        covariance=np.sum([np.outer(change, change) for change in changes], axis=0),
        information=np.asarray(np.linalg.inv(inverse[shared, shared]), dtype=np.float64),
        degrees_of_freedom=max(len(changes) - likelihood.shared, 1),
    )


def half_swings(psi: Array) -> list[slice]:
    """The samples between one turning point of the angle and the next."""
    direction = np.sign(np.diff(psi))
    turns = np.flatnonzero(direction[1:] * direction[:-1] < 0) + 1
    ends = [0, *turns.tolist(), psi.size]
    return [slice(a, b) for a, b in pairwise(ends) if b > a]


def _leverage_corrected_score(inverse: Array, curvature: Array, score: Array) -> Array:
    """(1 - C H^-1)^-1 g, in which H is one: the step by H^-1 of it is that without one half swing."""
    root = np.linalg.cholesky(inverse)
    leverages, axes = np.linalg.eigh(root.T @ curvature @ root)
    remainder = 1 - np.minimum(leverages, _MAX_LEVERAGE)
    return np.asarray(np.linalg.solve(root.T, axes @ ((axes.T @ (root.T @ score)) / remainder)))
