"""Recordings that tests write."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np


def write_columns(path: Path, columns: Mapping[str, object]) -> Path:
    """Write a CSV file of these columns; a number stands for a column of it."""
    values = np.broadcast_arrays(*columns.values())  # type: ignore[arg-type]
    table = np.column_stack(values)
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="")
    return path
