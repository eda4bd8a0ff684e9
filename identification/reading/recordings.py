"""Recordings of a turning wheel at standstill."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from identification.loop_plot import ALIGNING, draw_loops
from identification.reading.car_as_mean_wheel import Standstills, hold_last_value, mean_wheel_table
from identification.reading.channels_by_name import ChannelFile, ChannelSamples
from identification.reading.checked_sample_table import (
    MIN_SAMPLES,
    Table,
    require_valid_samples,
    required_columns,
)
from identification.reading.common_clock_and_units import table_from_channels
from identification.reading.readers import READERS, Reader, read_table
from identification.reading.rigfile import rig_and_signals, rig_overridden_by_table
from identification.reading.signal_map import NO_MAP, SignalMap, SignalSource, parse_signals
from identification.reading.units import unit_in_brackets
from identification.reading.yaw_rate_from_angle import require_rate_matches_angle, smoothed_rate
from symbolic import InvalidInputError, Rig, Tyre
from symbolic.float_array_type import Array
from symbolic.tables.notebook_html import html_table
from symbolic.vehicle.mean_wheel import rig_of
from symbolic.vehicle.vehicle import Vehicle

if TYPE_CHECKING:
    from matplotlib.axes import Axes


_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True, eq=False)
class Recording:
    """One run on the rig. Arrays are read-only copies of shape (n,), n >= 3.

    Attributes:
        name: name in results and figures.
        t: time [s], increasing.
        psi: yaw angle [rad], without gaps.
        psi_recorded: bool (n,) where the angle was measured, not filled in; None for everywhere.
        psi_dot: yaw rate [rad/s], without gaps.
        psi_dot_recorded: True where the rate was measured, False where it was taken from psi.
        M_z: moment of the ground about the kingpin [N m], negative for a positive turn; NaN if missing.
        F_N: vertical load [N], greater than 0, without gaps.
        M: steering torque [N m], NaN where the sample is missing; None where not recorded.
        rig: the rig as declared.
        tyre: the tyre as declared.
        ground: name of what the wheel stands on; None where unknown.
        sources: channel of each column in the file, for messages.
        standstills: of a car, whose mean wheel this is; None for a wheel on a rig.

    Raises:
        InvalidInputError: shapes differ, time does not increase, a load is not greater than 0, or NaN.
    """

    name: str
    t: Array
    psi: Array
    psi_dot: Array
    M_z: Array
    F_N: Array
    M: Array | None = None
    psi_dot_recorded: bool = False
    psi_recorded: NDArray[np.bool_] | None = None
    rig: Rig
    tyre: Tyre
    ground: str | None = None
    sources: Mapping[str, SignalSource] = field(default_factory=dict)
    standstills: Standstills | None = None

    def __repr__(self) -> str:
        """One line: the name, how many samples, how long, and on what."""
        ground = f" on {self.ground}" if self.ground else ""
        return f"<Recording {self.name}{ground}: {self.t.size} samples, {self.t[-1] - self.t[0]:g} s>"

    def _repr_html_(self) -> str:
        """The same as a table, with the ranges by which a wrong unit shows."""
        title = f"Recording {self.name}" + (f" on {self.ground}" if self.ground else "")
        rows = [
            ("samples", f"{self.t.size} in {self.t[-1] - self.t[0]:g} s"),
            ("angle ψ", f"{_range_text(self.psi)} rad"),
            ("aligning torque M_z", f"{_range_text(self.M_z)} N m, {_missing_text(self.M_z)}"),
            ("load F_N", f"{_range_text(self.F_N)} N"),
            ("rig", f"a = {self.rig.a:g} m, e = {self.rig.e:g} m, k = {self.tyre.k:g} N/m²"),
        ]
        if self.M is not None:
            rows.insert(3, ("steering torque M", f"{_range_text(self.M)} N m, {_missing_text(self.M)}"))
        return html_table(title, rows)

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw aligning, else steering torque over the angle, into axes or new ones of pyplot."""
        label = ALIGNING if self.aligning_or_steering_torque is self.M_z else "steering torque $M$ [N m]"
        return draw_loops(axes, self.psi, {self.name: self.aligning_or_steering_torque}, label)

    @property
    def aligning_or_steering_torque(self) -> Array:
        """Aligning torque, or the steering torque where that alone is known [N m]."""
        return self.M_z if self.M is None or np.isfinite(self.M_z).any() else self.M

    def __post_init__(self) -> None:
        """Freeze the arrays and check them."""
        for name in ("t", "psi", "psi_dot", "M_z", "F_N", "M"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, self._read_only(name, value))
        if self.t.size < 3:
            raise InvalidInputError(f"{self.name}: {self.t.size} samples, at least 3 needed")
        for name in ("t", "psi", "psi_dot", "F_N"):
            if not np.isfinite(getattr(self, name)).all():
                raise InvalidInputError(f"{self.name}: {name} must be finite throughout")
        if np.isinf(self.M_z).any():
            raise InvalidInputError(f"{self.name}: M_z must be finite, or NaN where missing")
        if not (np.diff(self.t) > 0).all():
            raise InvalidInputError(f"{self.name}: t must increase from sample to sample")
        if not (self.F_N > 0).all():
            raise InvalidInputError(f"{self.name}: F_N must be greater than 0 throughout")

    @classmethod
    def from_dataframe(
        cls,
        frame: Any,
        rig: tuple[Rig, Tyre],
        *,
        name: str = "recording",
        signals: SignalMap | str = NO_MAP,
        torque_required: bool = True,
        causal: bool = False,
    ) -> "Recording":
        """A recording out of the columns of a data frame of pandas, polars or the like.

        It has one row a sample, NaN where a value is missing; `t` needs a column of its own. The other
        arguments are those of `read_recording`.

        Raises:
            InvalidInputError: a column is missing or not of numbers, or a sample is faulty.
        """
        signals = parse_signals(signals) if isinstance(signals, str) else signals
        file = ChannelFile(
            names=[str(column) for column in frame.columns],
            read=lambda column: ChannelSamples(
                values=np.asarray(frame[column]), unit=unit_in_brackets(column)
            ),
        )
        needed = required_columns(torque_required=torque_required)
        table = table_from_channels(Path(name), file, needed, signals)
        require_valid_samples(table, needed)
        return recording_of(table, rig, name, causal=causal)

    def _read_only(self, name: str, value: ArrayLike) -> Array:
        array = np.array(value, dtype=np.float64)
        if array.shape != np.shape(self.t) or array.ndim != 1:
            raise InvalidInputError(
                f"{self.name}: {name} has shape {array.shape}, t has {np.shape(self.t)}; "
                "equal one-dimensional shapes are needed"
            )
        array.setflags(write=False)
        return array


def read_recording(
    path: str | Path,
    rig: tuple[Rig, Tyre] | str | Path | None = None,
    *,
    torque_required: bool = True,
    causal: bool = False,
    readers: Mapping[str, Reader] = READERS,
    signals: SignalMap | str = NO_MAP,
    vehicle: Vehicle | None = None,
) -> Recording:
    """Read a recording from CSV, MATLAB, a format of a measurement system or one of the user's own.

    Gaps in psi, psi_dot and F_N are interpolated linearly, and at the ends extrapolated by the nearest
    sample. Without a column psi_dot, the rate is the smoothed derivative of psi.

    Args:
        path: the file.
        rig: the rig file, of which [signals] counts too, or rig and tyre as read by `read_rig`; values
            that the recording declares override them.
        torque_required: whether a recording without any M_z is a fault; otherwise M_z is all NaN.
        causal: fill gaps in psi, psi_dot and F_N from the past alone, as an observer has to; samples
            before the first with all three are left out, with a logged warning.
        readers: by the suffix of the file's name; `{**READERS, ".log": reader}` adds a format.
        signals: where columns come from, as read by `read_signals`, or ``psi=Angle:deg,M_z=-Mz``.
        vehicle: the car whose steering was recorded, see `identification.reading.car_as_mean_wheel`; the
            recording is then that of its mean wheel, and rig is not used.

    Raises:
        InvalidInputError: one line naming the file, the row, what is wrong and what is allowed.
    """
    path, (rig, signals) = Path(path), rig_and_signals(rig, signals)
    if vehicle is None:
        table = read_table(path, required_columns(torque_required=torque_required), readers, signals)
        return recording_of(table, rig, path.stem, causal=causal)
    wheel, standstills = mean_wheel_table(read_table(path, ("t",), readers, signals), vehicle)
    require_valid_samples(wheel, required_columns(torque_required=True))
    rig = rig_of(vehicle, brakes=standstills.brakes[0])
    recording = recording_of(replace(wheel, declared={}), rig, path.stem, causal=causal)
    stretch = standstills.stretch[-recording.t.size :]
    return replace(recording, standstills=replace(standstills, stretch=stretch))


def recording_of(
    table: Table, rig: tuple[Rig, Tyre] | None, name: str, *, causal: bool = False
) -> Recording:
    """The recording of a table whose samples were checked; arguments as of `read_recording`."""
    own_rig, own_tyre = rig_overridden_by_table(table, rig)
    columns = _from_first_complete(table) if causal else table.columns
    t = columns["t"]

    def fill(values: Array) -> Array:
        known = ~np.isnan(values)
        return hold_last_value(values, np.nan) if causal else np.interp(t, t[known], values[known])

    psi = fill(columns["psi"])
    psi_dot = columns.get("psi_dot")
    measured_rate = psi_dot is not None and not np.isnan(psi_dot).all()
    rate = fill(columns["psi_dot"]) if measured_rate else smoothed_rate(t, psi)
    if measured_rate:
        require_rate_matches_angle(table, psi, rate)
    return Recording(
        name=name,
        t=t,
        psi=psi,
        psi_recorded=~np.isnan(columns["psi"]),
        psi_dot_recorded=measured_rate,
        psi_dot=rate,
        M_z=columns.get("M_z", np.full(t.size, np.nan)),
        F_N=fill(columns["F_N"]),
        M=columns.get("M"),
        rig=own_rig,
        tyre=own_tyre,
        ground=table.ground,
        sources=table.sources,
    )


def _range_text(values: Array) -> str:
    known = values[np.isfinite(values)]
    return f"{known.min():.4g} to {known.max():.4g}" if known.size else "–"


def _missing_text(values: Array) -> str:
    count = int(np.count_nonzero(~np.isfinite(values)))
    return f"{count} samples missing" if count else "none missing"


def _from_first_complete(table: Table) -> Mapping[str, Array]:
    """The columns from the first sample on that has an angle, a load and, where recorded, a rate."""
    recorded = [
        np.isfinite(table.columns[name])
        for name in ("psi", "F_N", "psi_dot")
        if name in table.columns and np.isfinite(table.columns[name]).any()
    ]
    first = max(int(np.argmax(known)) for known in recorded)
    if first == 0:
        return table.columns
    t = table.columns["t"]
    begins = f"begins at {table.place(first)}, {t[first] - t[0]:.3g} s after the first"
    if t.size - first < MIN_SAMPLES:
        raise InvalidInputError(
            f"{table.path}: {begins}, the first one with an angle and a load; at least {MIN_SAMPLES}"
            " samples are needed from there on"
        )
    _LOG.warning("brushgrip: %s: %s; before it an angle or a load is missing", table.path, begins)
    return {name: values[first:] for name, values in table.columns.items()}
