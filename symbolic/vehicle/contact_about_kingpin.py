r"""A wheel that turns about its kingpin: its stand, and the torque that its contact resists with.

The wheel is a disc; its middle and its axle turn about the kingpin's axis (Rodrigues), and it stands on
the lowest point of its rim. As the kingpin leans inwards by sigma, that point wanders along the rim
by nearly R sin sigma sin psi: behind the kingpin on the inner wheel, before it on the outer one. So the
arms of the contact grow to either side. The torque of full slide grows as 1 + c_M sin^2 psi and the
stiffness as 1 + c_k sin^2 psi, means of both wheels, with c_M and c_k from full lock.

Contacts behind their kingpins push the car's nose sideways, which gives way within some millimetres of
e psi: tyres and suspension hold it by some 50 kN/m only. The contacts then turn about a point between
their middles and the kingpins; of the mean trail the share `NOSE` counts, none or twice that at
most.

Real prints bear no parabola: the pressure is flatter along them, and falls off towards their shoulders.

In terms of the contact straight ahead that is a torque divided by the first and an angle

    psi' = int (1 + c_k sin^2) / (1 + c_M sin^2) dpsi
         = psi + (c_k - c_M) (psi - sin psi cos psi) / 2, nearly.

A torque about the kingpin is that about the vertical times the cosine of the axis with it; so is the
turn of the contact.
"""

from dataclasses import dataclass, replace
from functools import cache
from math import sin

import numpy as np

from symbolic.float_array_type import Array
from symbolic.vehicle.steering import lock_angle
from symbolic.vehicle.vehicle import Vehicle

ALONG, ACROSS = 2.5, 8.0
"""Pressure ~ (1 - |x/a|^n) (1 - |y/b|^m): flatter than a parabola along it, with rounded shoulders."""
NOSE = 0.3
"""Share of the trail about which the contacts turn [1]."""


@dataclass(frozen=True)
class Contact:
    """The contact of one tyre: half-length, half-width, and how far it is behind and outside [m]."""

    a: float
    b: float
    e: float
    r_s: float

    @classmethod
    def from_vehicle(cls, vehicle: Vehicle, *, brakes: bool) -> "Contact":
        """That of a vehicle whose wheels are held by the brakes, or roll about the kingpin."""
        return cls(
            vehicle.a,
            vehicle.patch_width / 2,
            NOSE * vehicle.trail,
            vehicle.scrub_radius if brakes else 0.0,
        )

    @property
    def slide_arm(self) -> float:
        """Torque of full slide over mu and load [m]: the mean arm under the pressure."""
        pressure, arm = pressures_and_arms(self)
        return float((pressure * arm).mean() / pressure.mean())

    @property
    def stiffness(self) -> float:
        """Torque over turn while it sticks, over k [m^3]."""
        return 2 * self.a * ((self.a**2 + self.b**2) / 3 + self.e**2 + self.r_s**2)


@dataclass(frozen=True)
class TorqueAndStiffnessGrowth:
    """Growth of torque and stiffness with the square of the sine of the angle [1]."""

    torque: float
    stiffness: float


@cache
def pressures_and_arms(contact: Contact) -> tuple[Array, Array]:
    """Pressure over that in the middle, and arm [m], of bristles spread evenly over the contact."""
    x, y = (((np.arange(n) + 0.5) / n * 2 - 1) for n in (120, 60))
    along, across = np.meshgrid(x, y, indexing="ij")
    arm = np.hypot(contact.a * along + contact.e, contact.b * across + contact.r_s)
    return ((1 - np.abs(along) ** ALONG) * (1 - np.abs(across) ** ACROSS)).ravel(), arm.ravel()


def kingpin_axis(vehicle: Vehicle, side: int = 1) -> Array:
    """Direction of the kingpin of the left wheel (side 1) or the right one (-1), upwards."""
    axis = np.array([-np.tan(vehicle.caster), -side * np.tan(vehicle.inclination), 1.0])
    direction: Array = axis / float(np.linalg.norm(axis))
    return direction


def contact_offset_from_kingpin(vehicle: Vehicle, psi: float, side: int) -> tuple[float, float]:
    """How far a wheel stands behind and outside of its kingpin's point on the ground [m]."""
    axis = kingpin_axis(vehicle, side)

    def turned(vector: Array) -> Array:
        across = np.cross(axis, vector) * np.sin(psi)
        moved: Array = vector * np.cos(psi) + across + axis * (axis @ vector) * (1 - np.cos(psi))
        return moved

    middle = turned(np.array([-vehicle.trail, side * vehicle.scrub_radius, vehicle.wheel_radius]))
    axle = turned(np.array([0.0, 1.0, 0.0]))
    up = np.array([0.0, 0.0, 1.0]) - axle * axle[2]
    lowest = middle - vehicle.wheel_radius * up / np.linalg.norm(up)
    along = np.cross(axle, [0.0, 0.0, 1.0])
    along = along / np.linalg.norm(along)
    from_kingpin = lowest - axis * lowest[2] / axis[2]
    outwards = side * (from_kingpin @ np.cross([0.0, 0.0, 1.0], along))
    return -float(from_kingpin @ along), float(outwards)


@cache
def contact_growth_at_full_lock(vehicle: Vehicle, *, brakes: bool) -> TorqueAndStiffnessGrowth:
    """Growth of the contacts' torque and stiffness at full lock, as means of both wheels."""
    straight, lock = Contact.from_vehicle(vehicle, brakes=brakes), lock_angle(vehicle)
    points = [contact_offset_from_kingpin(vehicle, lock, side) for side in (1, -1)]
    mean = (points[0][0] + points[1][0]) / 2
    both = [replace(straight, e=straight.e + e - mean, r_s=r_s * brakes) for e, r_s in points]
    squared = sin(lock) ** 2
    arm = sum(each.slide_arm for each in both) / 2 / straight.slide_arm
    stiffness = sum(each.stiffness for each in both) / 2 / straight.stiffness
    return TorqueAndStiffnessGrowth(torque=(arm - 1) / squared, stiffness=(stiffness - 1) / squared)
