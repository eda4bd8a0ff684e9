"""Recordings in CSV: ``t,psi,M_z,F_N``, optional ``psi_dot`` and ``M``, and first lines.

Such lines are ``# a = 0.045 +- 0.0025``, ``# load = 1 +- 0.01`` and ``# ground = steel``.
"""

import csv
import re
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import chain, islice
from pathlib import Path

import numpy as np

from identification.reading.channels_by_name import (
    ChannelFile,
    ChannelSamples,
    absent_rack_columns,
    match_channel,
    missing_channels_error,
)
from identification.reading.checked_sample_table import (
    CAR_COLUMNS,
    MAX_SAMPLES,
    Table,
    TableFault,
    possible_columns,
)
from identification.reading.common_clock_and_units import table_from_channels
from identification.reading.formats.csvdialect import (
    NumberParser,
    TimeParser,
    delimiter_of,
    read_csv_text,
    units_in,
)
from identification.reading.map_for_recording import choose_map_for_channels
from identification.reading.rigfile import DECLARABLE
from identification.reading.signal_map import NO_MAP, SignalMap
from identification.reading.units import unit_in_brackets
from symbolic import TOLERATED, InvalidInputError
from symbolic.errors import printable
from symbolic.tables.rig_from_tables import NEUTRAL
from symbolic.tables.toml_and_json_parsing import excerpt, prefix_errors

GROUND = "ground"
"""Key of the ground in a first line."""
MAX_GUESSING_SAMPLES = 100_000
"""Samples from which units are guessed, at most."""
CLOCK = "; or in every row a clock time, 10:00:00.00 or 2026-01-31 10:00:00.00"
"""What else a time may be."""
_DECLARATION = re.compile(rf"#\s*({'|'.join((*DECLARABLE, *NEUTRAL, GROUND))})\s*=(.*)")
_TOLERANCE = re.compile(r"(.*?)(?:\+-|\+/-|±)(.*)")
_LINE_END = re.compile(r"\r\n|\n|\r")

Parser = Callable[[str], float | None]
"""A field as a number; NaN for an empty one, None for text."""
Rows = Iterator[tuple[int, list[str]]]
"""Fields with the number of their line, which begins at 1."""


def read_csv(path: Path, needed: Sequence[str], signals: SignalMap = NO_MAP) -> Table:
    """Read the table; unknown columns and other comment lines are ignored.

    Fields are separated by comma, semicolon or tab. A unit may stand in brackets behind a heading, or in
    a row below the header; without either, or a unit in the map, columns are in SI units.
    """
    lines = _lines(read_csv_text(path))
    heading, start = _HeadingDeclarations(), 0
    for start, line in enumerate(lines):
        if line.strip() and not line.lstrip().startswith("#"):
            break
        with prefix_errors(f"{path}: row {start + 1}"):
            _parse_declaration_line(start + 1, line, heading)
    else:
        raise InvalidInputError(f"{path}: has no header; expected {','.join(needed)}")
    delimiter = delimiter_of(line)
    rows = _fields(path, start, chain([line], lines), delimiter)
    number, fields = next(rows)
    names = [field.strip() for field in fields]
    signals = choose_map_for_channels(str(path), signals, names)
    header = _column_indices(
        path, number, names, needed, signals, _lazy_column_reader(path, names, rows, delimiter)
    )
    first = list(islice(rows, 1))
    units = units_in(first[0][1], header) if first else None
    rows = rows if units else chain(first, rows)
    number_of = NumberParser(delimiter)
    time_of = TimeParser(number_of)
    parsers = {column: time_of if column == "t" else number_of for column in header}
    columns, numbers, faults = _columns(path, header, len(names), rows, parsers)
    if time_of.is_clock:
        columns["t"] = (1e6 * columns["t"]).round().astype("timedelta64[us]")
    by_name = {names[at]: column for column, at in header.items()}
    file = ChannelFile(
        names=names,
        read=lambda name: ChannelSamples(
            values=columns[by_name[name]], unit=(units or {}).get(by_name[name], unit_in_brackets(name))
        ),
        declared=heading.declared,
    )
    return replace(
        table_from_channels(path, file, needed, signals),
        faults=faults,
        place=lambda of: f"row {numbers[of] if isinstance(of, int) else heading.places[of]}",
        tolerances=heading.tolerances,
        ground=heading.ground,
    )


def _lines(text: str) -> Iterator[str]:
    """The lines in turn, as a split would take all at once."""
    start = 0
    for end in _LINE_END.finditer(text):
        yield text[start : end.start()]
        start = end.end()
    yield text[start:]


def _fields(path: Path, start: int, lines: Iterable[str], delimiter: str) -> Rows:
    reader = csv.reader(lines, delimiter=delimiter)
    row = start + 1
    try:
        for fields in reader:
            yield row, fields
            row = start + reader.line_num + 1
    except csv.Error as error:
        raise InvalidInputError(f"{path}: row {row}: is not CSV: {error}") from None


@dataclass
class _HeadingDeclarations:
    """Declarations in the lines before the header, and the rows of these."""

    declared: dict[str, float] = field(default_factory=dict)
    tolerances: dict[str, float] = field(default_factory=dict)
    ground: str | None = None
    places: dict[str, int] = field(default_factory=dict)


def _parse_declaration_line(row: int, line: str, heading: _HeadingDeclarations) -> None:
    if (found := _DECLARATION.fullmatch(line.strip())) is None:
        return
    name, text = found.groups()
    if name in heading.places:
        raise InvalidInputError(
            f"{name} is given twice, first in row {heading.places[name]}; allowed: once"
        )
    heading.places[name] = row
    if name == GROUND:
        heading.ground = printable(text.strip())
        if not heading.ground:
            raise InvalidInputError(f"{GROUND} has no name; such as '# {GROUND} = steel'")
        return
    pair = _TOLERANCE.fullmatch(text) if name in TOLERATED else None
    value = _declared_number(name, pair[1] if pair else text)
    if pair:
        heading.tolerances[name] = _declared_number(name, pair[2])
    if name not in NEUTRAL:
        heading.declared[name] = value
    elif value != NEUTRAL[name] or pair is None:
        raise InvalidInputError(
            f"{name} has a tolerance alone, as in '# {name} = {NEUTRAL[name]:g} +- 0.01'; correct the"
            " recording instead"
        )


def _declared_number(name: str, text: str) -> float:
    value = NumberParser(",")(text)
    if value is None or np.isnan(value):
        raise InvalidInputError(
            f"{name} = {excerpt(text.strip())} is not a number; expected such as '# {name} = 0.045',"
            " SI units without the unit"
        )
    return value


def _column_indices(
    path: Path,
    row: int,
    names: Sequence[str],
    needed: Sequence[str],
    signals: SignalMap,
    read: Callable[[str], ChannelSamples],
) -> Mapping[str, int]:
    """The index of each column; what `read` finds goes into the map that is proposed for others."""
    found = {}
    for column in possible_columns(needed):
        wanted = signals.of(column).channel
        by_part = column in CAR_COLUMNS
        if (name := match_channel(f"{path}: row {row}", wanted, names, by_part=by_part)) is not None:
            found[column] = names.index(name)
    asked = {*needed, *signals.signals}
    missing = [c for c in possible_columns(needed) if c in asked and c not in found]
    if missing:
        others = [] if "psi" in needed else absent_rack_columns(found)
        missing += [column for column in others if column not in missing]
        raise missing_channels_error(path, missing, names, signals, read)
    return found


def _lazy_column_reader(
    path: Path, names: Sequence[str], rows: Rows, delimiter: str
) -> Callable[[str], ChannelSamples]:
    """Reader of one column by name; its first call parses all rows."""

    @cache
    def content() -> tuple[Mapping[str, np.ndarray], Sequence[str]]:
        number_of, places = NumberParser(delimiter), {name: at for at, name in enumerate(names)}
        first = list(islice(rows, MAX_GUESSING_SAMPLES))
        units = first[0][1] if first and not any(map(number_of, first[0][1])) else []
        parsers = {name: TimeParser(number_of) for name in names}
        return _columns(path, places, len(names), iter(first), parsers)[0], units

    def read(name: str) -> ChannelSamples:
        columns, units = content()
        at = names.index(name)
        return ChannelSamples(values=columns[name], unit=units[at].strip() if at < len(units) else "")

    return read


def _columns(
    path: Path, header: Mapping[str, int], width: int, rows: Rows, parsers: Mapping[str, Parser]
) -> tuple[dict[str, np.ndarray], "array[int]", list[TableFault]]:
    """Columns, the number of each sample's line, and faults; empty rows at the end are none."""
    columns = {name: array("d") for name in header}
    numbers, faults, size = array("q"), list[TableFault](), 0
    for sample, (number, fields) in enumerate(rows):
        if any(field.strip() for field in fields):
            size = sample + 1
        if size > MAX_SAMPLES:
            raise InvalidInputError(
                f"{path}: holds more than {MAX_SAMPLES} samples; cut it, or thin it out"
            )
        numbers.append(number)
        fitting = len(fields) == width
        if not fitting:
            faults.append(TableFault(sample, f"has {len(fields)} fields, the header has {width}"))
        for name, index in header.items():
            value = parsers[name](fields[index]) if fitting else np.nan
            if value is None:
                what = f"{name} = {excerpt(fields[index])} is not a number"
                faults.append(
                    TableFault(
                        sample, f"{what}; allowed: a finite number, empty or NaN{CLOCK * (name == 't')}"
                    )
                )
            columns[name].append(np.nan if value is None else value)
    present = {name: np.array(values[:size]) for name, values in columns.items()}
    return present, numbers, [fault for fault in faults if fault.sample < size]
