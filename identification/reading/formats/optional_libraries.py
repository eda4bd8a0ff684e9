"""How every format is opened: its library imported when needed, its faults as one line."""

import logging
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from identification.reading.channels_by_name import Opener
from identification.reading.checked_file_reading import require_readable
from identification.reading.checked_sample_table import MAX_SAMPLES, Table
from identification.reading.common_clock_and_units import table_from_channels
from identification.reading.signal_map import NO_MAP, SignalMap
from symbolic import InvalidInputError
from symbolic.compilation.operating_system import MemoryLimit
from symbolic.tables.toml_and_json_parsing import excerpt

MOST_MEMORY = 4_000_000_000
"""That a library may take for a file, beyond what the process has, on Linux alone [bytes]."""
LIMIT = MemoryLimit(MOST_MEMORY)
_LIBRARIES = ("asammdf", "can", "cantools", "rosbags")
"""Loggers of libraries; npTDMS has a switch of its own."""


def read_by_optional_library(
    opener: Opener, path: Path, needed: Sequence[str], signals: SignalMap = NO_MAP
) -> Table:
    """Read the table of a file whose channels a library gives; see `Reader`."""
    require_readable(path)
    try:
        with LIMIT.lowered(), _silence_libraries(), opener(path, signals) as file:
            return table_from_channels(path, file, needed, signals)
    except InvalidInputError:
        raise
    except MemoryError:
        raise InvalidInputError(
            f"{path}: takes more than {MOST_MEMORY / 1e9:g} GB of memory to read;"
            " it is damaged, or cut it, or thin it"
        ) from None
    except Exception as error:
        # Every library has exceptions of its own for damaged files, and some have any.
        reason = excerpt(" ".join(str(error).split()) or type(error).__name__)
        raise InvalidInputError(
            f"{path}: is damaged, or no {path.suffix.lower()} file: {reason}"
        ) from None


@contextmanager
def _silence_libraries() -> Iterator[None]:
    """Keeps libraries from writing about damage to the terminal; what matters is in our message."""
    loggers = [logging.getLogger(name) for name in _LIBRARIES]
    usual = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, usual, strict=True):
            logger.setLevel(level)


def import_library(name: str, extra: str, path: Path) -> Any:
    """A module of an optional library; where it is not installed, the message says how to."""
    try:
        return import_module(name)
    except ImportError:
        raise InvalidInputError(
            f"{path}: needs what is not installed; pip install 'brushgrip[{extra}]'"
        ) from None


def require_allowed_size(path: Path, name: str, samples: int) -> None:
    """Refuses a channel before it is in memory."""
    if samples > MAX_SAMPLES:
        raise InvalidInputError(
            f"{path}: {name} holds {samples} samples, at most {MAX_SAMPLES} allowed; cut it, or thin it"
        )
