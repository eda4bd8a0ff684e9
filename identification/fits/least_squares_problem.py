"""The stacked residuals of recordings and their Jacobian, as functions of scaled free coordinates."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from identification.fits.autocorrelation import autocorrelation_time
from identification.fits.loss import influence
from identification.fits.options import FitOptions, OwnerAndName
from identification.fits.values_by_ground_and_recording import (
    Values,
    ground_of,
    grounds_of,
    rig_parameters,
)
from identification.reading.car_torques_beside_tyres import declared_vehicle_torques
from identification.reading.declared_sensor_range import drop_torques_beyond_range
from identification.reading.recordings import Recording
from symbolic import (
    GEOMETRY,
    RIG_DIRECTIONS,
    InvalidInputError,
    Model,
    Parameter,
    parameter_name,
    simulate,
)
from symbolic.float_array_type import Array

Simulated = tuple[Array, Mapping[OwnerAndName, Array]]
"""Torque of a recording, and its derivatives by label, each of shape (n,)."""
MIN_DECLARED_WEIGHT = 1e-9
"""Least weight of declared values where residuals are next to zero [1]."""

AT_ZERO = 0.02
"""Share of the torque range, outliers apart, within which a torque that was tared begins [1]."""


def signals_of(recording: Recording) -> Array:
    """The model's inputs over a recording: psi, psi_dot, F_N, dt as rows, shape (4, n)."""
    dt = np.diff(recording.t)
    steps = np.concatenate([dt[:1], dt])
    return np.vstack([recording.psi, recording.psi_dot, recording.F_N, steps])


def is_first_torque_zero(recording: Recording) -> bool:
    """Whether the first torque is zero to `AT_ZERO` of its range, as where it was set to zero there.

    False where it is missing. A relaxed wheel on a sensor that was not tared begins so, too.
    """
    torque = recording.M_z
    if not np.isfinite(torque[0]):
        return False
    return bool(abs(torque[0]) < AT_ZERO * np.ptp(np.nanquantile(torque, [0.01, 0.99])))


def torque_range(recording: Recording) -> float:
    """Greatest minus least measured torque within the range of its sensor [N m]."""
    torque = drop_torques_beyond_range(recording).M_z
    known = torque[np.isfinite(torque)]
    span = float(np.ptp(known)) if known.size else 0.0
    if not span > 0:
        within = " within the range of its sensor" * (recording.rig.range is not None)
        raise InvalidInputError(
            f"{recording.name}: M_z is constant{within}; a fit needs a recording in which the wheel is"
            " turned"
        )
    return span


def shares_of_torque_range(
    residuals: Mapping[str, Array], recordings: Sequence[Recording]
) -> dict[str, Array]:
    """Residuals [N m] of these recordings as shares of each one's torque range [1]."""
    return {r.name: residuals[r.name] / torque_range(r) for r in recordings}


class LeastSquaresProblem:
    """The stacked residuals and their Jacobian as functions of scaled free coordinates.

    These are of `labels` in units of `scales`. What has a prior was declared with a tolerance;
    `declared` is its value, the start of all else.
    """

    def __init__(
        self, model: Model, recordings: Sequence[Recording], start: Values, options: FitOptions
    ) -> None:
        """See `fit`; the start holds a value of every parameter."""
        self.model, self.recordings, self.start, self.loss = model, recordings, start, options.loss
        self.threads = options.threads
        self.parameters = [(parameter_name(e, p), p) for e, p in model.parameters]
        free = _free_parameters_by_label(self.parameters, recordings, options)
        self.by_label = {label: p for label, p in free.items() if label not in options.fixed}
        self.labels = list(self.by_label)
        if not self.labels:
            raise InvalidInputError("every parameter is fixed; a fit needs at least one that is free")
        scales = [1 / p.scale if p.inverse else p.scale for p in self.by_label.values()]
        self.scales: Array = np.array(scales)
        self.ranges = {r.name: torque_range(r) for r in recordings}
        self.signals = {r.name: signals_of(r) for r in recordings}
        self.present = {r.name: np.isfinite(r.M_z) for r in recordings}
        self.tolerated = {r.name: tuple(rig_parameters(r)) for r in recordings}
        self.torques_declared = {r.name: declared_vehicle_torques(r) for r in recordings}
        self.directions = {r.name: self._sensitivity_directions(r) for r in recordings}
        self.has_prior = np.array(
            [name in self.tolerated.get(owner or "", ()) for owner, name in self.labels]
        )
        starts = np.array([p.start for p in self.by_label.values()]) / self.scales
        self.declared: Array = np.where(self.has_prior, starts, self.start_coordinates())
        self._known: dict[bytes, dict[str, Simulated]] = {}

    def start_coordinates(self) -> Array:
        """The start in scaled coordinates."""
        coordinates = [p.to_coordinate(self.start.at(label)) for label, p in self.by_label.items()]
        return np.asarray(np.array(coordinates) / self.scales)

    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds in scaled coordinates."""
        ends = [sorted(map(p.to_coordinate, (p.lower, p.upper))) for p in self.by_label.values()]
        low, high = np.array(ends).T
        return low / self.scales, high / self.scales

    def values(self, x: Array) -> Values:
        """Physical values of scaled coordinates."""
        coordinates = zip(self.by_label.items(), x * self.scales, strict=True)
        return self.start.having({label: p.to_coordinate(float(c)) for (label, p), c in coordinates})

    def prior_weights(self, x: Array) -> Array:
        """Weight of a unit step away from a declared value, see `Fit.prior_weights`."""
        weights = np.zeros(len(self.labels))
        errors = self.torque_errors(x) if self.has_prior.any() else {}
        sizes = {}
        for name, error in errors.items():
            counted = influence(self.loss, error / self.ranges[name])
            sizes[name] = np.sqrt(float(np.nanmean(counted**2)) * autocorrelation_time(counted))
        for i in np.flatnonzero(self.has_prior):
            weights[i] = max(sizes[self.labels[i][0] or ""], MIN_DECLARED_WEIGHT)
        return weights

    def torque_errors(self, x: Array) -> dict[str, Array]:
        """Simulated minus measured torque of every recording [N m]."""
        torques = self._simulate_cached(x)
        return {r.name: torques[r.name][0] - r.M_z for r in self.recordings}

    def residuals(self, x: Array) -> Array:
        """Stacked torque errors, divided by each recording's torque range; without missing samples."""
        errors = self.torque_errors(x)
        return np.concatenate([errors[n][here] / self.ranges[n] for n, here in self.present.items()])

    def jacobian(self, x: Array) -> Array:
        """Exact derivatives of `residuals`."""
        torques = self._simulate_cached(x)
        columns = {label: i for i, label in enumerate(self.labels)}
        samples, at = sum(int(present.sum()) for present in self.present.values()), 0
        jacobian = np.zeros((samples, len(self.labels)))
        for name, present in self.present.items():
            rows = slice(at, at := at + int(present.sum()))
            for label, derivative in torques[name][1].items():
                if (i := columns.get(label)) is not None:
                    jacobian[rows, i] = derivative[present] / self.ranges[name] * self.scales[i]
        return jacobian

    def _simulate_cached(self, x: Array) -> dict[str, Simulated]:
        """Torque of every recording and its derivatives, cached for the last two x."""
        key = x.tobytes()
        if key not in self._known:
            # The solution is asked for again after a step from it that was rejected.
            last = list(self._known.items())[-1:]
            self._known = dict([*last, (key, self._torques(self.values(x)))])
        return self._known[key]

    def _torques(self, values: Values) -> dict[str, Simulated]:
        """Torque of every recording and its derivatives; compiled code runs beside other threads."""
        if self.threads == 1 or not self._known:
            # The first time it builds and compiles Functions, which CasADi does not do in threads.
            return {r.name: self._torque(r, values) for r in self.recordings}
        with ThreadPoolExecutor(self.threads) as pool:
            torques = pool.map(lambda recording: self._torque(recording, values), self.recordings)
            return {r.name: torque for r, torque in zip(self.recordings, torques, strict=True)}

    def _sensitivity_directions(self, recording: Recording) -> tuple[list[OwnerAndName], Array]:
        """Free labels, all where each number takes its Function, and the directions that they are."""
        count = len(self.parameters)
        rows = {owner_and_name(name, p, recording): i for i, (name, p) in enumerate(self.parameters)}
        rows |= {
            (recording.name, name): count + RIG_DIRECTIONS.index(name)
            for name in self.tolerated[recording.name]
            if name in RIG_DIRECTIONS
        }
        needed = [label for label in rows if self.model.uses_exact_patch or label in self.by_label]
        size = count + len(RIG_DIRECTIONS) * (len(rows) > count)
        return needed, np.eye(size)[:, [rows[label] for label in needed]]

    def _torque(self, recording: Recording, values: Values) -> Simulated:
        """Torque and its derivatives by the labels of `_sensitivity_directions`."""
        theta = np.array(self.model.coordinate_values(values.of(recording)))
        rig = values.rig.get(recording.name, {})
        # The signals of `replaced_rig`, without the checks of a new recording.
        signals = self.signals[recording.name] * np.array([[1.0], [1.0], [rig.get("load", 1.0)], [1.0]])
        needed, directions = self.directions[recording.name]
        geometry = np.array([rig.get(name, getattr(recording.rig, name)) for name in GEOMETRY])
        torque = simulate(self.model, signals, theta, geometry, directions)
        slopes = dict(zip(needed, torque.sensitivities.T, strict=True))
        if (load := (recording.name, "load")) in slopes:
            # The Function's factor on the load is relative to the load as corrected.
            slopes[load] = slopes[load] / rig["load"]
        shares = self.torques_declared[recording.name]
        slopes[recording.name, "zero"] = np.ones(recording.t.size)
        slopes |= {(recording.name, name): one.torque for name, one in shares.items()}
        others = sum(
            (one.torque * (rig[name] - 1) for name, one in shares.items()), rig.get("zero", 0.0)
        )
        return torque.M_z + others, slopes


def owner_and_name(name: str, parameter: Parameter, recording: Recording) -> OwnerAndName:
    """Owner and name of a parameter's value that holds for a recording."""
    owners = {"tyre": None, "ground": ground_of(recording), "recording": recording.name}
    return owners[parameter.scope], name


def _free_parameters_by_label(
    parameters: Sequence[tuple[str, Parameter]], recordings: Sequence[Recording], options: FitOptions
) -> dict[OwnerAndName, Parameter]:
    """Every free coordinate: of the tyre, of each ground, of each recording, of its rig."""
    free = [pair for pair in parameters if options.free_shared and not pair[1].fixed]
    labels: dict[OwnerAndName, Parameter] = {(None, name): p for name, p in free if p.scope == "tyre"}
    of_grounds = [pair for pair in free if pair[1].scope == "ground"]
    labels |= {(ground, name): p for ground in grounds_of(recordings) for name, p in of_grounds}
    for recording in recordings:
        labels |= {(recording.name, name): p for name, p in parameters if p.scope == "recording"}
    for recording in recordings:
        labels |= {(recording.name, name): p for name, p in rig_parameters(recording).items()}
    return labels
