"""Parquet, as pandas, polars and Spark write it, by pyarrow."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from identification.reading.channels import ChannelFile, Samples
from identification.reading.formats.opening import closing, library, require_size
from identification.reading.signal_map import SignalMap
from symbolic import InvalidInputError
from symbolic.tables.parsing import excerpt

_KINDS = ("bool", "int", "uint", "half", "float", "double", "decimal", "date", "time")
"""Begin the names of types of a fixed size; texts and lists may unpack to any."""


@contextmanager
def open_parquet(path: Path, _: SignalMap) -> Iterator[ChannelFile]:
    """Columns by their names; the key `unit` of a field is its unit."""
    parquet = library("pyarrow.parquet", "parquet", path)
    with closing(parquet.ParquetFile(path)) as file:
        schema = file.schema_arrow

        def read(name: str) -> Samples:
            require_size(path, name, file.metadata.num_rows)
            if not str(schema.field(name).type).startswith(_KINDS):
                raise InvalidInputError(f"{path}: column {excerpt(name)} must hold numbers")
            values = _numbers(file.read(columns=[name]).column(name))
            unit = (schema.field(name).metadata or {}).get(b"unit", b"")
            return Samples(values=values, unit=unit.decode("utf-8", "replace"))

        yield ChannelFile(names=list(schema.names), read=read)


def _numbers(column: Any) -> Any:
    """The column as an array, what is missing as NaN; dates as seconds since the first."""
    values = np.asarray(column.to_numpy())
    if values.dtype.kind == "M":
        return (values - values[:1]) / np.timedelta64(1, "s")
    return values
