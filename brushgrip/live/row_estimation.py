"""Estimates from samples as they come, equal to those of `estimate` from the recorded file."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from math import inf, isfinite, nan
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from brushgrip.estimation.recording_warnings import load_outside_model_note, torque_saturation_note
from brushgrip.live.mapped_columns import OF_CAR, OF_WHEEL, Row
from brushgrip.live.steering_adviser import SteeringAdviser
from identification.reading.car_as_mean_wheel import require_rack_travel_and_force
from identification.reading.car_units_and_signs import rack_position_and_force, require_plausible_car
from identification.reading.checked_sample_table import CAR_COLUMNS, MIN_SAMPLES, Table
from identification.reading.signal_map import ANGLES, NO_MAP, SignalMap
from identification.reading.yaw_rate_from_angle import require_rate_matches_angle
from observers import Estimate, Loop, Observer, Sample, Status
from observers.interfaces.car_observer import HOLDING
from observers.protocol import prior_estimate
from symbolic import InvalidInputError, Vehicle
from symbolic.vehicle.mean_wheel import wheel_from_rack
from symbolic.vehicle.rack_time_derivatives import RackTimeDerivatives

MAX_RATES = 2_000
"""Most samples of a rate that are held against the angle, which takes 20 ms."""


class EstimatedSample(NamedTuple):
    """A sample: recorded values, angle [rad], torque used [N m], and the estimate after it."""

    recorded: tuple[float, ...]
    psi: float
    torque: float
    estimate: Estimate


class _StretchEstimator:
    """Samples without a break; the first waits for its step from the second, as in `observers.run`."""

    def __init__(self, observer: Observer, adviser: SteeringAdviser | None) -> None:
        self.loop, self._adviser = Loop(observer, history=1), adviser
        if adviser is not None:
            adviser.begin(observer)
        self._channel = observer.channel
        self._waiting: tuple[tuple[float, ...], float, float, float, float] | None = None
        self._t = nan

    def __call__(
        self, recorded: tuple[float, ...], psi: float, F_N: float, torque: float, psi_dot: float = nan
    ) -> list[EstimatedSample]:
        """Points that are known with one more sample; its time is the first value that is recorded."""
        t, before, waiting = recorded[0], self._t, self._waiting
        self._t, sample = t, (recorded, psi, F_N, torque, psi_dot)
        if waiting is not None:
            self._waiting = None
            # As numpy.diff has it with such a sample before the first.
            return [
                self._estimate_sample(before - (2 * before - t), *waiting),
                self._estimate_sample(t - before, *sample),
            ]
        if not isfinite(before):
            self._waiting = sample
            return []
        return [self._estimate_sample(t - before, *sample)]

    def _estimate_sample(
        self, dt: float, recorded: tuple[float, ...], psi: float, F_N: float, torque: float, rate: float
    ) -> EstimatedSample:
        M_z, M = (torque, nan) if self._channel == "M_z" else (nan, torque)
        sample = Sample(psi=psi, psi_dot=rate, F_N=F_N, dt=dt, M_z=M_z, M=M)
        estimate = self.loop(sample)
        if self._adviser is not None:
            self._adviser(sample, self.loop.state, estimate)
        return EstimatedSample(recorded, psi, torque, estimate)


class RowEstimator(ABC):
    """Turns rows into points; `columns` of the recording are empty before the first usable row."""

    columns: tuple[str, ...]
    weaker: float = 0.0  # Share of friction that the weaker direction of a found model holds less [1].
    note: str = ""  # The same in words.
    loads: tuple[float, float] | None = None  # Least and greatest behind a found model [N].
    range_is_known: bool = False  # Whether the rig says up to where the torque's sensor is straight.
    _stretch: _StretchEstimator | None

    @property
    def suspicions(self) -> tuple[str, ...]:
        """Causes of `Status.SUSPECT`, a sentence each."""
        return () if self._stretch is None else self._stretch.loop.suspicions

    @abstractmethod
    def __call__(self, row: Row) -> list[EstimatedSample]:
        """The points that are known with one more row: none, one or several."""

    @abstractmethod
    def implausibility_text(self, recorded: NDArray[np.float64], /) -> str:
        """Wrong units and signs in samples, shape (n, columns), that the observer itself cannot see."""

    def remarks(self, recorded: NDArray[np.float64], /) -> str:
        """What samples, shape (n, columns), show beside friction, empty for nothing.

        The torque seems to end by a sensor whose range is not declared; the load is outside those behind
        a found model.
        """
        if "F_N" not in self.columns or not recorded.size:
            return ""
        psi, F_N, torque = recorded.T[1:4]
        ends = "" if self.range_is_known else torque_saturation_note(torque, psi, F_N)
        return "; ".join(filter(None, (ends, load_outside_model_note(F_N, self.loads))))

    @abstractmethod
    def reset(self) -> None:
        """Begin anew, at rest at the next usable row."""


class WheelRowEstimator(RowEstimator):
    """The wheel of a rig."""

    def __init__(
        self,
        observer_of: Callable[[str], Observer],
        adviser: SteeringAdviser | None = None,
        where: str = "",
        signals: SignalMap = NO_MAP,
    ) -> None:
        """Begin; `observer_of` gives the observer for a torque, M_z or M; messages name the source."""
        self._observer_of, self._adviser = cache(observer_of), adviser
        self._path, self._signals = Path(where), signals
        self.reset()

    def reset(self) -> None:
        """Begin anew, at rest at the next row with an angle and a load."""
        self.columns, self._stretch = (), None
        self._held: dict[str, float] = {}
        self._refused = ""

    def implausibility_text(self, recorded: NDArray[np.float64], /) -> str:
        """Why the rate is none of the angle; the observer itself suspects other units and signs."""
        if "psi_dot" in self.columns and not self._refused:
            known = recorded[np.isfinite(recorded[:, [1, 4]]).all(axis=1)]
            if len(known) >= MIN_SAMPLES:
                table = _table_from_rows(self._path, self.columns, known[-MAX_RATES:])
                table = replace(table, sources={c: self._signals.of(c) for c in ANGLES})
                try:
                    require_rate_matches_angle(table, *(table.columns[c] for c in ANGLES))
                except InvalidInputError as error:
                    self._refused = str(error)
        return self._refused

    def __call__(self, row: Row) -> list[EstimatedSample]:
        """The points that are known with one more row; load and rate keep their last values."""
        if self._stretch is None:
            self._choose_columns(row)
        if (stretch := self._stretch) is None:
            return []
        self._held |= {n: row[n] for n in ("F_N", "psi_dot") if isfinite(row.get(n, nan))}
        recorded = tuple(row.get(name, nan) for name in self.columns)
        rate = self._held["psi_dot"] if "psi_dot" in self.columns else nan
        return stretch(recorded, row.get("psi", nan), self._held["F_N"], recorded[3], rate)

    def _choose_columns(self, row: Row) -> None:
        """The columns, by the first row with an angle and a load."""
        if not (isfinite(row.get("psi", nan)) and isfinite(row.get("F_N", nan))):
            return
        torques = OF_WHEEL[1]
        there = [n for n in torques if isfinite(row.get(n, nan))] or [n for n in torques if n in row]
        torque = there[0] if there else torques[0]
        rate = ("psi_dot",) if isfinite(row.get("psi_dot", nan)) else ()
        self.columns = ("t", "psi", "F_N", torque, *rate)
        self._stretch = _StretchEstimator(self._observer_of(torque), self._adviser)


class CarStandstillEstimator(RowEstimator):
    """The mean front wheel of a car, each standstill by an observer of its own."""

    def __init__(
        self,
        vehicle: Vehicle,
        observers: Mapping[bool, Observer],
        where: str,
        adviser: SteeringAdviser | None = None,
    ) -> None:
        """Begin; observers by whether the brakes hold, and the source's name for messages."""
        self._vehicle, self._observers, self._adviser = vehicle, observers, adviser
        self._path = Path(where)
        self.reset()

    def reset(self) -> None:
        """Begin anew, at rest at the next row with an angle."""
        self.columns, self._stretch = (), None
        self._last = replace(prior_estimate(self._observers[self._vehicle.brakes]), status=Status.HELD)
        self._held = {"speed": inf, "brake": float(self._vehicle.brakes)}
        self._state: bool | None = None
        self._waiting: list[tuple[tuple[float, ...], float, float]] = []
        self._motion = RackTimeDerivatives()

    def __call__(self, row: Row) -> list[EstimatedSample]:
        """The points that are known with one more row; fewer than `MIN_SAMPLES` at rest are none."""
        if not self.columns:
            if not any(isfinite(row.get(n, nan)) for n in OF_CAR[0]):
                return []
            columns = ("t", *(n for n in CAR_COLUMNS if n in row))
            first = _table_from_rows(self._path, columns, np.array([[row[n] for n in columns]]))
            require_rack_travel_and_force(first, self._vehicle)
            self.columns = columns
            if "speed" not in columns:
                self._held["speed"] = 0.0
        recorded = tuple(row.get(name, nan) for name in self.columns)
        self._held |= {n: row[n] for n in ("speed", "brake") if isfinite(row.get(n, nan))}
        stands = abs(self._held["speed"]) <= self._vehicle.standstill
        state = self._held["brake"] > 0.5 if stands else None
        points: list[EstimatedSample] = []
        if state is not self._state:
            points += self._repeat_last_estimate()
            self._state, self._stretch, self._motion = state, None, RackTimeDerivatives()
        psi, M_z = self._mean_wheel_angle_and_torque(recorded, bool(state))
        self._waiting.append((recorded, psi, M_z if stands else nan))
        if state is None:
            return points + self._repeat_last_estimate()
        if self._stretch is None and len(self._waiting) >= MIN_SAMPLES:
            self._stretch = _StretchEstimator(self._observers[state], self._adviser)
        return (
            points if self._stretch is None else points + self._estimate_waiting_samples(self._stretch)
        )

    def implausibility_text(self, recorded: NDArray[np.float64], /) -> str:
        """Why the columns look like ones in other units or of other signs."""
        try:
            require_plausible_car(_table_from_rows(self._path, self.columns, recorded), self._vehicle)
        except InvalidInputError as error:
            return str(error)
        return ""

    def _mean_wheel_angle_and_torque(
        self, recorded: tuple[float, ...], brakes: bool
    ) -> tuple[float, float]:
        """Angle [rad] and torque [N m] of the mean wheel."""
        columns = {name: np.array([v]) for name, v in zip(self.columns, recorded, strict=True)}
        s, force = rack_position_and_force(columns, self._vehicle)
        moved = self._motion(recorded[0], float(s[0]), float(np.ravel(force)[0]))
        psi, M_z = wheel_from_rack(self._vehicle, *moved, brakes=brakes)
        return float(psi), float(M_z)

    def _estimate_waiting_samples(self, stretch: _StretchEstimator) -> list[EstimatedSample]:
        points: list[EstimatedSample] = []
        for recorded, psi, M_z in self._waiting:
            points += stretch(recorded, psi, self._vehicle.wheel_load, M_z)
        self._waiting = []
        if points:
            of_last = {name: getattr(points[-1].estimate, name) for name in HOLDING}
            self._last = replace(self._last, **of_last)
        return points

    def _repeat_last_estimate(self) -> list[EstimatedSample]:
        """Samples held back, with the last estimate repeated: the car rolls, or stood too shortly."""
        held = replace(self._last, M_z_predicted=nan, nis=nan, informed=False)
        points = [EstimatedSample(recorded, psi, nan, held) for recorded, psi, _ in self._waiting]
        self._waiting = []
        return points


def _table_from_rows(path: Path, columns: Sequence[str], rows: NDArray[np.float64]) -> Table:
    named = dict(zip(columns, rows.T, strict=True))
    return Table(path=path, columns=named, place=str, names=tuple(columns))
