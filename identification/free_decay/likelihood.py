"""The nonlinear programme of free vibrations: objective, gradient and Hessian over all recordings.

Unknown are k and b_t, shared by all; one slip 1/(mu F_N) for each contact; and for each recording angle
and rate at its first turning point and the centre of its vibration. The dynamics are eliminated by
propagation (`identification.free_decay.vibration`), the objective is -log of the likelihood of the
encoder's readings (`identification.free_decay.quantisation`). It is convex in the angles, so that the
Hessian without the curvature of the angles themselves is positive: that of Gauss and Newton, with exact
first derivatives, for this likelihood.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from identification.free_decay.onset import Release
from identification.free_decay.quantisation import misfit
from identification.free_decay.vibration import UNKNOWNS, Swing, stiffness, swing
from symbolic import full_slide_level

Array = NDArray[np.float64]
Contact = tuple[float, float]
"""a and e [m]; recordings that share them share the slip."""

COMMON = 2
"""k and b_t lead what is shared."""
_OWN = 3
_LONGEST_STEP = 0.06
"""Longest step of the integration [rad of the vibration]."""
_FIRST_REACH = 0.05
"""Slip to begin with: share of the half-length that slides at either end in the first swing [1]."""
_NARROWEST = 0.01
"""Least scale of the noise, in steps of the encoder."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Look:
    """The programme at one point.

    Attributes:
        cost: objective; infinite where a wheel would not vibrate.
        gradient: its gradient, shape (n,).
        hessian: its Hessian, shape (n, n).
        swings: each recording's angles [rad] and their derivatives by the unknowns in their scales,
            in the order of `Programme.columns`.
    """

    cost: float
    gradient: Array
    hessian: Array
    swings: tuple[Swing, ...]


class Programme:
    """The nonlinear programme of a set of recordings.

    Attributes:
        releases: the recordings.
        contacts: contacts that have a slip of their own; none where the patch sticks.
        shared: number of unknowns that lead the others: k, b_t and the slips.
        scales: size of every unknown, shape (n,); points are in units of these.
    """

    def __init__(self, releases: Sequence[Release], *, sliding: bool = True) -> None:
        """Sets it up; without sliding, the ends of the patch stick as in the source."""
        self.releases = tuple(releases)
        self.contacts = tuple(dict.fromkeys(map(contact_of, releases))) if sliding else ()
        self.shared = COMMON + len(self.contacts)
        self.scales = self._scales()
        self._grids = [_grid(r) for r in releases]
        self._geometries = [np.array([*contact_of(r), r.decay.inertia]) for r in releases]

    def columns(self, recording: int) -> list[int]:
        """Places of k, b_t, the slip of a recording's contact if there is one, and its own three."""
        contact = contact_of(self.releases[recording])
        slip = [COMMON + self.contacts.index(contact)] if self.contacts else []
        own = self.shared + _OWN * recording
        return [*range(COMMON), *slip, *range(own, own + _OWN)]

    def start(self) -> Array:
        """The guess to begin with, in units of `scales`."""
        own = np.array([[r.peak, 0.0, r.centre] for r in self.releases]).ravel()
        return np.concatenate([np.ones(self.shared), own / self.scales[self.shared :]])

    def look(self, x: Array, noise: float) -> Look:
        """Objective and derivatives at x, in units of `scales`, for a scale of the noise [rad]."""
        cost, gradient, hessian = 0.0, np.zeros(x.size), np.zeros((x.size, x.size))
        swings = []
        for i, of in enumerate(self.releases):
            made, at = self._swing(i, x), self.columns(i)
            swings.append(made)
            if not np.isfinite(made.psi).all():
                cost = np.inf
                continue
            told = misfit(of.psi, made.psi, of.step, noise)
            cost += float(told.cost.sum())
            gradient[at] += made.sensitivities.T @ told.slope
            hessian[np.ix_(at, at)] += made.sensitivities.T @ (
                made.sensitivities * told.curvature[:, None]
            )
        return Look(cost=cost, gradient=gradient, hessian=hessian, swings=tuple(swings))

    def likeliest_noise(self, swings: Sequence[Swing]) -> float:
        """The scale of the noise under which the readings are likeliest [rad]."""

        def cost(log_scale: float) -> float:
            scale = float(np.exp(log_scale))
            return sum(
                float(misfit(r.psi, made.psi, r.step, scale).cost.sum())
                for r, made in zip(self.releases, swings, strict=True)
            )

        least = np.log(_NARROWEST * max(r.step for r in self.releases))
        most = np.log(max(abs(r.reach) for r in self.releases))
        return float(np.exp(minimize_scalar(cost, bounds=(least, most), method="bounded").x))

    def _swing(self, recording: int, x: Array) -> Swing:
        """Angles at the samples and their derivatives by x."""
        at = self.columns(recording)
        # Without a slip among the unknowns it is 0: the patch sticks.
        places = [*range(len(at) - _OWN), *range(len(UNKNOWNS) - _OWN, len(UNKNOWNS))]
        unknowns = np.zeros(len(UNKNOWNS))
        unknowns[places] = self.scales[at] * x[at]
        times, seen = self._grids[recording]
        made = swing(times, unknowns, self._geometries[recording])
        return Swing(made.psi[seen], made.sensitivities[np.ix_(seen, places)] * self.scales[at])

    def _scales(self) -> Array:
        """Size of every unknown, from the guesses of `release`."""
        k, b_t = first_guess(self.releases)
        slips = [
            max(
                _FIRST_REACH * contact[0] * float(full_slide_level(1, contact[0])) / (k * abs(r.reach))
                for r in self.releases
                if contact_of(r) == contact
            )
            for contact in self.contacts
        ]
        own = np.array([[abs(r.reach), abs(r.reach) * r.omega, abs(r.reach)] for r in self.releases])
        return np.concatenate([[k, b_t, *slips], own.ravel()])


def contact_of(of: Release) -> Contact:
    """Where the wheel touches the ground."""
    return of.decay.rig.a, of.decay.rig.e


def first_guess(releases: Sequence[Release]) -> tuple[float, float]:
    """Guesses of k [N/m^2] and b_t [N m s/rad] from those of frequency and damping, (5.7), (5.8)."""
    k = [(r.omega**2 + r.damping**2) * r.decay.inertia / stiffness(1, *contact_of(r)) for r in releases]
    b_t = [2 * r.decay.inertia * r.damping for r in releases]
    return float(np.median(k)), float(np.median(b_t))


def _grid(of: Release) -> tuple[Array, NDArray[np.intp]]:
    """Times short enough for the integration [s], and where the samples are among them."""
    parts = np.maximum(np.ceil(np.diff(of.t) * of.omega / _LONGEST_STEP), 1).astype(np.intp)
    seen = np.concatenate([[0], np.cumsum(parts)])
    return np.interp(np.arange(seen[-1] + 1), seen, of.t), seen
