"""Profile likelihood: one value fixed along a grid, all else fitted again at each point.

The deviance n ln(cost / least cost), n the number of independent samples, is the likelihood ratio of
noise whose size is unknown. By Wilks's theorem (1938) a value lies where its deviance is below the
quantile of chi2(1). Where the deviance stays below up to an end of the grid, the recordings do not bound
the value on that side.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from identification.fits.autocorrelation import effective_samples
from identification.fits.fitting import Fit, fit
from identification.fits.options import FINE_FIT, FitOptions, OwnerAndName
from identification.fits.values_by_ground_and_recording import Values, complete_values
from identification.reading.recordings import Recording
from symbolic import TOLERATED, InvalidInputError, Model, Rig, units_of
from symbolic.float_array_type import Array

AxisPoint = tuple[list[Recording], Values]
"""Recordings and parameters with a value of the axis in them."""


@dataclass(frozen=True, kw_only=True)
class ProfiledParameter:
    """A parameter of the model: `k`, `mu` or `effect.parameter`.

    It belongs to a recording or to a ground of this name; without, to the tyre.
    """

    name: str
    recording: str | None = None

    @property
    def fixed_labels(self) -> tuple[OwnerAndName, ...]:
        """Parameters that the fit has to leave alone."""
        return ((self.recording, self.name),)

    def name_and_unit(self, model: Model) -> tuple[str, str]:
        """Name and unit of the quantity."""
        units = units_of(model)
        if self.name not in units:
            raise InvalidInputError(f"unknown parameter {self.name!r}; the model has {', '.join(units)}")
        owner = f" [{self.recording}]" if self.recording else ""
        return f"{self.name}{owner}", units[self.name]

    def initial(self, values: Values) -> float:
        """The value that belongs to the start of the profile."""
        try:
            return values.at((self.recording, self.name))
        except KeyError:
            owner = "all recordings" if self.recording is None else repr(self.recording)
            raise InvalidInputError(f"{self.name} is no parameter of {owner}") from None

    def recordings_and_values_at(
        self, value: float, recordings: Sequence[Recording], values: Values
    ) -> AxisPoint:
        """Recordings and parameters at a value."""
        return list(recordings), values.having({(self.recording, self.name): value})


@dataclass(frozen=True, kw_only=True)
class ProfiledRigLength:
    """A length of the rig, changed in every recording alike.

    The neutral value leaves the rig as declared; `lengths_at` gives the changed lengths by name.
    """

    name: str
    unit: str
    neutral: float
    lengths_at: Callable[[Rig, float], dict[str, float]]
    fixed_labels: tuple[OwnerAndName, ...] = ()

    def name_and_unit(self, _: Model) -> tuple[str, str]:
        """Name and unit of the quantity."""
        return self.name, self.unit

    def initial(self, _: Values) -> float:
        """The value of the rig as declared."""
        return self.neutral

    def recordings_and_values_at(
        self, value: float, recordings: Sequence[Recording], values: Values
    ) -> AxisPoint:
        """Recordings with such a length, which then has no tolerance."""
        changed = []
        for recording in recordings:
            lengths = self.lengths_at(recording.rig, value)
            exact = replace(recording.rig.tolerances, **dict.fromkeys(lengths, 0.0))
            changed.append(replace(recording, rig=replace(recording.rig, **lengths, tolerances=exact)))
        return changed, values


ProfileAxis = ProfiledParameter | ProfiledRigLength
HALF_LENGTH = ProfiledRigLength(
    name="a over a as declared", unit="1", neutral=1.0, lengths_at=lambda rig, x: {"a": rig.a * x}
)
"""The half-length of the patch, as a factor."""
CASTER = ProfiledRigLength(
    name="e less e as declared", unit="m", neutral=0.0, lengths_at=lambda rig, x: {"e": rig.e + x}
)
"""The caster length, as a shift [m]."""


FittedAt = Callable[[float, Values], Fit]
"""A fit with a value fixed, begun from other values."""
LIMIT = 3.841458820694124
"""95 % quantile of chi2(1)."""
REFINEMENTS = 4
"""Most values inserted to find the least cost."""
MIN_COST_REDUCTION = 1e-6
"""Least reduction of the cost that a refinement has to promise, as a share [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Profile:
    """The deviance along one value.

    Attributes:
        name: the quantity along the axis.
        unit: its unit.
        grid: its values, the best one among them, increasing, shape (n,).
        deviance: n ln(cost / least cost), shape (n,).
        samples: number of independent samples at the best one.
        best: the value of least deviance.
        interval: 95 % interval; None for an end that the grid does not reach: the profile is open there.
        paths: every other free parameter along the grid, shape (n,) each; the mean over recordings of
            parameters that belong to a recording.
        units: unit of each of these.
        converged: False where one of the fits stopped early.
    """

    name: str
    unit: str
    grid: Array
    deviance: Array
    samples: float
    best: float
    interval: tuple[float | None, float | None]
    paths: Mapping[str, Array]
    units: Mapping[str, str]
    converged: bool


def profile(
    model: Model,
    recordings: Sequence[Recording],
    start: Values,
    axis: ProfileAxis,
    grid: ArrayLike,
    options: FitOptions = FINE_FIT,
) -> Profile:
    """Fit everything else at every value of the grid, from the one nearest to the start outward.

    A few more values are inserted where a parabola through the least costs has its minimum. The start is
    best that of a fit; the grid has at least three values of the axis, increasing.

    Raises:
        InvalidInputError: the grid is no such grid, a value of it is not allowed, or the model has no
            such parameter.
    """
    name, unit = axis.name_and_unit(model)
    start = complete_values(model, start, recordings)
    values = np.asarray(grid, dtype=np.float64)
    if values.ndim != 1 or values.size < 3 or not (np.diff(values) > 0).all():
        raise InvalidInputError(f"the grid of {name} must be at least three increasing values")

    def fitted_at(value: float, near: Values) -> Fit:
        changed, begin = axis.recordings_and_values_at(value, recordings, near)
        return fit(model, changed, begin, replace(options, fixed=(*options.fixed, *axis.fixed_labels)))

    first = int(np.argmin(np.abs(values - axis.initial(start))))
    fits = dict(_fit_along_grid(values, first, start, fitted_at))
    _refine_around_minimum(fits, recordings, fitted_at)
    places = np.array(sorted(fits))
    ordered = [fits[place] for place in places]
    costs = np.array([one.cost(recordings) for one in ordered])
    best = int(np.argmin(costs))
    samples = effective_samples(ordered[best].residuals)
    deviance = samples * np.log(costs / costs[best])
    paths = _parameters_along_profile(ordered)
    return Profile(
        name=name,
        unit=unit,
        grid=places,
        deviance=deviance,
        samples=samples,
        best=float(places[best]),
        interval=_interval(places, deviance, best),
        paths=paths,
        units={path: (units_of(model) | TOLERATED).get(path, "1") for path in paths},
        converged=all(one.converged for one in ordered),
    )


def _fit_along_grid(
    values: Array, first: int, start: Values, fitted_at: FittedAt
) -> Iterator[tuple[float, Fit]]:
    """Fits along the grid, each begun where its neighbour ended."""
    middle = fitted_at(float(values[first]), start)
    yield float(values[first]), middle
    for side in (values[first + 1 :], values[:first][::-1]):
        near = middle.values
        for value in side.tolist():
            fitted = fitted_at(value, near)
            near = fitted.values
            yield value, fitted


def _refine_around_minimum(
    fits: dict[float, Fit], recordings: Sequence[Recording], fitted_at: FittedAt
) -> None:
    """Insert fits nearer and nearer to the least cost."""
    costs = {value: fitted.cost(recordings) for value, fitted in fits.items()}
    for _ in range(REFINEMENTS):
        if (between := _parabola_minimum(costs)) is None:
            break
        nearest = min(fits, key=lambda value: abs(value - between))
        fits[between] = fitted_at(between, fits[nearest].values)
        costs[between] = fits[between].cost(recordings)


def _parabola_minimum(costs: Mapping[float, float]) -> float | None:
    """Minimum of a parabola through the least costs; None at an end, or where it gains nothing."""
    places = np.array(sorted(costs))
    heights = np.array([costs[place] for place in places])
    least = int(np.argmin(heights))
    if least in (0, places.size - 1):
        return None
    low, middle, high = places[least - 1 : least + 2]
    relative = heights[least - 1 : least + 2] / heights[least] - 1
    unit = high - low
    bend, slope, _ = np.polyfit((np.array([low, middle, high]) - middle) / unit, relative, 2)
    if not slope**2 > 4 * bend * MIN_COST_REDUCTION:
        return None
    return float(np.clip(middle - unit * slope / (2 * bend), low, high))


def _interval(grid: Array, deviance: Array, at: int) -> tuple[float | None, float | None]:
    """Values at which the root of the deviance, nearly a straight line, passes the limit either side."""
    root, limit = np.sqrt(np.maximum(deviance, 0)), np.sqrt(LIMIT)
    ends: list[float | None] = []
    for side in (slice(at, None, -1), slice(at, None)):
        beyond = np.flatnonzero(root[side] > limit)
        if not beyond.size:
            ends.append(None)
            continue
        pair = slice(int(beyond[0]) - 1, int(beyond[0]) + 1)
        (near, far), (low, high) = grid[side][pair], root[side][pair]
        ends.append(float(near + (far - near) * (limit - low) / (high - low)))
    return ends[0], ends[1]


def _parameters_along_profile(fits: Sequence[Fit]) -> dict[str, Array]:
    """Every free parameter along the fits; the mean over recordings where it belongs to a recording."""
    paths: dict[str, Array] = {}
    for name in dict.fromkeys(name for _, name in fits[0].labels):
        owners = [owner for owner, label in fits[0].labels if label == name]
        values = [[one.values.at((owner, name)) for owner in owners] for one in fits]
        paths[name] = np.mean(values, axis=1)
    return paths
