"""Content of a file -> text or table; every fault is one line."""

import json
import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from symbolic.errors import InvalidInputError

MAX_TABLES_SIZE = 16_384
"""Of a file with values of a rig [bytes]."""
MAX_MODEL_SIZE = 10_000_000
"""Of a model file [bytes]."""
_PERCENT = re.compile(r"(\d+(?:\.\d*)?) ?%")
_MAX_EXCERPT = 40
_DEEP = re.compile(r"""(?<![\w"'-])(?:[\w"'-]+[ \t]*\.[ \t]*){20}|[{[]{20}""")
"""Keys so deep take the parser seconds and all its stack."""


@contextmanager
def prefix_errors(name: object) -> Iterator[None]:
    """Put a name, such as a path, before the message of an `InvalidInputError` raised inside."""
    try:
        yield
    except InvalidInputError as error:
        raise InvalidInputError(f"{name}: {error}") from None


def excerpt(text: str) -> str:
    """The text, quoted on one line and cut where it is long, to show in a message."""
    return repr(text if len(text) <= _MAX_EXCERPT else text[:_MAX_EXCERPT] + "…")


def quoted_value(value: object) -> str:
    """A value of a table, quoted on one line and cut, to show in a message."""
    try:
        return excerpt(str(value))
    except ValueError:
        return "a number of more digits than Python writes out"


def decode_text(content: bytes) -> str:
    """UTF-8 text without its byte order mark; refused where it is empty or not UTF-8, with the row."""
    if not content.strip():
        raise InvalidInputError("is empty")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        row = content.count(b"\n", 0, error.start) + 1
        raise InvalidInputError(
            f"row {row}: is not text, byte 0x{content[error.start]:02x} is not UTF-8; "
            "save the file as UTF-8"
        ) from None
    if "\0" in text:
        row = text.count("\n", 0, text.index("\0")) + 1
        raise InvalidInputError(f"row {row}: is not text, it holds a zero byte")
    return text


def parse_toml(content: bytes) -> dict[str, Any]:
    """The table of TOML; refused where not UTF-8, not TOML, larger or deeper than a rig needs."""
    if len(content) > MAX_TABLES_SIZE:
        raise InvalidInputError(f"holds {len(content)} bytes; allowed: up to {MAX_TABLES_SIZE}")
    text = decode_text(content)
    if deep := _DEEP.search(text):
        row = text.count("\n", 0, deep.start()) + 1
        raise InvalidInputError(f"row {row}: is not valid TOML for a rig: 20 tables within each other")
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise InvalidInputError(f"is not valid TOML: {error}") from None


def parse_json(content: bytes) -> Any:
    """The value of JSON; refused where not UTF-8, not JSON, or with one key twice in an object."""
    try:
        return json.loads(content.decode("utf-8-sig"), object_pairs_hook=_object_without_duplicates)
    except InvalidInputError:
        raise
    except (ValueError, RecursionError) as error:
        raise InvalidInputError(f"not a JSON file: {error}") from None


def _object_without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """The members of an object; Python alone would take the last of two."""
    members = dict(pairs)
    if len(members) < len(pairs):
        ((twice, _),) = Counter(name for name, _ in pairs).most_common(1)
        raise InvalidInputError(f"{excerpt(twice)} is given twice in one object; allowed: once")
    return members


def require_number(label: str, value: object) -> None:
    """Refuse an entry that is no number, as a truth value; the message begins with the label."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InvalidInputError(f"{label} must be a number, got {quoted_value(value)}")


def absolute_tolerance(tolerance: object, value: object) -> object:
    """A tolerance such as "20%" in the unit of the value that it is a share of; else as it is.

    One below 1 that is hardly any of the value, as a share without its sign is, is refused.
    """
    share = _PERCENT.fullmatch(tolerance) if isinstance(tolerance, str) else None
    if not isinstance(value, int | float) or not 0 < abs(value) < 1e300:
        return tolerance
    if share:
        return abs(value) * float(share[1]) / 100
    if isinstance(tolerance, int | float) and 0 < tolerance < min(1, 1e-5 * abs(value)):
        raise InvalidInputError(
            f"tolerance = {tolerance:g} is in the unit of the value {value:g}, of which it is hardly"
            f' anything; write "{100 * tolerance:g}%" for a share, 0 where the value is exact'
        )
    return tolerance


def floats(place: str, table: Mapping[str, Any], label: str = "{place}.{name}") -> dict[str, float]:
    """The numbers of a table as floats; messages name the table by its place, an entry by the label.

    An entry that is no number, or too large to compute with, is refused.
    """
    for name, value in table.items():
        require_number(label.format(place=place, name=name), value)
    try:
        return {name: float(value) for name, value in table.items()}
    except OverflowError:
        raise InvalidInputError(f"{place} holds a number too large to compute with") from None
