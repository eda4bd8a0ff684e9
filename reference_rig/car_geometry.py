"""Geometry of a steered axle: the trapezoid of rack, tie rods and arms, and the lift of the body.

Axes of ISO 8855: x forward, y left, z up. A point of the plan view is a complex number x + i y [m]. The
rack lies behind the axle, so that it moves to the right for a turn to the left.
"""

from cmath import exp
from dataclasses import dataclass
from functools import lru_cache
from math import cos, sin, tan

import numpy as np
from scipy.optimize import brentq

from reference_rig.hooks import Array

SIDES = (1.0, -1.0)
"""Left and right wheel: sign of y."""
STEER_STEP = 2e-3
"""Spacing of the table of stands [rad]."""
MAX_STEER = 1.2
"""Largest angle of that table [rad]."""


@dataclass(frozen=True, kw_only=True)
class Linkage:
    """Plan view of the linkage, the same on both sides. Lengths [m]."""

    track: float = 1.36  # Between the kingpins' points on the ground.
    arm: float = 0.13  # Length of the steering arm.
    # By which the arm points inwards from straight back [rad]; it makes the outer wheel turn less.
    arm_angle: float = 0.2
    rack_length: float = 0.62  # Between the inner joints.
    rack_behind: float = 0.14  # Distance of the rack behind the axle.

    def pivot(self, side: float) -> complex:
        """Kingpin in the plan view."""
        return 0.5j * side * self.track

    def arm_at_rest(self, side: float) -> complex:
        """From the kingpin to the outer joint, wheels straight ahead."""
        return -self.arm * exp(1j * side * self.arm_angle)

    def joint(self, side: float, rack: float) -> complex:
        """Inner joint for a displacement of the rack [m]."""
        return -self.rack_behind + 1j * (0.5 * side * self.rack_length - rack)

    @property
    def tie_rod(self) -> float:
        """Length of a tie rod: that which lets both wheels point straight ahead."""
        return abs(self.pivot(1.0) + self.arm_at_rest(1.0) - self.joint(1.0, 0.0))

    def gap(self, side: float, rack: float, steer: float) -> float:
        """Distance of the joints less the tie rod's length [m]."""
        tip = self.pivot(side) + self.arm_at_rest(side) * exp(1j * steer)
        return abs(tip - self.joint(side, rack)) - self.tie_rod

    def steer(self, side: float, rack: float) -> float:
        """Angle of a wheel about its kingpin that closes the linkage [rad], positive to the left."""
        reach = MAX_STEER
        while self.gap(side, rack, -reach) * self.gap(side, rack, reach) > 0:
            reach *= 0.8
        return float(brentq(lambda angle: self.gap(side, rack, angle), -reach, reach, xtol=1e-13))

    def rack_at(self, side: float, steer: float) -> float:
        """Displacement of the rack [m] for an angle of a wheel [rad]."""
        tip = self.pivot(side) + self.arm_at_rest(side) * exp(1j * steer)
        across = np.sqrt(self.tie_rod**2 - (tip.real + self.rack_behind) ** 2)
        return float(0.5 * side * self.rack_length - (tip.imag - side * across))


def ackermann_share(linkage: Linkage, wheelbase: float, rack: float) -> float:
    """Share of the ideal difference of the wheels' cotangents [1] at a displacement of the rack."""
    inner, outer = linkage.steer(1.0, abs(rack)), linkage.steer(-1.0, abs(rack))
    return (1 / tan(outer) - 1 / tan(inner)) * wheelbase / linkage.track


@dataclass(frozen=True, kw_only=True)
class Kingpin:
    """Axis about which a wheel is steered. It meets the ground inside and ahead of the patch."""

    inclination: float = 0.22  # Lean towards the car's middle [rad].
    caster: float = 0.08  # Lean backwards [rad].
    scrub_radius: float = 0.01  # Patch's middle outside the axis' point on the ground [m].
    trail: float = 0.02  # Patch's middle behind it [m].
    radius: float = 0.31  # Of the wheel under load [m].

    @property
    def upright(self) -> float:
        """Vertical part of the axis' unit vector [1]."""
        return 1 / np.sqrt(1 + tan(self.inclination) ** 2 + tan(self.caster) ** 2)

    def stand(self, side: float, steer: float) -> tuple[float, complex]:
        """Rise of the body [m] and middle of the patch [m] of a wheel steered by an angle [rad].

        A disc turns about a leaning axis; the middle is from the axis' point on the ground, in axes
        that turn with the tread. A leaning axis also spins the wheel, so the middle wanders along the
        tread even where the brake holds it.
        """
        axis = np.array([-tan(self.caster), -side * tan(self.inclination), 1.0]) * self.upright
        hub = np.array([-self.trail, side * self.scrub_radius, self.radius])
        spindle = np.array([0.0, 1.0, 0.0])
        hub, spindle = (_turned(vector, axis, steer) for vector in (hub, spindle))
        level = np.sqrt(1 - spindle[2] ** 2)
        # The lowest point lies below the hub in the plane of the disc.
        lowest = hub - self.radius * (np.array([0.0, 0.0, 1.0]) - spindle[2] * spindle) / level
        middle = complex(lowest[0], lowest[1]) * exp(-1j * self.upright * steer)
        return float(-lowest[2]), middle


def _turned(vector: Array, axis: Array, angle: float) -> Array:
    """Rodrigues' rotation."""
    along = axis * (axis @ vector)
    return along + cos(angle) * (vector - along) + sin(angle) * np.cross(axis, vector)


@lru_cache(maxsize=64)
def stand_table(kingpin: Kingpin, side: float) -> tuple[list[float], list[float], list[complex]]:
    """Rise [m], its slope [m/rad] and the patch's middle [m], from -LARGEST_STEER by STEER_STEP."""
    count = round(MAX_STEER / STEER_STEP)
    stands = [kingpin.stand(side, STEER_STEP * i) for i in range(-count, count + 1)]
    rise = np.array([stand[0] for stand in stands])
    return rise.tolist(), np.gradient(rise, STEER_STEP).tolist(), [stand[1] for stand in stands]
