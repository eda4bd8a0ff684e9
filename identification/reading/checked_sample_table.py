"""A recording as it stands in a file, and the checks of its samples."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from identification.reading.signal_map import SignalSource, corrected_map_text
from identification.reading.units import UNITS, car_unit_by_size
from identification.reading.units_by_magnitude import infer_units_and_sign, time_unit_by_period
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

MIN_SAMPLES = 10
MAX_SAMPLES = 10_000_000
"""Of a recording, nearly three hours at 1 kHz; what holds more has to be cut or thinned before."""
MIN_TIME_STEP = 1e-6
"""Time advances by at least so much from sample to sample [s]."""
REQUIRED_COLUMNS = ("t", "psi", "M_z", "F_N")
COLUMNS = (*REQUIRED_COLUMNS, "psi_dot", "M")
CAR_COLUMNS = ("rack", "handwheel", "F_rack", "T_bar", "T_motor", "brake", "speed")
"""Columns of a car beside the time, see `identification.reading.car_as_mean_wheel`."""
DECAY_COLUMNS = ("t", "psi")
"""Columns that a recording of a free vibration needs."""
MAX_VALUES = {
    "t": (1e9, "s"),
    "psi": (100.0, "rad"),
    "psi_dot": (1e4, "rad/s"),
    "F_N": (1e6, "N"),
    "M_z": (1e6, "N m"),
    "M": (1e6, "N m"),
    "rack": (1.0, "m"),
    "handwheel": (100.0, "rad"),
    "F_rack": (1e6, "N"),
    "T_bar": (1e4, "N m"),
    "T_motor": (1e4, "N m"),
    "brake": (1e3, "1"),
    "speed": (200.0, "m/s"),
}
"""A number beyond these is a fault of the file."""


HALF_A_DAY = 43200.0
MIDNIGHT = ", as a clock does at midnight (write dates before the times, or cut the file there)"
"""What a fall of the time by more than half a day [s] may be."""


class TableFault(NamedTuple):
    """One faulty sample, and what is wrong with it."""

    sample: int
    what: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Table:
    """The samples of a file, SI units, NaN where one is missing or cannot be read.

    Attributes:
        path: the file.
        columns: float arrays (n,) by name: t, psi, M_z, F_N, psi_dot, M, or those of a car.
        declared: values that the file itself gives for a, e, k, mu, J_A, b_t.
        faults: samples that could not be read.
        place: names the place of a sample (index from 0) or of a declared value, for messages: the
            line in a CSV file, the sample in a MAT file, both counted from 1.
        tolerances: how far off declared values may be, by name, see `symbolic.Tolerances`.
        ground: name of what the wheel stands on; None where the file does not say.
        sources: channel of each column, for messages.
        names: of all channels of the file, for messages.
        remarks: what the user has to know about the values, a line each.
    """

    path: Path
    columns: Mapping[str, Array]
    declared: Mapping[str, float] = field(default_factory=dict)
    faults: Sequence[TableFault] = ()
    place: Callable[[int | str], str]
    tolerances: Mapping[str, float] = field(default_factory=dict)
    ground: str | None = None
    sources: Mapping[str, SignalSource] = field(default_factory=dict)
    names: Sequence[str] = ()
    remarks: Sequence[str] = ()

    def source(self, column: str) -> SignalSource:
        """Where a column comes from; its own name where the table does not say."""
        return self.sources.get(column, SignalSource(channel=column))


def required_columns(*, torque_required: bool) -> tuple[str, ...]:
    """Names of the columns that a recording of a turning wheel needs."""
    return tuple(name for name in REQUIRED_COLUMNS if torque_required or name != "M_z")


def possible_columns(needed: Sequence[str]) -> tuple[str, ...]:
    """The columns that a recording may have: those of a car where no angle of a wheel is needed."""
    return COLUMNS if "psi" in needed else ("t", *CAR_COLUMNS)


def require_valid_samples(table: Table, needed: Sequence[str]) -> None:
    """Refuse a table for a faulty sample, or for a column needed that is missing throughout."""
    _require_one_length(table)
    columns = {name: table.columns[name] for name in MAX_VALUES if name in table.columns}
    checks = [
        _unreadable_check(table),
        *(_infinite_check(name, values) for name, values in columns.items()),
        *(_too_large_check(table, name, values) for name, values in columns.items()),
        *(_nonpositive_load_check(table, values) for name, values in columns.items() if name == "F_N"),
        *_time_checks(columns["t"]),
    ]
    faulty = np.logical_or.reduce([wrong for wrong, _ in checks])
    if faulty.any():
        first, others = int(np.argmax(faulty)), int(faulty.sum()) - 1
        what = next(describe(first) for wrong, describe in checks if wrong[first])
        more = f" (and {others} more row{'s' * (others > 1)})" if others else ""
        raise InvalidInputError(f"{table.path}: {table.place(first)}: {what}{more}")
    size = table.columns["t"].size
    if size < MIN_SAMPLES:
        raise InvalidInputError(
            f"{table.path}: holds {size} sample{'s' * (size != 1)}, at least {MIN_SAMPLES} needed"
        )
    if size > MAX_SAMPLES:
        raise InvalidInputError(
            f"{table.path}: holds {size} samples, at most {MAX_SAMPLES} allowed; cut it, or thin it"
        )
    for name in needed:
        known = int(np.isfinite(table.columns[name]).sum())
        if known == 0:
            raise InvalidInputError(f"{table.path}: every {name} is missing, a number is needed")
        if name == "M_z" and known < MIN_SAMPLES:
            raise InvalidInputError(
                f"{table.path}: M_z is known in {known} of {size} samples, at least {MIN_SAMPLES} needed"
            )


def _require_one_length(table: Table) -> None:
    size = table.columns["t"].size
    for column, values in table.columns.items():
        if values.size != size:
            name, of_time = (table.source(one).channel for one in (column, "t"))
            raise InvalidInputError(
                f"{table.path}: {name} holds {values.size} samples, {of_time} holds {size};"
                " equal numbers are needed"
            )


_Check = tuple[NDArray[np.bool_], Callable[[int], str]]
"""Where samples are wrong, and what is wrong with one of them."""


def _unreadable_check(table: Table) -> _Check:
    what = {fault.sample: fault.what for fault in reversed(table.faults)}
    return np.isin(np.arange(table.columns["t"].size), list(what)), what.__getitem__


def _infinite_check(name: str, values: Array) -> _Check:
    what = f"{name} is infinite; allowed: a finite number, empty or NaN"
    return np.isinf(values), lambda _: what


def _too_large_check(table: Table, name: str, values: Array) -> _Check:
    most, unit = MAX_VALUES[name]
    allowed = f"allowed: up to {most:g} {unit} in size"
    wrong = np.isfinite(values) & (np.abs(values) > most)
    if car_unit_by_size(name, values):  # Of a car: refused later, with all else that its units are not.
        wrong = np.zeros_like(wrong)
    return wrong, lambda at: f"{name} = {values[at]:g} {unit}; {allowed}{_smaller_unit_map(table, name)}"


def _nonpositive_load_check(table: Table, F_N: Array) -> _Check:
    source = table.source("F_N")
    turned = corrected_map_text(table.sources, {"F_N": replace(source, factor=-source.factor)})
    remedy = "" if (F_N > 0).any() else f"; if it counts the other way: {turned}"
    return F_N <= 0, lambda at: f"F_N = {F_N[at]:g} N; a vertical load is greater than 0{remedy}"


def _time_checks(t: Array) -> Iterator[_Check]:
    yield np.isnan(t), lambda _: "t is missing; every sample needs its time [s]"
    known = np.flatnonzero(np.isfinite(t))
    before = np.full(t.size, np.nan)
    before[known[1:]] = t[known[:-1]]

    def late(at: int) -> str:
        manner = "stands nearly still" if t[at] > before[at] else "repeats"
        if t[at] < before[at]:
            manner = "runs backwards" + MIDNIGHT * bool(before[at] - t[at] > HALF_A_DAY)
        return (
            f"time {manner}: t = {t[at]:.10g} s after {before[at]:.10g} s; t must increase from"
            f" sample to sample, by at least {MIN_TIME_STEP:g} s"
        )

    with np.errstate(over="ignore"):
        advance = t - before
    yield advance < MIN_TIME_STEP, late


@np.errstate(over="ignore", invalid="ignore")
def _smaller_unit_map(table: Table, column: str) -> str:
    """The map to write where a column is too large because it is in a smaller unit."""
    source = table.source(column)
    smaller = sorted((factor, unit) for unit, factor in UNITS[column].items() if factor < 1)
    if not smaller:
        return ""
    unit = smaller[-1][1]
    if column == "t":
        unit = time_unit_by_period(float(np.nanmedian(np.abs(np.diff(table.columns["t"])))))
    stated = source.unit is not None
    values = {**table.columns, column: table.columns[column] * (1 if stated else UNITS[column][unit])}
    sources = {**table.sources, column: source if stated else replace(source, unit=unit)}
    certain = {"M_z", "M", *(c for c, one in sources.items() if one.unit is not None)}
    inferred, geared = infer_units_and_sign(sources, values, set(), certain)
    # As degrees it is still beyond a right angle, so that it is the steering wheel's.
    inferred |= {c: inferred[c].geared_by_steering_ratio(c) for c in geared}
    changed = {c: one for c, one in inferred.items() if one != table.sources.get(c)}
    if stated and column not in geared:
        return ""
    of_hand = "if it is the steering wheel's in degrees" if geared else "if it is in another unit"
    return (
        f"; {of_hand}: {corrected_map_text(table.sources, changed)}{source.ratio_hint if geared else ''}"
    )
