"""How sure the shared unknowns are: the covariance from what the half swings say one by one.

Errors of an encoder belong to one another as long as the angle moves the same way, and where its step is
all the error there is, the likelihood's own curvature is not the inverse of the estimate's variance. So
the variance is taken from what the estimate would change by without one half swing, without the next
and so on, which meet the encoder's steps at unrelated places: the jackknife of groups to first order,
or Huber's sandwich with the correction HC3 (MacKinnon and White 1985).
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from identification.free_decay.likelihood import Programme
from identification.free_decay.noise_continuation import Solution
from identification.free_decay.quantisation import misfit

Array = NDArray[np.float64]

_MOST_LEVERAGE = 0.99
"""So much of one direction may rest on one half swing; beyond it, nothing is left without it."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Spread:
    """The covariance of what is shared.

    Attributes:
        covariance: in units of the programme's scales, shape (m, m).
        information: Hessian of the objective with all else eliminated, shape (m, m).
        freedom: half swings less shared unknowns, at least 1.
    """

    covariance: Array
    information: Array
    freedom: int


def spread_of(programme: Programme, solution: Solution) -> Spread:
    """The covariance at a solution."""
    inverse = np.asarray(np.linalg.inv(solution.look.hessian), dtype=np.float64)
    shared = slice(programme.shared)
    changes = []
    for i, (of, made) in enumerate(zip(programme.releases, solution.look.swings, strict=True)):
        told = misfit(of.psi, made.psi, of.step, solution.noise)
        at = programme.columns(i)
        for part in half_swings(made.psi):
            along = made.sensitivities[part]
            curvature = along.T @ (along * told.curvature[part, None])
            score = _without(inverse[np.ix_(at, at)], curvature, along.T @ told.slope[part])
            changes.append(inverse[shared, at] @ score)
    return Spread(
        covariance=np.sum([np.outer(change, change) for change in changes], axis=0),
        information=np.asarray(np.linalg.inv(inverse[shared, shared]), dtype=np.float64),
        freedom=max(len(changes) - programme.shared, 1),
    )


def half_swings(psi: Array) -> list[slice]:
    """The samples between one turning point of the angle and the next."""
    heading = np.sign(np.diff(psi))
    turns = np.flatnonzero(heading[1:] * heading[:-1] < 0) + 1
    ends = [0, *turns.tolist(), psi.size]
    return [slice(a, b) for a, b in pairwise(ends) if b > a]


def _without(inverse: Array, curvature: Array, score: Array) -> Array:
    """The score that moves the estimate as far as leaving this half swing out would.

    (H - C)^-1 g = H^-1 (1 - C H^-1)^-1 g, in the coordinates in which H is one.
    """
    root = np.linalg.cholesky(inverse)
    shares, axes = np.linalg.eigh(root.T @ curvature @ root)
    left = 1 - np.minimum(shares, _MOST_LEVERAGE)
    moved: Array = np.linalg.solve(root.T, axes @ ((axes.T @ (root.T @ score)) / left))
    return moved
