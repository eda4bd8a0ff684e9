"""Parameters of the rig and of the tyre: frozen values that check themselves."""

import math
from dataclasses import dataclass

from symbolic.errors import InvalidInputError

SLIDE_RATE = 0.1
"""Turning rate at which effective friction is stated unless the rig has another one [rad/s]."""
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
RIG_RANGES = {
    "a": HALF_LENGTH,
    "e": (-HALF_LENGTH[1], HALF_LENGTH[1]),
    "J_A": INERTIA,
    "b_t": (0.0, MOST_DAMPING),
    "slide_rate": (0.0, math.inf),
}
"""Ranges of a `Rig`'s numbers; |e| < a besides."""


TOLERATED = {"a": "m", "e": "m", "load": "1", "zero": "N m"}
"""What may be declared with a tolerance, and its unit."""


@dataclass(frozen=True, kw_only=True)
class Tolerances:
    """How far off declared values may be, either way: any value within is as likely as any other.

    Attributes:
        a: of the half-length of the contact patch [m].
        e: of the caster length [m].
        load: of the recorded load, as a share of it [1], less than 1.
        zero: of the zero of the recorded aligning torque [N m].

    Raises:
        InvalidInputError: one is below 0, or not a finite number.
    """

    a: float = 0.0
    e: float = 0.0
    load: float = 0.0
    zero: float = 0.0

    def __post_init__(self) -> None:
        """Check every tolerance."""
        for name, unit in TOLERATED.items():
            most = 1.0 if name == "load" else math.inf
            if not 0 <= getattr(self, name) < most:
                allowed = "of at least 0 and less than 1" if name == "load" else f"of at least 0 {unit}"
                got = f"{getattr(self, name):g}"
                raise InvalidInputError(
                    f"{name}: its tolerance must be a finite number {allowed}, got {got}"
                )


@dataclass(frozen=True, kw_only=True)
class Rig:
    """The wheel on its kingpin, [Györök 2022], fig. 2.1.

    The message of a fault begins with the name of the parameter.

    Attributes:
        a: half-length of the contact patch [m], within `HALF_LENGTH`.
        e: caster length (trail) [m], `|e| < a`; the kingpin A stands at x = e.
        J_A: moment of inertia about the kingpin A [kg m^2], within `INERTIA`; None where unknown.
        b_t: torsional damping [N m s/rad], from 0 to `MOST_DAMPING`; None where unknown.
        slide_rate: turning rate at which the torque of full slide, and so the effective friction, is
            stated [rad/s], greater than 0; see `symbolic.full_slide`.
        tolerances: how far off a, e, the recorded load and the torque's zero may be.

    Raises:
        InvalidInputError: a value is outside its range, or not a finite number.
    """

    a: float
    e: float
    J_A: float | None = None
    b_t: float | None = None
    slide_rate: float = SLIDE_RATE
    tolerances: Tolerances = Tolerances()

    def __post_init__(self) -> None:
        """Check every value against its range."""
        _require_within("a", self.a, HALF_LENGTH, "m")
        if not abs(self.e) < self.a:
            raise InvalidInputError(
                f"e must lie between -a and a, here -{self.a:g} and {self.a:g} m, got {self.e:g}"
            )
        if not abs(self.e) + self.tolerances.e < self.a - self.tolerances.a:
            raise InvalidInputError(
                f"a must stay greater than e and 0 within their tolerances, {self.tolerances.a:g} and"
                f" {self.tolerances.e:g} m, got {self.a:g} and {self.e:g}"
            )
        if self.J_A is not None:
            _require_within("J_A", self.J_A, INERTIA, "kg m^2")
        if self.b_t is not None and not 0 <= self.b_t <= MOST_DAMPING:
            raise InvalidInputError(
                f"b_t must be a number from 0 to {MOST_DAMPING:g} N m s/rad, got {self.b_t:g}"
            )
        _require_positive("slide_rate", self.slide_rate, "rad/s")


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
