"""A whole recording through a step, many samples in one call."""

from collections.abc import Iterator, Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from observers.protocol import Sample

Array = NDArray[np.float64]
STRETCH = 100
"""Samples in one call; a recording is padded to a multiple of it."""


def build_stretch(step: ca.Function, name: str, states: int) -> ca.Function:
    """`STRETCH` samples of a step whose first `states` inputs and outputs are the state."""
    return step.mapaccum(name, STRETCH, states, {})


def first_sample(samples: Array) -> Sample:
    """The first column of rows psi, psi_dot, F_N, dt, M_z."""
    psi, psi_dot, F_N, dt, M_z = samples[:, 0]
    return Sample(psi=psi, psi_dot=psi_dot, F_N=F_N, dt=dt, M_z=M_z)


def run_stretches(
    stretch: ca.Function, state: Sequence[Array], samples: Array, constant: Sequence[Array]
) -> Iterator[list[ca.DM]]:
    """The outputs of each stretch; those of the last one go on beyond the recording's end.

    Args:
        stretch: from `build_stretch`: (*state, samples, *constant) -> (*state, ...).
        state: before the first sample.
        samples: one column a sample, shape (5, n).
        constant: inputs that stay the same, vectors.
    """
    present = [ca.DM(part) for part in state]
    widths = [part.shape[1] for part in present]
    padded = np.pad(samples, ((0, 0), (0, -samples.shape[1] % STRETCH)), mode="edge")
    tiled = [ca.DM(np.tile(vector.reshape(-1, 1), STRETCH)) for vector in constant]
    for at in range(0, samples.shape[1], STRETCH):
        made = stretch.call([*present, ca.DM(padded[:, at : at + STRETCH]), *tiled])
        # The state after every sample is handed back; only the last one goes on.
        present = [part[:, -width:] for part, width in zip(made, widths, strict=False)]
        yield made
