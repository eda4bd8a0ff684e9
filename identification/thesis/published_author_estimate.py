"""Friction as estimated for [Györök 2022], published beside a recording: author_estimate_*.csv."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.reading.checked_file_reading import read_text
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

COLUMNS = (
    "t", "psi", "psi_max", "M_z", "e", "F_N", "a", "k", "positive", "five_zones", "mu", "declared",
)  # fmt: skip
"""Columns of these files, SI units; their own header is NaN throughout."""
_TOLERANCE = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class AuthorEstimate:
    """A published estimate, which begins where the wheel begins to turn; arrays of shape (n,)."""

    t: Array  # Time [s], 0 at the first sample.
    psi: Array  # Yaw angle [rad].
    psi_max: Array  # Angle of the last reversal, 0 before the first [rad].
    direction: NDArray[np.int64]  # Of turning, 1 or -1.
    zones: NDArray[np.int64]  # Number of zones, 3 or 5.
    mu: Array  # The estimate [1].
    declared: float  # Friction coefficient from towing a block [1].


def author_estimate_file(folder: Path, recording: str) -> Path:
    """The path of a recording's file: its name without the suffix `_ident`."""
    return folder / f"author_estimate_{recording.removesuffix('_ident')}.csv"


def read_author_estimate(path: Path) -> AuthorEstimate:
    """Read a published estimate."""
    lines = read_text(path).splitlines()[1:]
    try:
        table = np.array([line.split(",") for line in lines if line.strip()], dtype=float)
    except ValueError:
        table = np.empty((0, 0))
    if table.ndim != 2 or table.shape[0] < 2 or table.shape[1] != len(COLUMNS):
        raise InvalidInputError(
            f"{path}: is no estimate of the author; expected a header and rows of {len(COLUMNS)}"
            f" numbers {','.join(COLUMNS)}"
        )
    if not np.isfinite(table).all():
        row = int(np.argmin(np.isfinite(table).all(axis=1)))
        raise InvalidInputError(f"{path}: row {row + 2}: every number must be finite")
    column = dict(zip(COLUMNS, table.T, strict=True))
    return AuthorEstimate(
        t=column["t"],
        psi=column["psi"],
        psi_max=column["psi_max"],
        direction=np.where(column["positive"] > 0, 1, -1),
        zones=np.where(column["five_zones"] > 0, 5, 3),
        mu=column["mu"],
        declared=float(column["declared"][0]),
    )


def begin_of_part(psi: Array, part: Array) -> int:
    """Index at which the angles `part` begin in those of the whole recording, `psi`, both in [rad]."""
    starts = range(psi.size - part.size + 1)
    off = [float(np.abs(psi[at : at + part.size] - part).max()) for at in starts]
    if not off or not min(off) <= _TOLERANCE:
        raise InvalidInputError("the author's angles are not those of the recording")
    return int(np.argmin(off))
