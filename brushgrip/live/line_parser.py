"""Samples as lines of text: JSON objects, or CSV behind a header."""

import csv
import json
from collections.abc import Sequence

from identification.reading.formats.csvdialect import Numbers, delimiter_of

MAX_LINE_LENGTH = 10_000
"""Longest line that is read [letters]."""
MAX_NAMES = 200
"""Most values of a line."""


class LineParser:
    """Turns lines into values by name; a header of CSV may come again at any time."""

    def __init__(self) -> None:
        """No header has been seen."""
        self._names: list[str] = []
        self._delimiter, self._number_of = ",", Numbers(",")

    def __call__(self, line: str) -> dict[str, float] | None:
        """The values of a line by name; None for a header, a comment or an empty line.

        Raises:
            ValueError: the line is none such.
        """
        line = line.strip().lstrip("\ufeff")
        if len(line) > MAX_LINE_LENGTH:
            raise ValueError(f"a line of {len(line)} letters; allowed: up to {MAX_LINE_LENGTH}")
        if not line or line.startswith("#"):
            return None
        return _object_of(line) if line.startswith("{") else self._row(line)

    def _row(self, line: str) -> dict[str, float] | None:
        delimiter = self._delimiter if self._names else delimiter_of(line)
        fields = [field.strip() for field in next(csv.reader([line], delimiter=delimiter))]
        values = [self._number_of(field) for field in fields]
        if all(value is None for value in values):
            if len(set(fields)) != len(fields) or not 2 <= len(fields) <= MAX_NAMES:
                raise ValueError(f"no header: it names a column twice, or {len(fields)} columns")
            self._names = fields
            self._delimiter, self._number_of = delimiter_of(line), Numbers(delimiter_of(line))
            return None
        return self._named(values)

    def _named(self, values: Sequence[float | None]) -> dict[str, float]:
        if len(values) != len(self._names):
            raise ValueError(f"{len(values)} fields, the header has {len(self._names)}")
        if None in values:
            raise ValueError("a field is not a number")
        return dict(zip(self._names, values, strict=True))  # type: ignore[arg-type]


def _object_of(line: str) -> dict[str, float]:
    try:
        values = json.loads(line)
        return {
            name: float("nan") if value is None else float(value)
            for name, value in list(values.items())[:MAX_NAMES]
            if value is None or isinstance(value, int | float)
        }
    except (ValueError, RecursionError, OverflowError) as error:
        raise ValueError(f"no JSON object of numbers: {error}") from None
