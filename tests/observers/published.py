"""The estimates published beside the measured recordings, and where in these they begin."""

from pathlib import Path

import numpy as np
import pytest

from identification import Recording, read_recording
from symbolic.float_array_type import Array

STEEL = [("fem1", 190), ("fem3", 142), ("fem4_ident", 174), ("fem5", 92)]
"""Recordings on steel, and the sample at which the published estimate begins."""
ASPHALT = [("piros1", 80), ("piros2_ident", 135), ("piros4", 101), ("piros7", 77)]
DECLARED = 1.674
"""Friction on steel by the source, from towing a block of another rubber on another day [1]."""
SETTLED = 1.89
"""Time from which [Györök 2022] scores its estimate [s], table 6.1."""
TIME, PSI, PSI_MAX, M_Z, DIRECTION, FIVE_ZONES, MU = 0, 1, 2, 3, 8, 9, 10
"""Columns of a published estimate."""


def published(folder: Path, name: str, shift: int) -> tuple[Recording, Array, slice]:
    """A recording, the columns published with it, and the samples that they are of."""
    file = folder / f"author_estimate_{name.removesuffix('_ident')}.csv"
    if not file.exists():
        pytest.skip(f"no {file.name} beside the recordings")
    columns = np.genfromtxt(file, delimiter=",")[1:].T
    recording = read_recording(folder / f"{name}.mat")
    same = slice(shift, shift + columns.shape[1])
    np.testing.assert_allclose(recording.psi[same], columns[PSI], atol=1e-9)
    return recording, columns, same


def rms(error: Array) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(error**2)))
