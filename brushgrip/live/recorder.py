"""Samples and estimates of the observer as a Parquet or MDF4 file, which appears whole at its end."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager
from importlib import import_module
from itertools import count
from pathlib import Path

import numpy as np

from brushgrip.outputs.atomic import staged_file
from identification.reading.formats.optional_libraries import import_library
from identification.reading.units import UNITS
from observers import ESTIMATE
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

GROUP = 5_000
"""Samples that are written at once."""
Write = Callable[[Array], None]


@contextmanager
def _parquet_writer(path: Path, names: Sequence[str]) -> Iterator[Write]:
    arrow, parquet = import_module("pyarrow"), import_module("pyarrow.parquet")
    schema = arrow.schema([(name, arrow.float64()) for name in names])
    with parquet.ParquetWriter(path, schema) as writer:
        yield lambda rows: writer.write_table(arrow.table(list(rows.T), schema=schema))


@contextmanager
def _mdf_writer(path: Path, names: Sequence[str]) -> Iterator[Write]:
    """A group with its clock; `t` is a channel too, as readers count the clock from the first sample."""
    asammdf = import_module("asammdf")
    units = {name: next(iter(factors)) for name, factors in UNITS.items()}
    units |= dict.fromkeys(("M_z_predicted", "M_slide"), units["M_z"])
    with closing(asammdf.MDF(version="4.10", temporary_folder=str(path.parent))) as file:

        def write(rows: Array) -> None:
            t, columns = rows[:, names.index("t")], np.ascontiguousarray(rows.T)
            if file.groups:
                file.extend(0, [(values, None) for values in (t, *columns)])
                return
            file.append([
                asammdf.Signal(samples=values, timestamps=t, name=name, unit=units.get(name, ""))
                for name, values in zip(names, columns, strict=True)
            ])  # fmt: skip

        yield write
        with path.open("wb+") as whole:  # By its name, asammdf would write beside a name in capitals.
            file.save(whole)


FORMATS = {".parquet": ("pyarrow", "live", _parquet_writer), ".mf4": ("asammdf", "mdf", _mdf_writer)}
"""Library, extra that installs it, and writer by the end of a file's name."""


def writer_for(path: Path) -> Callable[[Path, Sequence[str]], AbstractContextManager[Write]]:
    """What writes a file of such a name; refuses other names, and what lacks its library."""
    if path.suffix.lower() not in FORMATS:
        raise InvalidInputError(
            f"{path}: a recording is Parquet or MDF4; end its name in {' or '.join(FORMATS)}"
        )
    library, extra, writer = FORMATS[path.suffix.lower()]
    import_library(library, extra, path)
    return writer


class Recorder:
    """An open recording: its file, which is none of those that are there already, and samples so far."""

    def __init__(self, wanted: Path, columns: Sequence[str]) -> None:
        """Begin a file, `_2` and so on where its name is taken; its columns go before the estimates."""
        names = (wanted if n == 1 else wanted.with_stem(f"{wanted.stem}_{n}") for n in count(1))
        self.path, self.samples = next(path for path in names if not path.exists()), 0
        self._waiting, writer = list[Array](), writer_for(wanted)
        with ExitStack() as stack:
            stage = stack.enter_context(staged_file(self.path))
            self._write = stack.enter_context(writer(stage, (*columns, *ESTIMATE)))
            self._stack = stack.pop_all()

    def write(self, rows: Array) -> None:
        """Add samples, shape (n, columns and estimates); an OSError where the disk is full or gone."""
        self._waiting.append(rows)
        self.samples += len(rows)
        if sum(map(len, self._waiting)) >= GROUP:
            self._flush()

    def close(self) -> None:
        """End the file; an OSError as of `write`."""
        with self._stack:
            self._flush()

    def _flush(self) -> None:
        if self._waiting:
            rows, self._waiting = np.concatenate(self._waiting), []
            self._write(rows)
