"""A car as far as its front axle at standstill needs it: declared values, defaults, tolerances.

Five numbers begin it: front axle load, tyre size and pressure, wheelbase and track, steering ratio. The
rest has defaults of a passenger car, each with its tolerance.

| follows | from |
|---|---|
| contact area | wheel load less `CARCASS` of it, over the pressure |
| half-length a | area / (2 width), the width `TREAD` of the tyre's nominal one; within 15 % |
| stiffness k | `CORNERING` F_N / (2 a^2), the brush model's cornering stiffness; [Pacejka 2012], (3.5) |
"""

from dataclasses import dataclass
from itertools import pairwise
from math import inf, isfinite, nan, pi
from typing import Annotated, NamedTuple, get_origin, get_type_hints

from symbolic.errors import InvalidInputError
from symbolic.rig_and_tyre import EVEN

CARCASS = 0.1
"""Share of the load that the carcass carries without the pressure [1]."""
TREAD = 0.8
"""Width of the contact over the tyre's nominal width [1]."""
CORNERING = 15.0
"""Cornering stiffness over the load of a passenger car's tyre [1/rad]; [Pacejka 2012], chapter 1."""
LEAST_GAIN, MOST_GAIN = 0.00125, 0.06
"""Way of the rack over the turn of its pinion [m/rad]."""
MOST_WAY = 0.2
"""Way of the rack to one side that no car has [m]."""
IN_SI = "angles are in rad, 6.283 a turn and 0.01745 a degree, and ways in m"
STD_PER_TOLERANCE = EVEN
"""Standard deviation of a declared value over its tolerance [1]: any value within is as likely."""


Pairs = tuple[tuple[float, float], ...]
"""Angles of the handwheel [rad] and the rack's ways there [m]."""


class AllowedRange(NamedTuple):
    """Least and greatest value of a number, and its unit."""

    least: float
    most: float
    unit: str


OTHER_UNITS = {"rad": ("degrees", pi / 180), "Pa": ("bar", 1e5), "m": ("mm", 1e-3), "N": ("kN", 1e3)}
"""The unit that a number out of its range may be in, and what that unit is, by the one that it has."""


def _other_unit_hint(value: float, allowed: AllowedRange) -> str:
    """What a number is in its unit if it was given in the usual other one; empty if that is not so."""
    name, factor = OTHER_UNITS.get(allowed.unit, ("", nan))
    converted = f"{value * factor:.3g}".replace("e+0", "e")
    told = f"; {value:g} looks like {name}: {converted}"
    return told * bool(allowed.least <= value * factor <= allowed.most)


@dataclass(frozen=True, kw_only=True)
class VehicleTolerances:
    """How far off declared values may be, either way, as a share of them [1].

    Attributes:
        load: of the front axle load.
        half_length: of the half-length of the contact.
        stiffness: of the tyre's stiffness.
        slide_factor: of the measured factor on the torque of full slide.
        gear_friction: of the gear's dry friction.
        damping: of the damping about the kingpin.
        geometry: of lengths and ratios of the steering.
        force_scale: of the measured force's scale, such as a motor's torque constant; what a measured
            slide factor has in it.
    """

    load: float = 0.1
    half_length: float = 0.15
    stiffness: float = 0.2
    slide_factor: float = 0.05
    gear_friction: float = 0.5
    damping: float = 0.5
    geometry: float = 0.03
    force_scale: float = 0.05

    def __post_init__(self) -> None:
        """Check every share."""
        for name, share in vars(self).items():
            if not 0 <= share < 1:
                raise InvalidInputError(
                    f"tolerance of {name} must be from 0 to less than 1, got {share}"
                )


@dataclass(frozen=True, kw_only=True)
class Vehicle:
    """The front axle of a car, its steering and its tyres.

    Axes are those of ISO 8855: x forward, y left, z up. Angles and the rack's way are positive to the
    left.

    Attributes:
        front_axle_load: of both front wheels [N].
        tyre_width: nominal, 0.205 of a 205/55 R16 [m].
        pressure: of inflation [Pa].
        wheel_radius: of a loaded front wheel [m].
        wheelbase, track: of the car, the latter in front [m].
        steering_ratio: turn of the handwheel over the mean angle of the wheels, straight ahead [1].
        rack_by_handwheel: angles of the handwheel from the middle to the left [rad] and the rack's ways
            there [m], where the ratio varies; empty where `steering_ratio` counts.
        steering_arm: way of the rack over the mean angle of the wheels, straight ahead [m/rad].
        half_length, contact_width: of the contact of one tyre [m]; None follows from load and pressure.
        stiffness: distributed lateral stiffness k of a tyre [N/m^2]; None follows from the load.
        slide_factor: measured torque of full slide over that of load, half-length and lever [1]. It
            stands for the errors of all of them at the load at which it was measured, the stiffness was
            measured with it, and the tolerance of the load is what the load may have changed by since.
            None where it was not measured.
        slide_load: front axle load at which `slide_factor` was measured, and at which a declared
            half-length holds, which is as long as the load makes it [N]; None for `front_axle_load`.
        trail: distance of the contact's middle behind the kingpin's point on the ground [m].
        scrub_radius: distance of the contact's middle outside of that point [m].
        inclination, caster: of the kingpin, its top inwards and its top backwards [rad].
        rack_travel: of the rack from the middle to full lock [m].
        lever_loss: share of the steering arm that is lost at full lock [1].
        ackermann: share of Ackermann's difference of the wheels' angles [1].
        gear_friction: dry friction at the rack under no load [N].
        gear_load_share: share of the force on the rack by which that friction grows [1].
        presliding: way of the rack in which that friction turns over, from the middle [m].
        rack_mass: moving with the rack, the motor's inertia included [kg].
        damping: viscous, of joints and gear, about the kingpin of one wheel [N m s/rad].
        handwheel_inertia: of what turns between the torque's sensor and the torsion bar, 0 where that
            is the sensor [kg m^2]; None where it is not declared. Counts by the ratio straight ahead.
        torsion_bar: rate [N m/rad]; inf where the angle is that of the pinion.
        motor_ratio: of the assistance, turn of the motor over that of the pinion straight ahead [1]; its
            gear to the rack does not vary.
        motor_efficiency: of that gear [1].
        force_noise: white error of the force on the rack, of one sample in 10 ms [N].
        force_error: error of it that lasts for tenths of a second, by ripple of the motor, inertia and
            play, as a standard deviation [N].
        force_zero: how far off its zero may be [N].
        standstill: speed up to which the car stands [m/s].
        brakes: whether the wheels are held by the brakes where no signal says so.
        tolerances: of these values.

    Raises:
        InvalidInputError: a value is out of its range.
    """

    front_axle_load: Annotated[float, AllowedRange(500.0, 60e3, "N")]
    tyre_width: Annotated[float, AllowedRange(0.1, 0.4, "m")]
    pressure: Annotated[float, AllowedRange(5e4, 1e6, "Pa")]
    wheelbase: Annotated[float, AllowedRange(1.0, 7.0, "m")]
    track: Annotated[float, AllowedRange(0.8, 3.0, "m")]
    wheel_radius: Annotated[float, AllowedRange(0.15, 0.7, "m")] = 0.3
    steering_ratio: Annotated[float, AllowedRange(5.0, 40.0, "1")] = 15.0
    steering_arm: Annotated[float, AllowedRange(0.05, 0.3, "m")] = 0.125
    half_length: Annotated[float | None, AllowedRange(0.02, 0.2, "m")] = None
    contact_width: Annotated[float | None, AllowedRange(0.05, 0.4, "m")] = None
    stiffness: Annotated[float | None, AllowedRange(1e5, 1e9, "N/m^2")] = None
    slide_factor: Annotated[float | None, AllowedRange(0.3, 3.0, "1")] = None
    slide_load: Annotated[float | None, AllowedRange(500.0, 60e3, "N")] = None
    trail: Annotated[float, AllowedRange(-0.05, 0.1, "m")] = 0.02
    scrub_radius: Annotated[float, AllowedRange(-0.1, 0.2, "m")] = 0.01
    inclination: Annotated[float, AllowedRange(-0.1, 0.5, "rad")] = 12 * pi / 180
    caster: Annotated[float, AllowedRange(-0.1, 0.3, "rad")] = 5 * pi / 180
    rack_travel: Annotated[float, AllowedRange(0.02, 0.2, "m")] = 0.075
    lever_loss: Annotated[float, AllowedRange(-0.2, 0.6, "1")] = 0.25
    ackermann: Annotated[float, AllowedRange(-0.5, 1.5, "1")] = 0.6
    gear_friction: Annotated[float, AllowedRange(0.0, 2e3, "N")] = 200.0
    gear_load_share: Annotated[float, AllowedRange(0.0, 0.3, "1")] = 0.02
    presliding: Annotated[float, AllowedRange(1e-6, 5e-3, "m")] = 6e-5
    rack_mass: Annotated[float, AllowedRange(0.0, 2e3, "kg")] = 0.0
    damping: Annotated[float, AllowedRange(0.0, 200.0, "N m s/rad")] = 20.0
    handwheel_inertia: Annotated[float | None, AllowedRange(0.0, 0.2, "kg m^2")] = None
    torsion_bar: Annotated[float, AllowedRange(10.0, inf, "N m/rad")] = 115.0
    motor_ratio: Annotated[float, AllowedRange(0.0, 100.0, "1")] = 0.0
    motor_efficiency: Annotated[float, AllowedRange(0.3, 1.0, "1")] = 0.9
    force_noise: Annotated[float, AllowedRange(1.0, 2e3, "N")] = 40.0
    force_error: Annotated[float, AllowedRange(0.0, 2e3, "N")] = 40.0
    force_zero: Annotated[float, AllowedRange(0.0, 2e3, "N")] = 60.0
    standstill: Annotated[float, AllowedRange(1e-4, 1.0, "m/s")] = 0.02
    brakes: bool = True
    rack_by_handwheel: Pairs = ()
    tolerances: VehicleTolerances = VehicleTolerances()

    def __post_init__(self) -> None:
        """Check every value against its range, and each pair against the one before."""
        pairs = tuple((float(angle), float(way)) for angle, way in self.rack_by_handwheel)
        object.__setattr__(self, "rack_by_handwheel", pairs)
        for before, (angle, way) in pairwise(((0.0, 0.0), *pairs)):
            turn, moved = angle - before[0], way - before[1]
            if not (0 < turn < inf and LEAST_GAIN * turn <= moved <= MOST_GAIN * turn):
                raise InvalidInputError(
                    "rack_by_handwheel must have pairs of rad and m to the left, each from"
                    f" {LEAST_GAIN:g} to {MOST_GAIN:g} m/rad on from the one before, got"
                    f" {angle:g}, {way:g} after {before[0]:g}, {before[1]:g}; {IN_SI}"
                )
        if pairs:
            self._check_rack_by_handwheel(pairs)
        faults = []
        for name, allowed in RANGES.items():
            value, (least, most, unit) = getattr(self, name), allowed
            if value is not None and not (least <= value <= most and (isfinite(value) or most == inf)):
                other = _other_unit_hint(value, allowed)
                faults.append(
                    f"{name} must lie between {least:g} and {most:g} {unit}, got {value:g}{other}"
                )
        if faults:
            raise InvalidInputError("; ".join(faults))

    def _check_rack_by_handwheel(self, pairs: "Pairs") -> None:
        """Raises InvalidInputError where pairs are of a steering as no car has one."""
        if pairs[-1][1] > MOST_WAY:
            raise InvalidInputError(
                f"rack_by_handwheel ends {pairs[-1][1]:g} m from the middle, more than {MOST_WAY:g} m;"
                f" {IN_SI}"
            )
        least, most, _ = RANGES["steering_ratio"]
        if not least <= (ratio := self.steering_arm / self.rack_gain) <= most:
            raise InvalidInputError(
                f"rack_by_handwheel is a steering ratio of {ratio:.3g} straight ahead, which must lie"
                f" between {least:g} and {most:g}; {IN_SI}"
            )

    @property
    def wheel_load(self) -> float:
        """Load of one front wheel [N]."""
        return self.front_axle_load / 2

    @property
    def patch_width(self) -> float:
        """Width of the contact [m]."""
        return TREAD * self.tyre_width if self.contact_width is None else self.contact_width

    @property
    def a(self) -> float:
        """Half-length of the contact [m]."""
        area = self.wheel_load * (1 - CARCASS) / self.pressure
        if self.half_length is None:
            return area / (2 * self.patch_width)
        return self.half_length * (1 + self.load_change_since_slide)

    @property
    def load_change_since_slide(self) -> float:
        """Change of the load since `slide_factor` was measured, as a share [1]."""
        return 0.0 if self.slide_load is None else self.front_axle_load / self.slide_load - 1

    @property
    def k(self) -> float:
        """Distributed lateral stiffness of a tyre [N/m^2]."""
        return (
            CORNERING * self.wheel_load / (2 * self.a**2) if self.stiffness is None else self.stiffness
        )

    @property
    def moved_mass(self) -> float:
        """Mass that the measured force moves, at the rack, the handwheel's inertia in it [kg]."""
        return self.rack_mass + (self.handwheel_inertia or 0.0) / self.rack_gain**2

    @property
    def rack_gain(self) -> float:
        """Way of the rack over the turn of the pinion, straight ahead where it varies [m/rad]."""
        for angle, way in self.rack_by_handwheel[:1]:
            return way / angle
        return self.steering_arm / self.steering_ratio


RANGES: dict[str, AllowedRange] = {
    name: hint.__metadata__[0]
    for name, hint in get_type_hints(Vehicle, include_extras=True).items()
    if get_origin(hint) is Annotated
}
"""What is allowed for every number of a `Vehicle`, by its name."""
