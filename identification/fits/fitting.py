"""Parameters by nonlinear programming: bounded least squares on the free-run torque, exact Jacobians.

Every recording is simulated from its first sample to its last (never one step ahead). All recordings
share the rig's parameters; mu and whatever else belongs to a recording is each one's own. Residuals are
divided by the range of the recording's torque, so that each recording counts alike.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from identification.fits.loss import LEAST_SQUARES, Loss
from identification.fits.options import FINE_FIT, FitOptions, Label
from identification.reading.recordings import Recording
from symbolic import InvalidInputError, Model, Parameter, full_slide_torque, parameter_name, simulate

Array = NDArray[np.float64]
UPPER_QUANTILE = 0.98
"""Quantile of the torque's size from which the first guess of mu is taken: spikes are above it."""


@dataclass(frozen=True, kw_only=True)
class Values:
    """Parameter values by name (`mu`, `k`, `effect.parameter`), physical units.

    Attributes:
        shared: values that all recordings share.
        own: for each recording name, the values that are its own.
    """

    shared: Mapping[str, float]
    own: Mapping[str, Mapping[str, float]]

    def of(self, recording: str) -> dict[str, float]:
        """All values that hold for one recording."""
        return {**self.shared, **self.own[recording]}


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit:
    """A solved identification.

    Attributes:
        model: the model fitted.
        values: the parameters at the solution.
        residuals: for each recording, simulated minus measured torque [N m], NaN where missing.
        jacobian: of the stacked residuals over torque range, in scaled coordinates, rows of missing
            samples left out; the loss does not enter it.
        labels: recording and parameter of each Jacobian column.
        scales: size of a unit step of each column, in the parameter's coordinate.
        bound_distances: unit steps down (<= 0) and up (>= 0) to the bounds of each, shape (2, p).
        status: the solver's message at its end.
        converged: False where the solver stopped for another reason than its tolerances.
        loss: cost of a residual.
    """

    model: Model
    values: Values
    residuals: Mapping[str, Array]
    jacobian: Array
    labels: tuple[Label, ...]
    scales: Array
    bound_distances: Array
    status: str
    converged: bool
    loss: Loss = LEAST_SQUARES


def signals_of(recording: Recording) -> Array:
    """The model's inputs over a recording: psi, psi_dot, F_N, dt as rows, shape (4, n)."""
    dt = np.diff(recording.t)
    steps = np.concatenate([dt[:1], dt])
    return np.vstack([recording.psi, recording.psi_dot, recording.F_N, steps])


def torque_range(recording: Recording) -> float:
    """Greatest minus least measured torque [N m]."""
    span = float(np.nanmax(recording.M_z) - np.nanmin(recording.M_z))
    if not span > 0:
        raise InvalidInputError(
            f"{recording.name}: M_z is constant; a fit needs a recording in which the wheel is turned"
        )
    return span


def initial_guess(model: Model, recordings: Sequence[Recording]) -> Values:
    """The start of a fit: k as declared, mu from the largest torque, (3/8) mu F_N a."""
    own = {}
    for recording in recordings:
        slide = full_slide_torque(float(np.median(recording.F_N)), recording.rig.a)
        largest = float(np.nanquantile(np.abs(recording.M_z), UPPER_QUANTILE))
        own[recording.name] = {"mu": float(np.clip(largest / slide, 0.05, 5.0))}
    k = float(np.exp(np.mean([np.log(recording.tyre.k) for recording in recordings])))
    return with_effects(model, Values(shared={"k": k}, own=own), recordings)


def with_effects(model: Model, values: Values, recordings: Sequence[Recording]) -> Values:
    """The values, completed by those of every parameter of the model that they lack.

    A parameter that is never fitted takes the value that the recordings give, any other one its start.
    """
    shared, own = dict(values.shared), {name: dict(v) for name, v in values.own.items()}
    lengths, loads = [r.rig.a for r in recordings], [float(r.F_N.mean()) for r in recordings]
    given = {
        f"{effect.name}.{name}": value
        for effect in model.effects
        for name, value in effect.fixed_values(lengths, loads).items()
    }
    for effect, parameter in model.parameters:
        name = parameter_name(effect, parameter)
        for place in [shared] if parameter.scope == "shared" else own.values():
            place.setdefault(name, given.get(name, parameter.start))
    return Values(shared=shared, own=own)


def fit(
    model: Model,
    recordings: Sequence[Recording],
    start: Values | None = None,
    options: FitOptions = FINE_FIT,
) -> Fit:
    """Find the parameters of least loss over all recordings.

    Args:
        model: the model to fit.
        recordings: the measurements; names must differ.
        start: values to begin with; missing ones begin at their own start. None for `initial_guess`.
        options: loss, tolerance, and which parameters are fixed.

    Raises:
        InvalidInputError: a torque is constant, or no parameter is free.
    """
    begin = start or initial_guess(model, recordings)
    problem = _Problem(model, recordings, with_effects(model, begin, recordings), options)
    low, high = problem.bounds()
    solution = least_squares(
        problem.residuals,
        np.clip(problem.origin(), low, high),
        jac=problem.jacobian,
        bounds=(low, high),
        loss=options.loss,
        x_scale=1.0,
        ftol=options.tolerance,
        xtol=options.tolerance,
        gtol=1e-12,
        max_nfev=options.max_evaluations,
    )
    return Fit(
        model=model,
        values=problem.values(solution.x),
        residuals=problem.torque_errors(solution.x),
        # The solver's own is weighted by the loss.
        jacobian=problem.jacobian(solution.x),
        labels=tuple(problem.labels),
        scales=problem.scales,
        bound_distances=np.array([low, high]) - solution.x,
        status=str(solution.message),
        converged=solution.status > 0,
        loss=options.loss,
    )


class _Problem:
    """The stacked residuals and their Jacobian as functions of scaled free coordinates."""

    def __init__(
        self,
        model: Model,
        recordings: Sequence[Recording],
        start: Values,
        options: FitOptions,
    ) -> None:
        self.model, self.recordings, self.start = model, recordings, start
        self.parameters = [(parameter_name(e, p), p) for e, p in model.parameters]
        shared: list[Label] = [
            (None, name)
            for name, p in self.parameters
            if p.scope == "shared" and options.free_shared and not p.fixed
        ]
        own: list[Label] = [
            (recording.name, name)
            for recording in recordings
            for name, p in self.parameters
            if p.scope == "recording"
        ]
        self.labels = [label for label in (*shared, *own) if label not in options.fixed]
        if not self.labels:
            raise InvalidInputError("every parameter is fixed; a fit needs at least one that is free")
        self.by_name = dict(self.parameters)
        self.scales: Array = np.array([self._scale(self.by_name[name]) for _, name in self.labels])
        self.signals = {r.name: signals_of(r) for r in recordings}
        self.ranges = {r.name: torque_range(r) for r in recordings}
        self.present = {r.name: np.isfinite(r.M_z) for r in recordings}
        self._last: tuple[bytes, dict[str, tuple[Array, Array]]] | None = None

    @staticmethod
    def _scale(parameter: Parameter) -> float:
        return 1 / parameter.scale if parameter.inverse else parameter.scale

    def origin(self) -> Array:
        """The start in scaled coordinates."""
        coordinates = np.empty(len(self.labels))
        for i, (recording, name) in enumerate(self.labels):
            place = self.start.shared if recording is None else self.start.own[recording]
            coordinates[i] = self.by_name[name].to_coordinate(place[name])
        return coordinates / self.scales

    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds in scaled coordinates."""
        pairs = []
        for _, name in self.labels:
            parameter = self.by_name[name]
            ends = (
                parameter.to_coordinate(parameter.lower),
                parameter.to_coordinate(parameter.upper),
            )
            pairs.append((min(ends), max(ends)))
        low, high = np.array(pairs).T
        return low / self.scales, high / self.scales

    def values(self, x: Array) -> Values:
        """Physical values of scaled coordinates."""
        shared = dict(self.start.shared)
        own = {name: dict(v) for name, v in self.start.own.items()}
        for (recording, name), coordinate in zip(self.labels, x * self.scales, strict=True):
            place = shared if recording is None else own[recording]
            place[name] = self.by_name[name].to_coordinate(float(coordinate))
        return Values(shared=shared, own=own)

    def torque_errors(self, x: Array) -> dict[str, Array]:
        """Simulated minus measured torque of every recording [N m]."""
        torques = self._simulated(x)
        return {r.name: torques[r.name][0] - r.M_z for r in self.recordings}

    def residuals(self, x: Array) -> Array:
        """Stacked torque errors over range, missing samples left out."""
        errors = self.torque_errors(x)
        parts = [errors[r.name][self.present[r.name]] / self.ranges[r.name] for r in self.recordings]
        return np.concatenate(parts)

    def jacobian(self, x: Array) -> Array:
        """Exact derivatives of `residuals`."""
        torques = self._simulated(x)
        columns = {label: i for i, label in enumerate(self.labels)}
        blocks: list[Array] = []
        for recording in self.recordings:
            present = self.present[recording.name]
            block = np.zeros((int(present.sum()), len(self.labels)))
            for i, (name, parameter) in enumerate(self.parameters):
                label = (None if parameter.scope == "shared" else recording.name, name)
                if label in columns:
                    derivative = torques[recording.name][1][present, i]
                    block[:, columns[label]] = derivative / self.ranges[recording.name]
            blocks.append(block)
        return np.concatenate(blocks) * self.scales

    def _simulated(self, x: Array) -> dict[str, tuple[Array, Array]]:
        """Torque of every recording and its derivatives by every coordinate, cached for the last x."""
        key = x.tobytes()
        if self._last is None or self._last[0] != key:
            values = self.values(x)
            directions = np.eye(len(self.parameters))
            torques = {}
            for recording in self.recordings:
                theta = np.asarray(self.model.theta(values.of(recording.name))).ravel()
                geometry = np.array([recording.rig.a, recording.rig.e])
                torque = simulate(self.model, self.signals[recording.name], theta, geometry, directions)
                torques[recording.name] = (torque.M_z, torque.sensitivities)
            self._last = (key, torques)
        return self._last[1]
