"""The settings that observers built on a model share."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from observers.protocol import Sample
from observers.tuning import Tuning
from symbolic import Model, Rig, full_slide_torque

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class ModelSettings:
    """A model, its fixed parameters, the rig and what is believed.

    Attributes:
        model: the model, with the effects that a diagnosis found if there are any.
        values: every parameter of the model but mu, by name (`k`, `effect.parameter`).
        rig: geometry.
        tuning: prior and noises.
    """

    model: Model
    values: Mapping[str, float]
    rig: Rig
    tuning: Tuning = field(default_factory=Tuning)

    def _theta(self) -> Array:
        return np.asarray(self.model.theta({**self.values, "mu": self.tuning.mu})).ravel()

    def _geometry(self) -> Array:
        return np.array([self.rig.a, self.rig.e])

    def _start(self, first: Sample) -> tuple[Array, Array, Array]:
        """Memory of the patch at rest at its first angle, mean and covariance of the state."""
        signals = np.array([first.psi, first.psi_dot, first.F_N, first.dt])
        memory = np.asarray(self.model.start(signals, self._theta(), self._geometry())).ravel()
        return memory, *self.tuning.prior(full_slide_torque(first.F_N, self.rig.a))
