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

from identification.encoder import misfit
from identification.newton import Solution
from identification.programme import Programme

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
    hessian = solution.look.hessian.damped(1e-12)
    information = hessian.reduced()
    inverse = np.asarray(np.linalg.inv(information), dtype=np.float64)
    reduction = hessian.reduction()
    changes = []
    for i, of in enumerate(programme.releases):
        made = solution.look.swings[i]
        told = misfit(of.psi, made.psi, of.step, solution.noise)
        at = programme.shared_columns(i)
        local = _local_inverse(inverse[np.ix_(at, at)], reduction[i, at], hessian.own[i])
        for part in half_swings(made.psi):
            along = made.sensitivities[part]
            curvature = along.T @ (along * told.curvature[part, None])
            score = _without(local, curvature, along.T @ told.slope[part])
            telling = -reduction[i] @ score[len(at) :]
            telling[at] += score[: len(at)]
            changes.append(inverse @ telling)
    return Spread(
        covariance=np.sum([np.outer(change, change) for change in changes], axis=0),
        information=information,
        freedom=max(len(changes) - len(information), 1),
    )


def half_swings(psi: Array) -> list[slice]:
    """The samples between one turning point of the angle and the next."""
    heading = np.sign(np.diff(psi))
    turns = np.flatnonzero(heading[1:] * heading[:-1] < 0) + 1
    ends = [0, *turns.tolist(), psi.size]
    return [slice(a, b) for a, b in pairwise(ends) if b > a]


def _local_inverse(shared: Array, reduction: Array, own: Array) -> Array:
    """The part of the inverse Hessian that belongs to what one recording depends on."""
    cross = -shared @ reduction
    corner = np.linalg.inv(own) - reduction.T @ cross
    whole: Array = np.block([[shared, cross], [cross.T, corner]])
    return whole


def _without(inverse: Array, curvature: Array, score: Array) -> Array:
    """The score that moves the estimate as far as leaving this half swing out would.

    (H - C)^-1 g = H^-1 (1 - C H^-1)^-1 g, in the coordinates in which H is one.
    """
    root = np.linalg.cholesky(inverse)
    shares, axes = np.linalg.eigh(root.T @ curvature @ root)
    left = 1 - np.minimum(shares, _MOST_LEVERAGE)
    moved: Array = np.linalg.solve(root.T, axes @ ((axes.T @ (root.T @ score)) / left))
    return moved
