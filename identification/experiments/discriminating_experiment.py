"""The experiment that would distinguish two effects which the recordings cannot.

T-optimal design [Atkinson 1975]: take one model for true, refit the rival to its torque, and choose the
manoeuvre with the largest remaining difference. The rival's refit is penalised for its error in the
recordings at hand, as when all are fitted together; these enter to first order, through the Jacobian of
its fit.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.optimize import least_squares

from identification.experiments.manoeuvre_in_recorded_range import (
    SAMPLE_PERIOD,
    SampledManoeuvre,
    recorded_range,
)
from identification.experiments.manoeuvres import manoeuvres
from identification.experiments.model_separation import (
    Proposal,
    fitted_sample_period,
    proposal_from_torques,
)
from identification.fits.fitting import Fit
from identification.fits.least_squares_problem import torque_range
from identification.fits.loss import rmse_of
from identification.fits.values_by_ground_and_recording import ground_of, replaced_rig
from identification.reading.recordings import Recording
from identification.selection.criteria import DEFAULT_CRITERIA, SelectionCriteria
from symbolic import parameter_name, simulate
from symbolic.float_array_type import Array

_ROUGH, _THOROUGH = 3, 20
"""Simulations for a refit of the rival where manoeuvres are ranked, and for the best of them."""


@dataclass(frozen=True, kw_only=True, eq=False)
class _RefitOutcome:
    """The torques of both models in a manoeuvre [N m], and the solution of the rival's refit."""

    manoeuvre: SampledManoeuvre
    torque: Array
    rival_torque: Array
    solution: Array

    @property
    def rms_torque_difference(self) -> float:
        """Rms difference of the two torques [N m]."""
        return rmse_of(self.torque - self.rival_torque)


def propose(
    found: Fit,
    rival: Fit,
    recordings: Sequence[Recording],
    criteria: SelectionCriteria = DEFAULT_CRITERIA,
) -> Proposal:
    """The manoeuvre within the rig's reach that would separate two fitted models best.

    The model found is taken for true; its rival does as well on the recordings that both were fitted to,
    or to thinned ones. They have to be distinguished by the criteria of the search.
    """
    # The recording of median mu, whose own parameters are assumed in the experiment.
    by_friction = sorted(recordings, key=lambda r: found.values.own[r.name]["mu"])
    typical = by_friction[(len(by_friction) - 1) // 2]
    span = float(np.mean([torque_range(r) for r in recordings]))
    truth, other = _SimulatedModel(found, typical), _RefittedRival(rival, typical, span)
    rough = []
    for manoeuvre in manoeuvres(recorded_range(recordings)):
        torque = truth.torque(manoeuvre, truth.theta)[0]
        rough.append(other.refit(manoeuvre, torque, other.origin, _ROUGH))
    rough.sort(key=lambda outcome: -outcome.rms_torque_difference)
    best = other.finish_refit(rough[0])
    # A longer refit lowers the difference: a rough one that is below the best stays below it.
    for outcome in rough[1:]:
        if best.rms_torque_difference >= outcome.rms_torque_difference:
            break
        best = max(best, other.finish_refit(outcome), key=lambda outcome: outcome.rms_torque_difference)
    torques = best.torque, best.rival_torque
    return proposal_from_torques(found, rival, recordings, best.manoeuvre, torques, criteria)


class _SimulatedModel:
    """A fitted model on manoeuvres, with the values of one recording."""

    def __init__(self, fitted: Fit, typical: Recording) -> None:
        self.model = fitted.model
        found = replaced_rig(typical, fitted.values)
        self.geometry = np.array([found.rig.a, found.rig.e])
        values = fitted.values.of(typical)
        self.theta: Array = np.asarray(fitted.model.theta(values)).ravel()

    def torque(self, manoeuvre: SampledManoeuvre, theta: Array) -> tuple[Array, Array]:
        """Torque [N m] and its derivatives with respect to theta."""
        # All directions always, as in the fit: that Function is compiled already.
        directions = np.eye(theta.size)
        simulated = simulate(self.model, manoeuvre.signals, theta, self.geometry, directions)
        return simulated.M_z, simulated.sensitivities


class _RefittedRival(_SimulatedModel):
    """The rival, refitted to a torque and, to first order, to the recordings at hand."""

    def __init__(self, fitted: Fit, typical: Recording, span: float) -> None:
        super().__init__(fitted, typical)
        names = [parameter_name(e, p) for e, p in fitted.model.parameters]
        owners = (None, ground_of(typical), typical.name)
        columns = [i for i, (o, name) in enumerate(fitted.labels) if o in owners and name in names]
        self.free = np.array([names.index(fitted.labels[i][1]) for i in columns])
        self.scales = fitted.scales[columns]
        self.origin: Array = self.theta[self.free] / self.scales
        free = [fitted.model.parameters[column][1] for column in self.free]
        ends = [sorted(map(p.to_coordinate, (p.lower, p.upper))) for p in free]
        self.bounds = np.array(ends).T / self.scales
        self.information_root = _information_root(fitted, columns)
        self.weight = np.sqrt(SAMPLE_PERIOD / fitted_sample_period(fitted, typical)) / span

    def finish_refit(self, rough: _RefitOutcome) -> _RefitOutcome:
        """Continue a rough refit until it converges."""
        return self.refit(rough.manoeuvre, rough.torque, rough.solution, _THOROUGH)

    def refit(
        self, manoeuvre: SampledManoeuvre, torque: Array, start: Array, most: int
    ) -> _RefitOutcome:
        """Least squares of its torque error here and, weighted by information, of its change [1]."""

        @cache
        def errors(x: bytes) -> tuple[Array, Array]:
            """Errors and their derivatives, for which the solver asks in turn."""
            at, theta = np.frombuffer(x), self.theta.copy()
            theta[self.free] = at * self.scales
            simulated, sensitivities = self.torque(manoeuvre, theta)
            change = self.information_root @ (at - self.origin)
            slopes = sensitivities[:, self.free] * self.scales * self.weight
            return (
                np.concatenate([change, (simulated - torque) * self.weight]),
                np.concatenate([self.information_root, slopes]),
            )

        low, high = self.bounds
        solved = least_squares(
            lambda x: errors(x.tobytes())[0],
            np.clip(start, low, high),
            jac=lambda x: errors(x.tobytes())[1],
            bounds=(low, high),
            ftol=1e-4,
            xtol=1e-4,
            gtol=1e-12,
            max_nfev=most,
        )
        rival_torque = torque + solved.fun[len(self.information_root) :] / self.weight
        return _RefitOutcome(
            manoeuvre=manoeuvre, torque=torque, rival_torque=rival_torque, solution=solved.x
        )


def _information_root(fitted: Fit, columns: Sequence[int]) -> Array:
    """Root of the recordings' information on these columns, zero for a recording's own parameters."""
    shared = [i for i, own in enumerate(fitted.recording_columns) if not own and i in columns]
    own = [i for i in range(len(fitted.labels)) if i not in shared]
    known = fitted.prior_weights > 0
    rows = np.concatenate([fitted.jacobian, np.diag(fitted.prior_weights)[known]])
    by_shared, by_own = rows[:, shared], rows[:, own]
    projected = by_shared - by_own @ np.linalg.lstsq(by_own, by_shared, rcond=None)[0]
    root: Array = np.linalg.qr(projected, mode="reduced").R
    padded = np.zeros((root.shape[0], len(columns)))
    for column, label in enumerate(shared):
        padded[:, columns.index(label)] = root[:, column]
    return padded
