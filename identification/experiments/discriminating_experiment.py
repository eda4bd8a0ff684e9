"""Which experiment would tell two effects apart that the recordings cannot.

T-optimal design (Atkinson and Fedorov, Biometrika 62 (1975) 57): take one model for true, let the rival
be refitted to the torque that it would make, and choose the manoeuvre in which most is left. The rival's
refit also has to keep to the recordings that are there, as it will when all are fitted together; these
enter to first order, through the Jacobian of its fit.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from identification.experiments.manoeuvres import manoeuvres
from identification.experiments.proposals import Proposal, proposal, seen_step
from identification.experiments.steering import STEP, Manoeuvre, reach_of
from identification.fits.fitting import Fit, torque_range
from identification.reading.recordings import Recording
from identification.selection.scoring import rmse_of
from symbolic import parameter_name, simulate

__all__ = ["Proposal", "propose"]

Array = NDArray[np.float64]
_ROUGH, _THOROUGH = 3, 20
"""Simulations for a refit of the rival where manoeuvres are ranked, and for the best of them."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _Outcome:
    """What a manoeuvre shows: the torques of both models [N m], and where the rival's refit ended."""

    manoeuvre: Manoeuvre
    torque: Array
    rival_torque: Array
    at: Array

    @property
    def difference(self) -> float:
        """How far the two are apart [N m]."""
        return rmse_of(self.torque - self.rival_torque)


def propose(found: Fit, rival: Fit, recordings: Sequence[Recording]) -> Proposal:
    """The manoeuvre within the rig's reach that would separate two fitted models best.

    Args:
        found: the model that is taken for true, fitted to the recordings.
        rival: another one that does as well, fitted to the same.
        recordings: those that both were fitted to; the fits may have seen thinned ones.
    """
    typical = _typical(found, recordings)
    span = float(np.mean([torque_range(r) for r in recordings]))
    truth, other = _Simulated(found, typical), _Rival(rival, typical, span)
    rough = []
    for manoeuvre in manoeuvres(reach_of(recordings)):
        torque = truth.torque(manoeuvre, truth.theta)[0]
        rough.append(other.refitted(manoeuvre, torque, other.origin, _ROUGH))
    rough.sort(key=lambda outcome: -outcome.difference)
    best = other.settled(rough[0])
    # A refit that goes on leaves less: once the best is ahead of what is rough, it stays ahead.
    for outcome in rough[1:]:
        if best.difference >= outcome.difference:
            break
        best = max(best, other.settled(outcome), key=lambda outcome: outcome.difference)
    return proposal(found, rival, recordings, best.manoeuvre, (best.torque, best.rival_torque))


def _typical(fitted: Fit, recordings: Sequence[Recording]) -> Recording:
    """The recording of median mu: what belongs to a recording is taken to be as there."""
    ordered = sorted(recordings, key=lambda r: fitted.values.own[r.name]["mu"])
    return ordered[(len(ordered) - 1) // 2]


class _Simulated:
    """A fitted model on manoeuvres, with the values of one recording."""

    def __init__(self, fitted: Fit, typical: Recording) -> None:
        self.model = fitted.model
        self.geometry = np.array([typical.rig.a, typical.rig.e])
        values = fitted.values.of(typical.name)
        self.theta: Array = np.asarray(fitted.model.theta(values)).ravel()

    def torque(self, manoeuvre: Manoeuvre, theta: Array) -> tuple[Array, Array]:
        """Torque [N m] and its derivatives by theta."""
        # All directions always, as in the fit: that Function is compiled already.
        directions = np.eye(theta.size)
        made = simulate(self.model, manoeuvre.signals, theta, self.geometry, directions)
        return made.M_z, made.sensitivities


class _Rival(_Simulated):
    """The rival, refitted to a torque while it keeps to the recordings that are there."""

    def __init__(self, fitted: Fit, typical: Recording, span: float) -> None:
        super().__init__(fitted, typical)
        names = [parameter_name(e, p) for e, p in fitted.model.parameters]
        mine = [i for i, (owner, _) in enumerate(fitted.labels) if owner in (None, typical.name)]
        self.free = np.array([names.index(fitted.labels[i][1]) for i in mine])
        self.scales = fitted.scales[mine]
        self.origin: Array = self.theta[self.free] / self.scales
        ends = []
        for column in self.free:
            parameter = fitted.model.parameters[column][1]
            lower, upper = (parameter.to_coordinate(v) for v in (parameter.lower, parameter.upper))
            ends.append(sorted((lower, upper)))
        self.bounds = np.array(ends).T / self.scales
        self.kept = _kept(fitted, mine)
        self.weight = np.sqrt(STEP / seen_step(fitted, typical)) / span

    def settled(self, rough: _Outcome) -> _Outcome:
        """A rough refit taken to its end."""
        return self.refitted(rough.manoeuvre, rough.torque, rough.at, _THOROUGH)

    def refitted(self, manoeuvre: Manoeuvre, torque: Array, start: Array, most: int) -> _Outcome:
        """The least squares of its torque error here and of what it gives up in the recordings."""

        def made(x: Array) -> tuple[Array, Array]:
            """What is left, and its derivatives; kept, as it is asked for twice."""
            if x.tobytes() not in known:
                theta = self.theta.copy()
                theta[self.free] = x * self.scales
                there, along = self.torque(manoeuvre, theta)
                left = np.concatenate([self.kept @ (x - self.origin), (there - torque) * self.weight])
                slopes = along[:, self.free] * self.scales * self.weight
                known[x.tobytes()] = (left, np.concatenate([self.kept, slopes]))
            return known[x.tobytes()]

        known: dict[bytes, tuple[Array, Array]] = {}
        low, high = self.bounds
        solved = least_squares(
            lambda x: made(x)[0],
            np.clip(start, low, high),
            jac=lambda x: made(x)[1],
            bounds=(low, high),
            ftol=1e-4,
            xtol=1e-4,
            gtol=1e-12,
            max_nfev=most,
        )
        left = solved.fun[len(self.kept) :] / self.weight
        return _Outcome(manoeuvre=manoeuvre, torque=torque, rival_torque=torque + left, at=solved.x)


def _kept(fitted: Fit, mine: Sequence[int]) -> Array:
    """Square root of the information on the shared parameters in the recordings, own ones let go.

    Columns as in `mine`, those of the recording's own parameters zero: a new recording has its own.
    """
    shared = [i for i, (owner, _) in enumerate(fitted.labels) if owner is None]
    own = [i for i, (owner, _) in enumerate(fitted.labels) if owner is not None]
    along, beside = fitted.jacobian[:, shared], fitted.jacobian[:, own]
    left = along - beside @ np.linalg.lstsq(beside, along, rcond=None)[0]
    root: Array = np.linalg.qr(left, mode="reduced").R
    kept = np.zeros((root.shape[0], len(mine)))
    for column, label in enumerate(shared):
        kept[:, mine.index(label)] = root[:, column]
    return kept
