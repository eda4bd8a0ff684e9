"""Parameters of the rig and of the tyre: frozen values that check themselves."""

import math
from dataclasses import dataclass

from symbolic.errors import InvalidInputError

HALF_LENGTH = (1e-3, 1.0)
"""Half-length of a contact patch that the models take [m]."""
INERTIA = (1e-6, 1e4)
"""Moment of inertia that the models take [kg m^2]."""
MOST_DAMPING = 1e4
"""Largest torsional damping that the models take [N m s/rad]."""
STIFFNESS = (1e3, 1e9)
"""Distributed lateral stiffness that the models take [N/m^2]."""
FRICTION = (0.01, 10.0)
"""Coefficient of friction that the models take [1]."""


@dataclass(frozen=True, kw_only=True)
class Rig:
    """The wheel on its kingpin, [Györök 2022], fig. 2.1.

    The message of a fault begins with the name of the parameter.

    Attributes:
        a: half-length of the contact patch [m], within `HALF_LENGTH`.
        e: caster length (trail) [m], |e| < a; the kingpin A stands at x = e.
        J_A: moment of inertia about the kingpin A [kg m^2], greater than 0; None where unknown.
        b_t: torsional damping [N m s/rad], at least 0; None where unknown.

    Raises:
        InvalidInputError: a value is outside its range, or not a finite number.
    """

    a: float
    e: float
    J_A: float | None = None
    b_t: float | None = None

    def __post_init__(self) -> None:
        """Check every value against its range."""
        _require_within("a", self.a, HALF_LENGTH, "m")
        if not abs(self.e) < self.a:
            raise InvalidInputError(
                f"e must lie between -a and a, here -{self.a:g} and {self.a:g} m, got {self.e:g}"
            )
        if self.J_A is not None:
            _require_within("J_A", self.J_A, INERTIA, "kg m^2")
        if self.b_t is not None and not 0 <= self.b_t <= MOST_DAMPING:
            raise InvalidInputError(
                f"b_t must be a number from 0 to {MOST_DAMPING:g} N m s/rad, got {self.b_t:g}"
            )


@dataclass(frozen=True, kw_only=True)
class Tyre:
    """The brush model's tyre on its ground.

    The message of a fault begins with the name of the parameter.

    Attributes:
        k: distributed lateral stiffness [N/m^2], within `STIFFNESS`.
        mu: declared coefficient of friction [1], within `FRICTION`; None where unknown.

    Raises:
        InvalidInputError: a value is outside its range, or not a finite number.
    """

    k: float
    mu: float | None = None

    def __post_init__(self) -> None:
        """Check every value against its range."""
        _require_within("k", self.k, STIFFNESS, "N/m^2")
        if self.mu is not None:
            _require_within("mu", self.mu, FRICTION, "")


def _require_positive(name: str, value: float, unit: str) -> None:
    if not 0 < value < math.inf:
        allowed = f"a finite number greater than 0 {unit}".rstrip()
        raise InvalidInputError(f"{name} must be {allowed}, got {value:g}")


def _require_within(name: str, value: float, bounds: tuple[float, float], unit: str) -> None:
    _require_positive(name, value, unit)
    if not bounds[0] <= value <= bounds[1]:
        allowed = f"between {bounds[0]:g} and {bounds[1]:g} {unit}".rstrip()
        raise InvalidInputError(f"{name} must lie {allowed}, got {value:g}")
