"""How a CSV file is written: its letters, what separates fields, the decimal sign, a row of units."""

import codecs
import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path

from identification.reading.checked_file_reading import read_bytes
from identification.reading.units import is_unit
from symbolic.tables.toml_and_json_parsing import decode_text, prefix_errors

DELIMITERS = ("\t", ";", ",")
"""Of two that separate equally many fields the first is taken."""
_WESTERN = frozenset("°µ²³·äöüÄÖÜßéè±".encode("cp1252"))
"""Bytes beyond ASCII that units and headings have where a file is in the letters of Windows."""
_CLOCK = re.compile(r"(?:(\d{4}-\d\d-\d\d)[T ])?(\d?\d:\d\d:\d\d(?:[.,]\d+)?(?:Z|[+-]\d\d:?\d\d)?)")
_UTF16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


def read_csv_text(path: Path) -> str:
    """The text of a file in UTF-8, UTF-16 with its mark, or Windows' letters for units and umlauts."""
    content = read_bytes(path)
    with prefix_errors(path):
        if content.startswith(_UTF16):
            content = content.decode("utf-16", "replace").encode("utf-8")
        elif _is_windows_text(content):
            content = content.decode("cp1252").encode("utf-8")
        return decode_text(content)


def _is_windows_text(content: bytes) -> bool:
    beyond = set(content.translate(None, bytes(range(128))))
    if not beyond or not beyond <= _WESTERN:
        return False
    try:
        content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return True
    return False


def delimiter_of(header: str) -> str:
    """Delimiter of the fields of a header."""
    return max(DELIMITERS, key=header.count)


class NumberParser:
    """Texts as numbers; the first one with a point, or a comma unless that separates fields, decides."""

    def __init__(self, delimiter: str) -> None:
        """Numbers of a file whose fields are separated so."""
        self._sign = "." if delimiter == "," else None

    def __call__(self, text: str) -> float | None:
        """The number; NaN for an empty field, None for text. Python alone would allow 1_000."""
        if not text.strip():
            return float("nan")
        if self._sign is None:
            self._sign = next((sign for sign in text if sign in ".,"), None)
        if self._sign == ",":
            if "." in text:
                return None
            text = text.replace(",", ".", 1)
        try:
            return None if "_" in text else float(text)
        except ValueError:
            return None


class TimeParser:
    """Times as numbers or, if the first one is so, of a clock: HH:MM:SS or ISO dates, since that [s]."""

    def __init__(self, number_of: NumberParser) -> None:
        """Numbers are read so."""
        self._number_of, self._start = number_of, 0.0
        self.is_clock: bool | None = None

    def __call__(self, text: str) -> float | None:
        """The time; NaN for an empty field, None for text or for the other kind of time."""
        if self.is_clock is not False and (found := _CLOCK.fullmatch(text.strip())):
            return self._since_start(*found.groups())
        value = self._number_of(text)
        if value is not None and value == value:
            self.is_clock = bool(self.is_clock)
        return None if self.is_clock and value == value else value

    def _since_start(self, date: str | None, clock: str) -> float | None:
        try:
            told = datetime.fromisoformat(f"{date or '1970-01-01'}T{'0' * (clock[1] == ':')}{clock}")
        except ValueError:
            return None
        seconds = (told if told.tzinfo else told.replace(tzinfo=UTC)).timestamp()
        if not self.is_clock:
            self.is_clock, self._start = True, seconds
        return seconds - self._start


def units_in(row: Sequence[str], places: Mapping[str, int]) -> dict[str, str] | None:
    """Units of the columns where a row holds units and no number; None where it does not."""
    if max(places.values()) >= len(row):
        return None
    texts = {column: row[index].strip() for column, index in places.items()}
    units = {column: text for column, text in texts.items() if is_unit(column, text)}
    rest = {text.strip("[]()") for column, text in texts.items() if column not in units}
    return units if units and rest <= {"", "-"} else None
