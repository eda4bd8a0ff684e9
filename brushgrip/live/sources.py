"""Where samples come from while they are measured: a file in real time, UDP, standard input."""

import csv
import json
import os
import select
import socket
import time
from collections.abc import Sequence
from contextlib import ExitStack
from itertools import islice
from typing import Protocol

import numpy as np

from brushgrip.live.mapped_columns import MappedColumns, Row
from brushgrip.live.timestamp_filter import clock_time
from identification.reading.checked_sample_table import Table
from identification.reading.formats.csvdialect import NumberParser, delimiter_of
from identification.reading.units import UNITS, is_unit, unit_in_brackets
from symbolic import InvalidInputError

MAX_LINE_LENGTH = 10_000
"""Longest line that is read [letters]."""
MAX_NAMES = 200
"""Most values of a line."""


class LineParser:
    """Turns lines into values by name; a header of CSV may come again, a row of units below it."""

    def __init__(self) -> None:
        """No header has been seen."""
        self._names: list[str] = []
        self._after_header = False
        self._delimiter, self._number_of = ",", NumberParser(",")

    def __call__(self, line: str) -> dict[str, float] | None:
        """The values of a line by name; None for header, comment or nothing; else a ValueError."""
        line = line.strip().lstrip("\ufeff")
        if len(line) > MAX_LINE_LENGTH:
            raise ValueError(f"a line of {len(line)} letters; allowed: up to {MAX_LINE_LENGTH}")
        if not line or line.startswith("#"):
            return None
        return _parse_json_line(line) if line.startswith("{") else self._row(line)

    def _row(self, line: str) -> dict[str, float] | None:
        delimiter = self._delimiter if self._names else delimiter_of(line)
        fields = [field.strip() for field in next(csv.reader([line], delimiter=delimiter))]
        values = [self._number_of(field) for field in fields]
        after_header, self._after_header = self._after_header, False
        if after_header and len(fields) == len(self._names) and _are_units(fields):
            self._names = [
                name if unit_in_brackets(name) else f"{name} [{unit.strip('[]()')}]"
                for name, unit in zip(self._names, fields, strict=True)
            ]
            return None
        if all(value is None for value in values):
            if len(set(fields)) != len(fields) or not 2 <= len(fields) <= MAX_NAMES:
                raise ValueError(f"no header: it names a column twice, or {len(fields)} columns")
            self._names, self._after_header = fields, True
            self._delimiter, self._number_of = delimiter_of(line), NumberParser(delimiter_of(line))
            return None
        if not self._names:
            raise ValueError("numbers before a header: the first line of CSV names the columns")
        if len(values) != len(self._names):
            raise ValueError(f"{len(values)} fields, the header has {len(self._names)}")
        if None in values:
            raise ValueError("a field is not a number")
        return dict(zip(self._names, values, strict=True))  # type: ignore[arg-type]


def _are_units(fields: Sequence[str]) -> bool:
    """Whether a row below a header holds units of columns, and nothing else."""
    units = [field for field in fields if any(is_unit(column, field) for column in UNITS)]
    return bool(units) and {f.strip("[]()") for f in fields if f not in units} <= {"", "-"}


def _parse_json_line(line: str) -> dict[str, float]:
    try:
        values = json.loads(line)
        return {
            name: float("nan") if value is None else float(value)
            for name, value in list(values.items())[:MAX_NAMES]
            if value is None or isinstance(value, int | float)
        }
    except (ValueError, RecursionError, OverflowError) as error:
        raise ValueError(f"no JSON object of numbers: {error}") from None


WAIT = 0.02
"""Time after which a source without samples returns [s]."""
MAX_MESSAGES_AT_ONCE = 200
"""Most messages that are read before they are handed on."""
BUFFER = 8_000_000
"""Buffer of the system for datagrams [bytes]."""


class Source(Protocol):
    """An open source."""

    waits: bool  # Whether it may be read later without loss, as a file.
    refused: int  # Messages that could not be used.
    fault: str  # Why the last one of them could not.

    def read(self) -> list[Row]:
        """Samples that have come, after at most `WAIT` none.

        Raises:
            EOFError: there will be no more.
            OSError: the source is lost.
        """

    def close(self) -> None:
        """Let it go."""


class ReplaySource:
    """A recording in real time."""

    waits, refused, fault = True, 0, ""

    def __init__(self, table: Table, speed: float) -> None:
        """Begin at the first sample; `speed` is that of the clock [1]."""
        self._rows = zip(*(values.tolist() for values in table.columns.values()), strict=True)
        self._names, self._t = list(table.columns), table.columns["t"]
        self._speed, self._begin, self._at = speed, time.monotonic(), 0

    def read(self) -> list[Row]:
        """The samples whose time has come."""
        if self._at == self._t.size:
            raise EOFError
        now = self._t[0] + (time.monotonic() - self._begin) * self._speed
        due = min(int(np.searchsorted(self._t, now, side="right")), self._at + MAX_MESSAGES_AT_ONCE)
        if due == self._at:
            time.sleep(min(WAIT, max((self._t[self._at] - now) / self._speed, 1e-4)))
            return []
        rows = [dict(zip(self._names, row, strict=True)) for row in islice(self._rows, due - self._at)]
        self._at = due
        return rows  # type: ignore[return-value]

    def close(self) -> None:
        """Nothing is open."""


class _TextSource:
    """Lines of text as samples; what cannot be read is counted.

    Lines have times of their own or all that of their arrival: it is none by the clock of the others.
    """

    def __init__(self, columns: MappedColumns) -> None:
        self.refused, self.fault, self._is_timed = 0, "", False
        self._columns, self._values_of = columns, LineParser()

    def _rows(self, lines: list[bytes]) -> list[Row]:
        rows: list[Row] = []
        for line in lines:
            try:
                if (values := self._values_of(line.decode())) is None:
                    continue
                row = self._columns(values)
                self._is_timed |= "t" in row
                if self._is_timed and "t" not in row:
                    raise InvalidInputError("no t, which lines before had")
                rows.append({"t": clock_time(), **row})
            except ValueError as error:  # Also of letters, and of columns that are missing.
                self.refused, self.fault = self.refused + 1, str(error)
        return rows


class UdpSource(_TextSource):
    """Datagrams with a line or more of text; a sample without `t` has the time of its arrival."""

    waits = False

    def __init__(self, address: tuple[str, int], columns: MappedColumns) -> None:
        """Listen at an address."""
        super().__init__(columns)
        with ExitStack() as stack:
            self._socket = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER)
            self._socket.bind(address)
            stack.pop_all()

    def read(self) -> list[Row]:
        """The samples of datagrams that have come."""
        if not select.select([self._socket], [], [], WAIT)[0]:
            return []
        lines: list[bytes] = []
        try:
            while len(lines) < MAX_MESSAGES_AT_ONCE:
                lines += self._socket.recv(65536, socket.MSG_DONTWAIT).splitlines()
        except BlockingIOError:
            pass
        return self._rows(lines)

    def close(self) -> None:
        """Let the port go."""
        self._socket.close()


class LineSource(_TextSource):
    """Lines of standard input, or of another file that is written while it is read."""

    waits = True

    def __init__(self, file: int, columns: MappedColumns) -> None:
        """Read from a descriptor."""
        super().__init__(columns)
        self._file, self._rest = file, b""

    def read(self) -> list[Row]:
        """The samples of lines that have come whole."""
        if not select.select([self._file], [], [], WAIT)[0]:
            return []
        if not (content := os.read(self._file, 65536)):
            if not self._rest:
                raise EOFError
            content = b"\n"
        *lines, self._rest = (self._rest + content).split(b"\n")
        if len(self._rest) > 10 * MAX_LINE_LENGTH:
            self.refused, self.fault, self._rest = self.refused + 1, "a line without an end", b""
        return self._rows(lines)

    def close(self) -> None:
        """Leave it to its owner."""
