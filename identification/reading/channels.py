"""Channels of a file as columns of a recording: which is which, and all of them on one clock."""

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from identification.reading.signal_map import NO_MAP, SignalMap
from identification.reading.table import (
    MOST_SAMPLES,
    OPTIONAL_COLUMNS,
    REQUIRED_COLUMNS,
    Array,
    Table,
)
from identification.reading.units import is_unit
from symbolic import InvalidInputError
from symbolic.tables.parsing import excerpt

COLUMNS = (*REQUIRED_COLUMNS, *OPTIONAL_COLUMNS)
MOST_NAMES = 20
"""Names of channels that a message lists."""
_WITH_UNIT = re.compile(r"(.*?)\s*[\[(]([^\])]*)[\])]\s*")
_USUAL_NAMES = {
    "t": ("time", "zeit", "timestamp", "sec"),
    "psi": ("psi", "angle", "winkel", "steer", "yaw", "lenk"),
    "M_z": ("mz", "torque", "moment", "align"),
    "F_N": ("fn", "fz", "load", "last", "force", "kraft", "normal"),
}
"""Parts of names that channels often have, in lower case."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Samples:
    """One channel.

    Attributes:
        values: shape (n,).
        unit: as the file says; empty where it does not.
        times: of the samples [s], shape (n,); None where the file keeps time in a channel of its own.
    """

    values: Array
    unit: str = ""
    times: Array | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelFile:
    """The channels of an open file.

    Attributes:
        names: full names; parts are separated by a slash or a dot, the last is the short name.
        read: the samples of a channel by its full name.
        declared: values that the file gives for a, e, k, mu, J_A, b_t.
        aliases: what a format calls the columns where there is no map, besides their own names.
    """

    names: Sequence[str]
    read: Callable[[str], Samples]
    declared: Mapping[str, float] = field(default_factory=dict)
    aliases: Mapping[str, str] = field(default_factory=dict)


Opener = Callable[[Path, SignalMap], AbstractContextManager[ChannelFile]]
"""Opens a file and lists its channels without reading them."""


def tabulate(path: Path, file: ChannelFile, needed: Sequence[str], signals: SignalMap) -> Table:
    """The columns of a recording out of the channels of a file, in SI units.

    A channel with a time of its own goes onto the clock of the torque, by linear interpolation between
    its neighbours. Where the angle is sampled faster its instants join, the torque missing there.

    Args:
        path: the file.
        file: its channels.
        needed: columns that the file must hold.
        signals: where columns come from.

    Raises:
        InvalidInputError: a channel is missing, has samples of another number, or an unknown unit.
    """
    full = {}
    for column in COLUMNS:
        wanted = [signals.of(column).channel]
        if column not in signals.signals and column in file.aliases:
            wanted.append(file.aliases[column])
        asked = column in signals.signals or column in needed
        found = next((n for w in wanted if (n := resolved(path, w, file.names, by_part=asked))), None)
        if found is not None:
            full[column] = found
    absent = [
        c for c in COLUMNS if c not in full and (c in signals.signals or (c in needed and c != "t"))
    ]
    if absent:
        raise InvalidInputError(missing_message(path, absent, file.names, signals))
    read = {column: file.read(name) for column, name in full.items() if column != "t"}
    columns = {}
    for column, samples in read.items():
        scale = signals.of(column).scale(column, samples.unit, f"{path}: {full[column]}")
        columns[column] = Samples(values=_floats(path, column, samples) * scale, times=samples.times)
    if "t" in signals.signals or not all(s.times is not None for s in columns.values()):
        if "t" not in full:
            raise InvalidInputError(missing_message(path, ["t"], file.names, signals))
        time = file.read(full["t"])
        scale = signals.of("t").scale("t", time.unit, f"{path}: {full['t']}")
        table = _of_one_length(path, {"t": _floats(path, "t", time) * scale}, columns)
    else:
        table = _on_one_clock(path, columns)
    return Table(
        path=path,
        columns=table,
        declared=file.declared,
        faults=(),
        place=lambda of: f"sample {of + 1}" if isinstance(of, int) else f"scalar {of}",
    )


def remapped(table: Table, needed: Sequence[str], signals: SignalMap) -> Table:
    """A table with a map applied to its columns; for readers that know none.

    Raises:
        InvalidInputError: the table lacks a mapped column.
    """
    file = ChannelFile(names=tuple(table.columns), read=lambda name: Samples(values=table.columns[name]))
    absent = [c for c, s in signals.signals.items() if s.channel not in file.names]
    if absent:
        raise InvalidInputError(missing_message(table.path, absent, file.names, signals))
    columns = tabulate(table.path, file, needed, signals).columns
    return Table(**{**vars(table), "columns": columns})


def resolved(path: Path, name: str, names: Sequence[str], *, by_part: bool = True) -> str | None:
    """The full name of a channel: exact, without its unit, or by its last part; None for no such one.

    Args:
        path: the file, for the message.
        name: as the map or the column has it.
        names: full names.
        by_part: whether the last parts of a full name are enough.

    Raises:
        InvalidInputError: several channels are meant.
    """
    if name in names:
        return name
    bare = {full: _without_unit(full) for full in names}
    exact = [full for full, short in bare.items() if short == name]
    ending = [
        full for full, short in bare.items() if by_part and short.endswith((f"/{name}", f".{name}"))
    ]
    for candidates in (exact, ending):
        if len(candidates) > 1:
            raise InvalidInputError(
                f"{path}: {excerpt(name)} may be {_listed(candidates)}; give the full name in --map"
            )
        if candidates:
            return candidates[0]
    return None


def unit_of_name(name: str) -> str:
    """The unit that a heading such as `Angle [deg]` holds; empty for none."""
    found = _WITH_UNIT.fullmatch(name)
    return found[2].strip() if found else ""


def missing_message(path: Path, absent: Sequence[str], names: Sequence[str], signals: SignalMap) -> str:
    """What is missing, what is there, and a map that may mend it."""
    wanted = ", ".join(
        c if c not in signals.signals else f"{c} (as {excerpt(signals.of(c).channel)})" for c in absent
    )
    plural = "s" * (len(absent) > 1)
    hint = map_hint(absent, names, signals)
    return f"{path}: channel{plural} {wanted} missing; there are {_listed(names)}{hint}"


def map_hint(absent: Sequence[str], names: Sequence[str], signals: SignalMap = NO_MAP) -> str:
    """A sentence that proposes a map, a torque in it; names that look alike are filled in."""
    left, parts = list(names), []
    known = {*absent, *signals.signals, *(_without_unit(name) for name in names)}
    for column in absent if {"M_z", "M"} & known else (*absent, "M_z"):
        guess = _likely(column, left)
        if guess is not None:
            left.remove(guess)
        unit = (
            "" if guess is None or is_unit(column, unit_of_name(guess)) else _unit_at_end(column, guess)
        )
        parts.append(f"{column}={_without_unit(guess) if guess else 'CHANNEL'}{unit}")
    return f"; say which is which, such as --map '{','.join(parts)}'" if names else ""


def _unit_at_end(column: str, name: str) -> str:
    """The unit that a name such as `steer_deg` ends in, as in a map; empty for none."""
    last = re.split(r"[_\s]", name)[-1]
    return f":{last}" if last != name and is_unit(column, last) else ""


def _likely(column: str, names: Sequence[str]) -> str | None:
    by_unit = [n for n in names if is_unit(column, unit_of_name(n))]
    parts = _USUAL_NAMES.get(column, (column.lower(),))
    by_name = [n for n in names if any(p in n.lower().replace("_", "") for p in parts)]
    close = get_close_matches(column, names, n=1, cutoff=0.6)
    return next(iter([*(n for n in by_name if n in by_unit), *by_name, *by_unit, *close]), None)


def _without_unit(name: str) -> str:
    found = _WITH_UNIT.fullmatch(name)
    return (found[1] if found and found[1] else name).strip()


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return (", ".join(excerpt(name)[1:-1] for name in names[:MOST_NAMES]) or "none") + more


def _floats(path: Path, column: str, samples: Samples) -> Array:
    values = np.asarray(samples.values)
    if values.ndim != 1 or values.dtype.kind not in "fiub":
        raise InvalidInputError(f"{path}: the channel of {column} must be one row of real numbers")
    with np.errstate(invalid="ignore"):
        return values.astype(np.float64)


def _of_one_length(
    path: Path, time: dict[str, Array], columns: Mapping[str, Samples]
) -> dict[str, Array]:
    for column, samples in columns.items():
        if samples.values.size != time["t"].size:
            raise InvalidInputError(
                f"{path}: {column} holds {samples.values.size} samples, t holds {time['t'].size};"
                " equal numbers are needed"
            )
    return {**time, **{column: samples.values for column, samples in columns.items()}}


def _on_one_clock(path: Path, columns: Mapping[str, Samples]) -> dict[str, Array]:
    clocks = {column: np.asarray(s.times, dtype=np.float64) for column, s in columns.items()}
    first = next(iter(clocks.values()))
    if all(np.array_equal(clock, first) for clock in clocks.values()):
        start = first[0] if first.size else 0.0
        return {"t": first - start, **{column: s.values for column, s in columns.items()}}
    for column, clock in clocks.items():
        if clock.size < 2 or not (np.diff(clock) > 0).all():
            raise InvalidInputError(f"{path}: the times of {column} must increase from sample to sample")
    torque = next((c for c in ("M_z", "M") if c in clocks), "psi")
    clock = clocks[torque]
    if clocks["psi"].size > _FASTER * clock.size:
        clock = np.union1d(clock, clocks["psi"])
        clock = clock[np.append(True, np.diff(clock) >= _SAME_INSTANT)]
    if clock.size > MOST_SAMPLES:
        raise InvalidInputError(f"{path}: holds {clock.size} samples, at most {MOST_SAMPLES} allowed")
    table = {"t": clock - clock[0]}
    for column, samples in columns.items():
        hold = column in ("M_z", "M")
        table[column] = _at(
            clock, clocks[column], samples.values, nearest=hold and clock is not clocks[column]
        )
    return table


_FASTER = 1.5
"""Ratio of samples from which the angle is sampled faster than the torque."""
_SAME_INSTANT = 1e-5
"""Samples of two channels so close are taken at once [s]."""
_GAP = 5.0
"""Periods of a channel beyond which it is not interpolated."""


def _at(clock: Array, times: Array, values: Array, *, nearest: bool) -> Array:
    """A channel at other times; NaN in its gaps and, for a torque, where it was not sampled."""
    after = np.clip(np.searchsorted(times, clock), 1, times.size - 1)
    if nearest and clock.size > times.size:
        closest = np.where(clock - times[after - 1] < times[after] - clock, after - 1, after)
        return np.where(np.abs(times[closest] - clock) < _SAME_INSTANT, values[closest], np.nan)
    gap = times[after] - times[after - 1] > _GAP * float(np.median(np.diff(times)))
    outside = (clock < times[0]) | (clock > times[-1])
    exact = (times[after] == clock) | (times[after - 1] == clock)
    return np.where((gap & ~exact) | outside, np.nan, np.interp(clock, times, values))
