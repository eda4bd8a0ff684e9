"""Content of a file -> text or table; every fault is one line."""

import json
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from symbolic.errors import InvalidInputError

_LONGEST_EXCERPT = 40


@contextmanager
def naming(name: object) -> Iterator[None]:
    """Put a name, such as a path, before the message of an `InvalidInputError` raised inside."""
    try:
        yield
    except InvalidInputError as error:
        raise InvalidInputError(f"{name}: {error}") from None


def excerpt(text: str) -> str:
    """The text, quoted on one line and cut where it is long, to show in a message."""
    return repr(text if len(text) <= _LONGEST_EXCERPT else text[:_LONGEST_EXCERPT] + "…")


def text_of(content: bytes) -> str:
    """UTF-8 text, without its byte order mark.

    Raises:
        InvalidInputError: empty, or not UTF-8 text; the message names the row.
    """
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


def toml_of(content: bytes) -> dict[str, Any]:
    """The table of a TOML file.

    Raises:
        InvalidInputError: not UTF-8 text, or not TOML.
    """
    try:
        return tomllib.loads(text_of(content))
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise InvalidInputError(f"is not valid TOML: {' '.join(str(error).split())}") from None


def json_of(content: bytes) -> Any:
    """The value of a JSON file.

    Raises:
        InvalidInputError: not UTF-8 text, or not JSON.
    """
    try:
        return json.loads(content.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise InvalidInputError(f"not a JSON file: {error}") from None


def floats(place: str, table: Mapping[str, int | float]) -> dict[str, float]:
    """The numbers of a table as floats.

    Raises:
        InvalidInputError: one is too large.
    """
    try:
        return {name: float(value) for name, value in table.items()}
    except OverflowError:
        raise InvalidInputError(f"{place} holds a number too large to compute with") from None
