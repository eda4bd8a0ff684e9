"""Parquet, as pandas, polars and Spark write it, by pyarrow."""

from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from identification.reading.channels_by_name import ChannelFile, ChannelSamples
from identification.reading.formats.optional_libraries import import_library, require_allowed_size
from identification.reading.signal_map import SignalMap
from identification.reading.units import unit_attribute
from symbolic import InvalidInputError
from symbolic.tables.toml_and_json_parsing import excerpt

_KINDS = ("bool", "int", "uint", "half", "float", "double", "decimal", "date", "time", "duration")
"""Begin the names of types of a fixed size; texts and lists may unpack to any."""


@contextmanager
def open_parquet(path: Path, _: SignalMap) -> Iterator[ChannelFile]:
    """Columns by their names; the key `unit` or `units` of a field is its unit."""
    parquet = import_library("pyarrow.parquet", "parquet", path)
    with closing(parquet.ParquetFile(path)) as file:
        schema = file.schema_arrow

        def read(name: str) -> ChannelSamples:
            require_allowed_size(path, name, file.metadata.num_rows)
            field = schema.field(name)
            if not str(field.type).startswith(_KINDS):
                raise InvalidInputError(f"{path}: column {excerpt(name)} must hold numbers")
            values = _as_numpy_type(file.read(columns=[name]).column(name), field.type)
            told = {_text(key): _text(value) for key, value in (field.metadata or {}).items()}
            return ChannelSamples(values=values.to_numpy(), unit=unit_attribute(told))

        yield ChannelFile(names=list(schema.names), read=read)


def _as_numpy_type(column: Any, kind: Any) -> Any:
    """A column of a type that numpy has; times of the day as durations since midnight."""
    if str(kind).startswith("decimal"):
        return column.cast("float64")
    if str(kind).startswith(("time32", "time64")):
        return column.cast(f"int{kind.bit_width}").cast("int64").cast(f"duration[{kind.unit}]")
    return column


def _text(content: bytes) -> str:
    return content.decode("utf-8", "replace")
