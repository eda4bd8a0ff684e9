"""Likelihood of free vibrations: objective, gradient and Hessian over all recordings.

The unknowns are k and b_t, shared by all; one slip 1/(mu F_N) for each contact; and for each recording
the angle and the rate at its first turning point and the centre of its vibration. Propagation eliminates
the dynamics (`identification.free_decay.vibration_model`).

An encoder of step D shows the cell of the angle, not the angle: its error is a function of the angle,
neither white nor independent between samples, and below one step it is the only error. So a reading
counts as the statement y - D/2 <= psi + noise <= y + D/2, with noise of a logistic distribution of
scale s:

    P = F((y + D/2 - psi)/s) - F((y - D/2 - psi)/s),     F(u) = 1/(1 + exp(-u)).

The objective is the sum of -log P. It is convex in psi, grows linearly outside of the cell, so that no
outlier dominates, tends to the hard limits of the cell for s -> 0 and to an ordinary density for D -> 0.
As it is convex in the angles, the Gauss-Newton Hessian, without the curvature of the angles themselves,
is positive.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar
from scipy.special import expit

from identification.free_decay.vibration_detection import FreeVibration
from identification.free_decay.vibration_model import (
    UNKNOWNS,
    VibrationTrajectory,
    rotational_stiffness,
    simulate_vibration,
)
from symbolic import full_slide_level
from symbolic.float_array_type import Array

COMMON = 2
"""k and b_t lead the shared unknowns."""
_OWN = 3
"""Angle, rate and centre belong to a recording."""
_MAX_PHASE_STEP = 0.06
"""Longest step of the integration [rad of the vibration]."""
_FIRST_SLIDING = 0.05
"""First guess of the share of the half-length that slides at either end in the first swing [1]."""
_MIN_NOISE = 0.01
"""Least scale of the noise, in steps of the encoder."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LikelihoodEvaluation:
    """The objective at one point, infinite where a wheel would not vibrate, and its derivatives."""

    cost: float
    gradient: Array
    hessian: Array
    responses: tuple[VibrationTrajectory, ...]  # By the scaled unknowns in the order of `columns`.


class Likelihood:
    """The likelihood of a set of recordings.

    Attributes:
        vibrations: the recordings.
        contacts: contacts that have a slip of their own; none where the patch sticks.
        shared: number of shared unknowns, which lead the others: k, b_t and the slips.
        scales: size of every unknown, shape (n,); points are in units of these.
    """

    def __init__(self, vibrations: Sequence[FreeVibration], *, sliding: bool = True) -> None:
        """Build it; without sliding, the whole patch sticks as in [Györök 2022], (5.6)."""
        self.vibrations = tuple(vibrations)
        self.contacts = tuple(dict.fromkeys(r.contact for r in vibrations)) if sliding else ()
        self.shared = COMMON + len(self.contacts)
        self.scales = self._scales()
        self._grids = [integration_grid(r) for r in vibrations]
        self._geometries = [np.array([*r.contact, r.decay.inertia]) for r in vibrations]

    def columns(self, recording: int) -> list[int]:
        """Places of k, b_t, the slip of a recording's contact if there is one, and its own three."""
        contact = self.vibrations[recording].contact
        slip = [COMMON + self.contacts.index(contact)] if self.contacts else []
        own = self.shared + _OWN * recording
        return [*range(COMMON), *slip, *range(own, own + _OWN)]

    def start(self) -> Array:
        """The guess to begin with, in units of `scales`."""
        own = np.array([[r.peak, 0.0, r.centre] for r in self.vibrations]).ravel()
        return np.concatenate([np.ones(self.shared), own / self.scales[self.shared :]])

    def evaluate(self, x: Array, noise: float) -> LikelihoodEvaluation:
        """Objective and derivatives at x, in units of `scales`, for a scale of the noise [rad]."""
        cost, gradient, hessian = 0.0, np.zeros(x.size), np.zeros((x.size, x.size))
        responses = []
        for i, vibration in enumerate(self.vibrations):
            response, columns = self._response(i, x), self.columns(i)
            responses.append(response)
            if not np.isfinite(response.psi).all():
                cost = np.inf
                continue
            losses = neg_log_likelihood(vibration.psi, response.psi, vibration.step, noise)
            slopes = response.sensitivities
            cost += float(losses.value.sum())
            gradient[columns] += slopes.T @ losses.slope
            hessian[np.ix_(columns, columns)] += slopes.T @ (slopes * losses.curvature[:, None])
        return LikelihoodEvaluation(
            cost=cost, gradient=gradient, hessian=hessian, responses=tuple(responses)
        )

    def likeliest_noise(self, responses: Sequence[VibrationTrajectory]) -> float:
        """The most likely scale of the noise [rad]."""

        def cost(log_scale: float) -> float:
            scale = float(np.exp(log_scale))
            return sum(
                float(neg_log_likelihood(r.psi, response.psi, r.step, scale).value.sum())
                for r, response in zip(self.vibrations, responses, strict=True)
            )

        least = np.log(_MIN_NOISE * max(r.step for r in self.vibrations))
        most = np.log(max(abs(r.first_deflection) for r in self.vibrations))
        return float(np.exp(minimize_scalar(cost, bounds=(least, most), method="bounded").x))

    def _response(self, recording: int, x: Array) -> VibrationTrajectory:
        """Angles at the samples and their derivatives by x."""
        at = self.columns(recording)
        # Without a slip among the unknowns it is 0: the patch sticks.
        places = [*range(len(at) - _OWN), *range(len(UNKNOWNS) - _OWN, len(UNKNOWNS))]
        unknowns = np.zeros(len(UNKNOWNS))
        unknowns[places] = self.scales[at] * x[at]
        times, samples = self._grids[recording]
        fine = simulate_vibration(times, unknowns, self._geometries[recording])
        return VibrationTrajectory(
            fine.psi[samples], fine.sensitivities[np.ix_(samples, places)] * self.scales[at]
        )

    def _scales(self) -> Array:
        """Size of every unknown, from the guesses of `find_vibration`, [Györök 2022], (5.7), (5.8)."""
        squares = np.array([r.omega**2 + r.damping**2 for r in self.vibrations])
        inertia = np.array([r.decay.inertia for r in self.vibrations])
        per_k = np.array([rotational_stiffness(1, *r.contact) for r in self.vibrations])
        k = float(np.median(squares * inertia / per_k))
        b_t = float(np.median([2 * r.decay.inertia * r.damping for r in self.vibrations]))
        slips = []
        for a, e in self.contacts:
            least = min(abs(r.first_deflection) for r in self.vibrations if r.contact == (a, e))
            slips.append(_FIRST_SLIDING * a * float(full_slide_level(1, a)) / (k * least))
        swings = [(abs(r.first_deflection), abs(r.first_deflection) * r.omega) for r in self.vibrations]
        own = np.array([[angle, rate, angle] for angle, rate in swings])
        return np.concatenate([[k, b_t, *slips], own.ravel()])


def integration_grid(vibration: FreeVibration) -> tuple[Array, NDArray[np.intp]]:
    """Times short enough for the integration [s], and the places of the samples among them."""
    steps = np.ceil(np.diff(vibration.t) * vibration.omega / _MAX_PHASE_STEP)
    parts = np.maximum(steps, 1).astype(np.intp)
    samples = np.concatenate([[0], np.cumsum(parts)])
    return np.interp(np.arange(samples[-1] + 1), samples, vibration.t), samples


class NegLogLikelihood(NamedTuple):
    """-log P of readings, and its first and second derivatives by the angle, shape (n,)."""

    value: Array
    slope: Array
    curvature: Array


def neg_log_likelihood(read: Array, angle: Array, step: float, scale: float) -> NegLogLikelihood:
    """The misfit -log P between readings and angles (n,) with the encoder's step D, noise s [rad]."""
    upper, lower = (read + step / 2 - angle) / scale, (read - step / 2 - angle) / scale
    # F(u) - F(l) = F(u) F(-l) (1 - exp(l - u)), in which nothing cancels.
    width = np.log(-np.expm1(-step / scale))
    cost = np.logaddexp(0, -upper) + np.logaddexp(0, lower) - width
    above, below = expit(-upper), expit(lower)
    curvature = above * (1 - above) + below * (1 - below)
    return NegLogLikelihood(cost, (above - below) / scale, curvature / scale**2)
