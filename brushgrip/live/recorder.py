"""Samples and estimates of the observer as a Parquet file, which appears whole at its end."""

from collections.abc import Sequence
from contextlib import ExitStack
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from brushgrip.outputs.atomic import staged_file
from identification.reading.formats.optional_libraries import import_library
from observers import ESTIMATE
from symbolic.array_alias import Array

GROUP = 5_000
"""Samples of a row group, which is written at once."""


class Recorder:
    """An open recording: its file, which is none of those that are there already, and samples so far."""

    def __init__(self, wanted: Path, columns: Sequence[str]) -> None:
        """Begin a file, `_2` and so on where its name is taken; its columns go before the estimates."""
        names = (wanted if n == 1 else wanted.with_stem(f"{wanted.stem}_{n}") for n in count(1))
        self.path, self.samples = next(path for path in names if not path.exists()), 0
        self._names, self._waiting = (*columns, *ESTIMATE), list[Array]()
        self._arrow, parquet = (
            import_library(name, "live", wanted) for name in ("pyarrow", "pyarrow.parquet")
        )
        with ExitStack() as stack:
            stage = stack.enter_context(staged_file(self.path))
            schema = self._arrow.schema([(name, self._arrow.float64()) for name in self._names])
            self._writer: Any = stack.enter_context(parquet.ParquetWriter(stage, schema))
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
        if not self._waiting:
            return
        rows, self._waiting = np.concatenate(self._waiting), []
        columns = [self._arrow.array(column) for column in rows.T]
        self._writer.write_table(self._arrow.table(columns, names=list(self._names)))
