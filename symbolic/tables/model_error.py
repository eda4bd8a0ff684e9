"""How wrong a model is: the size of its torque error, and for how long it lasts."""

import math
from dataclasses import dataclass

from symbolic.errors import InvalidInputError


@dataclass(frozen=True, kw_only=True)
class ModelError:
    """The torque error of a model on recordings to which its shared parameters were not fitted.

    Attributes:
        spread: root mean square of the error as a share of the torque of full slide with mu = 1,
            (3/8) F_N a, at least 0 [1].
        correlation_time: integrated autocorrelation time of the error, greater than 0 [s]: it is worth
            one independent sample in so much time. Twice the time constant of an error whose
            autocorrelation is an exponential.
        relative: the same root mean square as a share of the torque that there is, half the range of the
            recording's torque, at least 0 [1]; None in a file that does not tell it.
        friction_walk: change of the level of sliding friction from one slide to the next, as the
            random walk of mu that makes it, a share of mu, at least 0 [1/sqrt(s)]; None where unknown.

    Raises:
        InvalidInputError: a value is outside its range, or not a finite number.
    """

    spread: float
    correlation_time: float
    relative: float | None = None
    friction_walk: float | None = None

    def __post_init__(self) -> None:
        """Check both values against their ranges."""
        if not 0 <= self.spread < math.inf:
            raise InvalidInputError(f"spread must be a finite number of at least 0, got {self.spread}")
        for name in ("relative", "friction_walk"):
            value = getattr(self, name)
            if value is not None and not 0 <= value < math.inf:
                raise InvalidInputError(f"{name} must be a finite number of at least 0, got {value}")
        if not 0 < self.correlation_time < math.inf:
            raise InvalidInputError(
                f"correlation_time must be a finite number greater than 0 s, got {self.correlation_time}"
            )

    @property
    def share(self) -> float:
        """The error as a share of the torque that there is [1]; the spread where that is not told."""
        return self.spread if self.relative is None else self.relative
