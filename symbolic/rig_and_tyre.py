"""Parameters of the rig and of the tyre: frozen values that check themselves."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from symbolic.errors import InvalidInputError

SLIDE_RATE = 0.1
"""Turning rate at which effective friction is stated unless the rig has another one [rad/s]."""
HALF_LENGTH = (1e-3, 1.0)
"""Half-length of a contact patch that the models take [m]."""
INERTIA = (1e-6, 1e4)
"""Moment of inertia that the models take [kg m^2]."""
MAX_DAMPING = 1e4
"""Largest torsional damping that the models take [N m s/rad]."""
STIFFNESS = (1e3, 1e9)
"""Distributed lateral stiffness that the models take [N/m^2]."""
FRICTION = (0.01, 10.0)
"""Coefficient of friction that the models take [1]."""
RIG_RANGES = {
    "a": HALF_LENGTH,
    "e": (-HALF_LENGTH[1], HALF_LENGTH[1]),
    "J_A": INERTIA,
    "b_t": (0.0, MAX_DAMPING),
    "slide_rate": (0.0, math.inf),
    "noise": (0.0, math.inf),
    "dry_friction": (0.0, math.inf),
    "zero_std": (0.0, math.inf),
}
"""Ranges of a `Rig`'s numbers; |e| < a besides."""


TOLERATED = {"a": "m", "e": "m", "load": "1", "zero": "N m", "k": "N/m^2"}
"""Values that may be declared with a tolerance, and their units."""
USUAL = {"a": 0.002, "e": 0.002, "load": 0.02, "k": 0.2}
"""Tolerances of what is declared without one: lengths [m], load and k as shares [1]."""
USED_RANGE = 0.95
"""Share of the declared range of a torque sensor from which on a torque is left out [1]: what its noise
and its zero take from the range."""
EVEN = 3**-0.5
"""Standard deviation of a value that may be anywhere within a tolerance, over the tolerance [1]."""
_SMALL = 1e-3
"""Step of a difference quotient, as a share of the half-length [1]."""


@dataclass(frozen=True, kw_only=True)
class Tolerances:
    """How far off declared values may be, either way: any value within is as likely as any other.

    Attributes:
        a: of the half-length of the contact patch [m].
        e: of the caster length [m].
        load: of the recorded load, as a share of it [1], less than 1.
        zero: of the zero of the recorded aligning torque [N m].
        k: of the distributed lateral stiffness [N/m^2].
        scale: of the recorded torque, as a share of it [1]; by a found k, or by what a car declares.

    None stands for nothing declared: a fit takes the value as exact, a diagnosis and an observer take
    `USUAL`. 0 stands for exact.

    Raises:
        InvalidInputError: one is below 0, or not a finite number.
    """

    a: float | None = None
    e: float | None = None
    load: float | None = None
    zero: float | None = None
    k: float | None = None
    scale: float = 0.0

    def tolerance_or_zero(self, name: str) -> float:
        """A tolerance by its name, 0 where none is declared."""
        declared: float | None = getattr(self, name)
        return 0.0 if declared is None else declared

    def __post_init__(self) -> None:
        """Check every tolerance."""
        for name, unit in TOLERATED.items():
            most = 1.0 if name == "load" else math.inf
            if not 0 <= self.tolerance_or_zero(name) < most:
                allowed = "of at least 0 and less than 1" if name == "load" else f"of at least 0 {unit}"
                got = f"{self.tolerance_or_zero(name):g}"
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
        b_t: torsional damping [N m s/rad], from 0 to `MAX_DAMPING`; None where unknown.
        slide_rate: turning rate at which the torque of full slide, and so the effective friction, is
            stated [rad/s], greater than 0; see `symbolic.full_slide_friction`.
        tolerances: how far off a, e, k, the recorded load and the torque's zero may be.
        noise: white error of the torque sensor, of one sample in 10 ms, greater than 0 [N m]; None
            where unknown, as for the next two.
        dry_friction: of the bearings between the sensor and the patch, at least 0 [N m].
        range: torque up to which its sensor is straight, either way, greater than 0 [N m].

    Raises:
        InvalidInputError: a value is outside its range, or not a finite number.
    """

    a: float
    e: float
    J_A: float | None = None
    b_t: float | None = None
    slide_rate: float = SLIDE_RATE
    tolerances: Tolerances = Tolerances()
    noise: float | None = None
    dry_friction: float | None = None
    range: float | None = None

    @property
    def zero_std(self) -> float | None:
        """Standard deviation of the torque's zero, greater than 0 [N m]; None where unknown."""
        return self.tolerances.zero and EVEN * self.tolerances.zero

    @property
    def sensor_torque_limit(self) -> float:
        """Torque from which on its sensor may end [N m]; infinite where its range is unknown."""
        return math.inf if self.range is None else USED_RANGE * self.range

    def __post_init__(self) -> None:
        """Check every value against its range."""
        _require_within("a", self.a, HALF_LENGTH, "m")
        if not abs(self.e) < self.a:
            raise InvalidInputError(
                f"e must lie between -a and a, here -{self.a:g} and {self.a:g} m, got {self.e:g}"
            )
        off_a, off_e = (self.tolerances.tolerance_or_zero(name) for name in "ae")
        if not abs(self.e) + off_e < self.a - off_a:
            spans = f"{off_a:g} and {off_e:g} m"
            raise InvalidInputError(
                f"a must stay greater than e and 0 within their tolerances, {spans}, got {self.a:g} and"
                f" {self.e:g}"
            )
        if self.J_A is not None:
            _require_within("J_A", self.J_A, INERTIA, "kg m^2")
        if self.b_t is not None and not 0 <= self.b_t <= MAX_DAMPING:
            raise InvalidInputError(
                f"b_t must be a number from 0 to {MAX_DAMPING:g} N m s/rad, got {self.b_t:g}"
            )
        require_positive("slide_rate", self.slide_rate, "rad/s")
        for name, value in (("noise", self.noise), ("range", self.range)):
            if value is not None:
                require_positive(name, value, "N m")
        if self.dry_friction is not None and not 0 <= self.dry_friction < math.inf:
            raise InvalidInputError(
                f"dry_friction must be a finite number of at least 0 N m, got {self.dry_friction:g}"
            )


def with_usual_tolerances(rig: Rig) -> Rig:
    """The rig with the tolerances of `USUAL` where none is declared; the kingpin stays inside."""
    declared = rig.tolerances
    room = rig.a - abs(rig.e) - declared.tolerance_or_zero("a") - declared.tolerance_or_zero("e")
    missing = {n: t for n, t in USUAL.items() if n != "k" and getattr(declared, n) is None}
    usual = {n: t if n == "load" else min(t, room / 3) for n, t in missing.items()}
    return replace(rig, tolerances=replace(declared, **usual))


def relative_std_by_lengths(quantity: Callable[[float, float], float], rig: Rig) -> float:
    """Relative standard deviation of a quantity of a and e within their tolerances, or `USUAL` [1]."""
    a = USUAL["a"] if rig.tolerances.a is None else rig.tolerances.a
    e = USUAL["e"] if rig.tolerances.e is None else rig.tolerances.e
    least = _SMALL * rig.a
    by_a = (quantity(rig.a + least, rig.e) - quantity(rig.a - least, rig.e)) / (2 * least)
    by_e = (quantity(rig.a, rig.e + least) - quantity(rig.a, rig.e - least)) / (2 * least)
    return EVEN * math.hypot(by_a * a, by_e * e) / quantity(rig.a, rig.e)


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


def require_positive(name: str, value: float, unit: str = "") -> None:
    """Refuse a value [unit] that is not finite and greater than 0; the message begins with its name."""
    if not 0 < value < math.inf:
        allowed = f"a finite number greater than 0 {unit}".rstrip()
        raise InvalidInputError(f"{name} must be {allowed}, got {value:g}")


def _require_within(name: str, value: float, bounds: tuple[float, float], unit: str) -> None:
    require_positive(name, value, unit)
    if not bounds[0] <= value <= bounds[1]:
        allowed = f"between {bounds[0]:g} and {bounds[1]:g} {unit}".rstrip()
        raise InvalidInputError(f"{name} must lie {allowed}, got {value:g}")
