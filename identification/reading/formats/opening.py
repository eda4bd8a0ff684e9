"""How every format is opened: its library imported when needed, its faults as one line."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Any

from identification.reading.channels import Opener
from identification.reading.clock import tabulate
from identification.reading.files import require_readable
from identification.reading.formats.memory import MOST_MEMORY, bounded_memory
from identification.reading.signal_map import NO_MAP, SignalMap
from identification.reading.table import MOST_SAMPLES, Table
from symbolic import InvalidInputError
from symbolic.parsing import excerpt

EXTRAS: Mapping[str, str] = MappingProxyType(
    {
        ".tdms": "tdms",
        ".mf4": "mdf",
        ".mdf": "mdf",
        ".parquet": "parquet",
        ".h5": "hdf5",
        ".hdf5": "hdf5",
        ".blf": "can",
        ".asc": "can",
        ".log": "can",
        ".bag": "ros",
        ".db3": "ros",
        ".mcap": "ros",
    }
)
"""Extra of the package that reads files of a suffix."""


@dataclass(frozen=True)
class FormatReader:
    """A reader of one format, out of a function that opens its files."""

    opener: Opener

    def __call__(self, path: Path, needed: Sequence[str], signals: SignalMap = NO_MAP, /) -> Table:
        """Read the table; see `Reader`."""
        require_readable(path)
        try:
            with bounded_memory(), self.opener(path, signals) as file:
                return tabulate(path, file, needed, signals)
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


def library(name: str, extra: str, path: Path) -> Any:
    """A module of an optional library.

    Raises:
        InvalidInputError: it is not installed; the message says how to.
    """
    try:
        return import_module(name)
    except ImportError:
        raise InvalidInputError(
            f"{path}: needs what is not installed; pip install 'brushgrip[{extra}]'"
        ) from None


def require_size(path: Path, name: str, samples: int) -> None:
    """Refuses a channel before it is in memory.

    Raises:
        InvalidInputError: it holds more samples than a recording may.
    """
    if samples > MOST_SAMPLES:
        raise InvalidInputError(
            f"{path}: {name} holds {samples} samples, at most {MOST_SAMPLES} allowed; cut it, or thin it"
        )


@contextmanager
def closing(file: Any) -> Iterator[Any]:
    """Closes a file of any library, whatever happens."""
    try:
        yield file
    finally:
        file.close()
