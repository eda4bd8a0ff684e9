"""Friction over time, as an observer estimated it, ready to be drawn."""

from dataclasses import dataclass, field

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
        mu_std: its standard deviation [1]; NaN where the observer has none.
        informed: False while the estimate still rests on the prior.
        changes: instants at which the observer found the ground changed [s], shape (c,).
        reference: friction coefficient to compare with [1], None where unknown.
        reference_label: where the reference comes from.
    """

    name: str
    label: str
    t: Array
    mu: Array
    mu_std: Array
    informed: NDArray[np.bool_]
    changes: Array = field(default_factory=lambda: np.empty(0))
    reference: float | None = None
    reference_label: str = "declared μ"
