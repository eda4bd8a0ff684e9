"""What every observer of mu and the torque zero believes before it has seen a sample.

State x = (mu, M_0): both random walks, mu of the ground and M_0 of the sensor.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbolic import InvalidInputError

Array = NDArray[np.float64]
STATES = ("mu", "M_0")
"""Order of the state: friction coefficient [1], zero of the torque channel [N m]."""
REFERENCE_STEP = 0.01
"""Time between samples for which `Tuning.noise` holds [s]."""
INFORMED = 0.5
"""Share of the prior's standard deviation below which an estimate no longer rests on the prior [1]."""


@dataclass(frozen=True, kw_only=True)
class Tuning:
    """What an observer believes; torques are shares of 3/8 F_N a, the full-slide torque at mu = 1.

    Attributes:
        mu: prior friction coefficient [1].
        mu_std: its standard deviation [1].
        mu_walk: random walk of mu [1/sqrt(s)].
        zero_std: prior standard deviation of the torque zero, as a share [1].
        zero_walk: random walk of the torque zero, as a share [1/sqrt(s)].
        noise: torque noise and model error as a share, standard deviation of one sample in 10 ms [1];
            model error is far from white, so it is large, and it counts by time, not by samples.
        least, greatest: bounds that mu is projected on [1].
    """

    mu: float = 1.0
    mu_std: float = 0.5
    mu_walk: float = 0.02
    zero_std: float = 0.03
    zero_walk: float = 0.001
    noise: float = 0.3
    least: float = 0.02
    greatest: float = 4.0

    def __post_init__(self) -> None:
        """Check signs and order."""
        positive = {"mu_std": self.mu_std, "noise": self.noise, "least": self.least}
        for name, value in positive.items():
            if not value > 0:
                raise InvalidInputError(f"{name} must be greater than 0, got {value}")
        for name in ("mu_walk", "zero_std", "zero_walk"):
            if not getattr(self, name) >= 0:
                raise InvalidInputError(f"{name} must be at least 0, got {getattr(self, name)}")
        if not self.least < self.mu < self.greatest:
            raise InvalidInputError(
                f"mu must lie between least and greatest, {self.least} and {self.greatest},"
                f" got {self.mu}"
            )

    def prior(self, slide: float) -> tuple[Array, Array]:
        """Mean, shape (2,), and covariance, shape (2, 2), of x; `slide` is 3/8 F_N a [N m]."""
        spread = np.array([self.mu_std, self.zero_std * slide])
        return np.array([self.mu, 0.0]), np.diag(spread**2)

    def informed(self, std: float) -> bool:
        """False while an estimate of mu with this standard deviation [1] rests on the prior."""
        return bool(std < INFORMED * self.mu_std)

    @property
    def beliefs(self) -> Array:
        """What a step needs: mu_walk, zero_walk, noise, least, greatest."""
        return np.array([self.mu_walk, self.zero_walk, self.noise, self.least, self.greatest])
