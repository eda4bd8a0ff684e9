"""The columns of a recording out of the channels of a file, in SI units and on one clock."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from identification.reading.channels_by_name import (
    ChannelFile,
    ChannelSamples,
    missing_channels_error,
    resolve_columns,
)
from identification.reading.checked_sample_table import MAX_SAMPLES, Table
from identification.reading.map_for_recording import add_unit_by_name, choose_map_for_channels
from identification.reading.signal_map import ANGLES, SignalMap, SignalSource
from identification.reading.units import factor_of, is_unit, name_without_unit, unit_in_brackets
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.tables.toml_and_json_parsing import prefix_errors

_FASTER = 1.5
"""Ratio of samples from which the angle is sampled faster than the torque."""
_SAME_INSTANT = 1e-5
"""Samples of two channels so close are taken at once [s]."""
_TORQUES = ("M_z", "M", "F_rack", "T_bar")
_WAYS = ("psi", "rack", "handwheel")
"""Columns of torque or force, and of angle or way, the first one there sets the clock."""
_GAP = 5.0
"""Periods of a channel beyond which it is not interpolated."""
_BY_NAME, _BY_FILE = "units by the names; a map overrides them", "units as the file gives them"


def table_from_channels(
    path: Path, file: ChannelFile, needed: Sequence[str], signals: SignalMap
) -> Table:
    """The columns of a recording out of the channels of a file, in SI units.

    A channel with a time of its own goes onto the clock of the torque, by linear interpolation between
    its neighbours. Where the angle is sampled faster its instants join, the torque missing there.
    """
    signals = choose_map_for_channels(str(path), signals, file.names)
    names = resolve_columns(path, file, needed, signals)
    read = {c: _add_unit_from_name(c, name, file.read(name)) for c, name in names.items() if c != "t"}
    if not read:
        # Of a car, where no single column is needed.
        timeless = [] if file.own_clocks or "t" in names else ["t"]
        raise missing_channels_error(path, [*timeless, "rack", "F_rack"], file.names, signals)
    own_clocks = "t" not in signals.signals and all(s.times is not None for s in read.values())
    if own_clocks and names.get("t") == "t":
        own_clocks = not _is_common_clock(file.read("t"), *read.values())
    if not own_clocks:
        if "t" not in names:
            raise missing_channels_error(path, ["t"], file.names, signals, file.read)
        read = {"t": _add_unit_from_name("t", names["t"], file.read(names["t"])), **read}
    sources, in_si = dict[str, SignalSource](), dict[str, ChannelSamples]()
    remarks: dict[str, list[str]] = {_BY_NAME: [], _BY_FILE: []}
    for column, samples in read.items():
        source = signals.of(column, name_without_unit(names[column]))
        with prefix_errors(f"{path}: {names[column]}"):
            is_date = np.asarray(samples.values).dtype.kind in "mM"
            source, taken = (source, "") if is_date else add_unit_by_name(column, source, samples.unit)
            in_si[column] = replace(samples, values=_in_si(column, samples, source))
        remarks[_BY_NAME] += [taken] * bool(taken)
        if source.unit is None and samples.unit and factor_of(column, samples.unit) not in (None, 1.0):
            remarks[_BY_FILE].append(f"{name_without_unit(names[column])} in {samples.unit}")
        if column in ANGLES and source.unit is None:
            # So that a message asks for no unit that the file gives.
            source = replace(source, unit=samples.unit or None)
        sources[column] = source
        if samples.remark:
            remarks.setdefault(samples.remark, []).append(names[column])
    columns = _on_one_clock(path, in_si) if own_clocks else {c: s.values for c, s in in_si.items()}
    return Table(
        path=path,
        columns=columns,
        declared=file.declared,
        place=lambda of: f"sample {of + 1}" if isinstance(of, int) else f"scalar {of}",
        sources=sources,
        names=tuple(file.names),
        remarks=[f"{', '.join(channels)}: {remark}" for remark, channels in remarks.items() if channels],
    )


def apply_map(table: Table, needed: Sequence[str], signals: SignalMap) -> Table:
    """A table with a map applied to its columns; for readers that know none."""
    file = ChannelFile(
        names=tuple(table.columns), read=lambda name: ChannelSamples(values=table.columns[name])
    )
    mapped = table_from_channels(table.path, file, needed, signals)
    return replace(table, columns=mapped.columns, sources=mapped.sources, names=mapped.names)


def _is_common_clock(time: ChannelSamples, *channels: ChannelSamples) -> bool:
    """Whether a channel holds the times of all channels, and so tells where they begin, too."""
    return all(np.array_equal(time.values, np.asarray(s.times)) for s in channels)


def _add_unit_from_name(column: str, name: str, samples: ChannelSamples) -> ChannelSamples:
    """The samples with the unit in brackets behind the name, where the file says none."""
    unit = unit_in_brackets(name)
    return replace(samples, unit=unit) if not samples.unit and is_unit(column, unit) else samples


def _in_si(column: str, samples: ChannelSamples, source: SignalSource) -> Array:
    """The values as numbers; instants and durations of a time as seconds, instants since the first."""
    values = np.asarray(samples.values)
    if column == "t" and values.dtype.kind in "mM":
        if source.factor_to_si("t", "") != 1:
            raise InvalidInputError(f"has a unit of its own; write --map t={source.channel}")
        since: Any = values - values[:1] if values.dtype.kind == "M" else values
        seconds: Array = since / np.timedelta64(1, "s")
        return seconds
    if values.ndim != 1 or values.dtype.kind not in "fiub":
        raise InvalidInputError(f"the channel of {column} must be one row of real numbers")
    with np.errstate(over="ignore", invalid="ignore"):
        return values.astype(np.float64) * source.factor_to_si(column, samples.unit)


def _on_one_clock(path: Path, columns: Mapping[str, ChannelSamples]) -> dict[str, Array]:
    clocks = {column: np.asarray(s.times, dtype=np.float64) for column, s in columns.items()}
    first = next(iter(clocks.values()))
    if all(np.array_equal(clock, first) for clock in clocks.values()):
        with np.errstate(invalid="ignore"):  # a time that is infinite is a fault of its sample
            since = first - first[:1]
        return {"t": since, **{column: s.values for column, s in columns.items()}}
    for column, clock in clocks.items():
        if clock.size < 2 or not (np.diff(clock) > 0).all():
            raise InvalidInputError(f"{path}: the times of {column} must increase from sample to sample")
    angle = next(c for c in _WAYS if c in clocks)
    clock = clocks[next((c for c in _TORQUES if c in clocks), angle)]
    if clocks[angle].size > _FASTER * clock.size:
        clock = np.union1d(clock, clocks[angle])
        clock = clock[np.append(True, np.diff(clock) >= _SAME_INSTANT)]
    if clock.size > MAX_SAMPLES:
        raise InvalidInputError(f"{path}: holds {clock.size} samples, at most {MAX_SAMPLES} allowed")
    table = {"t": clock - clock[0]}
    for column, samples in columns.items():
        nearest = column in _TORQUES and clock is not clocks[column]
        table[column] = _channel_at(clock, clocks[column], samples.values, nearest=nearest)
    return table


def _channel_at(clock: Array, times: Array, values: Array, *, nearest: bool) -> Array:
    """A channel at other times; NaN in its gaps and, for a torque, where it was not sampled."""
    after = np.clip(np.searchsorted(times, clock), 1, times.size - 1)
    if nearest and clock.size > times.size:
        closest = np.where(clock - times[after - 1] < times[after] - clock, after - 1, after)
        return np.where(np.abs(times[closest] - clock) < _SAME_INSTANT, values[closest], np.nan)
    gap = times[after] - times[after - 1] > _GAP * float(np.median(np.diff(times)))
    outside = (clock < times[0]) | (clock > times[-1])
    exact = (times[after] == clock) | (times[after - 1] == clock)
    return np.where((gap & ~exact) | outside, np.nan, np.interp(clock, times, values))
