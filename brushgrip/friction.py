"""Friction over time, as an observer estimated it, ready to be drawn."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionTrack:
    """One run of an observer over a recording; arrays of shape (n,).

    Attributes:
        name: the recording.
        label: what estimated it, such as "EKF, declared model"; tracks of one name share a panel.
        t: time [s].
        mu: estimated friction coefficient [1].
        mu_std: its standard deviation [1].
        informed: True where the sample says something about mu.
        reference: declared or true friction coefficient [1], None where unknown.
    """

    name: str
    label: str
    t: Array
    mu: Array
    mu_std: Array
    informed: NDArray[np.bool_]
    reference: float | None = None
