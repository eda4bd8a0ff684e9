r"""The one wheel that stands for both front wheels: the declared patch of the same torque.

Both wheels turn by nearly the mean angle psi, so that the axle's torque by virtual work, referred to
psi, is twice that of one wheel; what their angles differ by changes it to second order. A bristle at
(x, y) from the middle of the contact moves on a circle about the kingpin's point on the ground. It is a
scalar stop with the arm

    l = sqrt((x + e)^2 + (y + r_s)^2)      brakes on,
    l = sqrt((x + e)^2 + y^2)              brakes off: the wheel rolls by r_s psi,

(PHYSICS, patch width), and slips at the turn mu p(x, y) / (c l), p the pressure, parabolic over the
length, and c = k / width. So contact and kingpin matter by the distribution of these turns alone, and
the line of the declared model has nearly the same one for a half-length, a caster and a stiffness of
its own: the same torque of full slide, F_N mean(l), and a line whose kingpin stands `OFFSET` half-
lengths from its middle. Its torque differs from that of the rectangle by at most 2.5 % of full slide
for widths and scrub radii of cars.
"""

from dataclasses import dataclass, replace
from functools import cache
from math import hypot

import numpy as np
from numpy.typing import NDArray

from symbolic.deformation import full_slide_arm, unit_moment
from symbolic.parameters import Rig, Tolerances, Tyre
from symbolic.vehicle.steering import jacking_stiffness, lock_angle
from symbolic.vehicle.vehicle import Vehicle

Array = NDArray[np.float64]
OFFSET = 0.9
"""Caster of the line over its half-length [1]."""
ASYMMETRY = 0.2
"""Share of the gear's friction by which it may differ by direction, either way [1]."""
UNEVEN = 0.05
"""Share of the load by which left and right may differ [1]."""
JACKING = 0.15
"""Share of the jacking that its tolerance leaves unknown [1]."""


@dataclass(frozen=True)
class Contact:
    """The contact of one tyre and its kingpin: half-length, half-width, trail, scrub radius [m]."""

    a: float
    b: float
    e: float
    r_s: float

    @classmethod
    def of(cls, vehicle: Vehicle, *, brakes: bool) -> "Contact":
        """That of a vehicle whose wheels are held by the brakes, or roll about the kingpin."""
        return cls(vehicle.a, vehicle.width / 2, vehicle.trail, vehicle.scrub_radius if brakes else 0.0)


def rig_of(vehicle: Vehicle, *, brakes: bool | None = None) -> tuple[Rig, Tyre]:
    """The wheel that stands for both, with the tolerances that those of the vehicle make.

    Args:
        vehicle: the vehicle.
        brakes: whether the wheels are held; None for what the vehicle says.
    """
    held = vehicle.brakes if brakes is None else brakes
    contact, tolerances = Contact.of(vehicle, brakes=held), vehicle.tolerances
    arm, stiffness = slide_arm(contact), sticking_stiffness(contact)
    a = arm / full_slide_arm(1.0, OFFSET)
    k = vehicle.k * stiffness * softening(contact) / unit_moment(0.0, a, OFFSET * a)
    by_arm, by_stiffness = (_spread(of, contact, tolerances) for of in (slide_arm, sticking_stiffness))
    # The lever turns force into torque, and way into angle, so that it counts twice for the stiffness.
    torque = hypot(tolerances.load, by_arm, tolerances.geometry, vehicle.gear_load_share)
    k_share = hypot(tolerances.stiffness, by_stiffness, 2 * tolerances.geometry)
    lever = vehicle.steering_arm / 2
    of_gear = ASYMMETRY * vehicle.gear_friction
    of_body = (
        UNEVEN
        * vehicle.wheel_load
        * (abs(vehicle.scrub_radius) * vehicle.caster + abs(vehicle.trail) * vehicle.inclination)
    )
    rig = Rig(
        a=a,
        e=OFFSET * a,
        tolerances=Tolerances(
            a=0.0, e=0.0, load=min(torque, 0.99), k=k_share * k,
            zero=hypot(lever * hypot(vehicle.force_zero, of_gear), of_body),
        ),
        noise=lever * vehicle.force_noise,
        dry_friction=JACKING * abs(jacking_stiffness(vehicle)) * np.sin(lock_angle(vehicle)),
    )  # fmt: skip
    return rig, Tyre(k=k)


def slide_arm(contact: Contact) -> float:
    """Torque of full slide over mu and load [m]: the mean arm under the pressure."""
    pressure, arm = _bristles(contact)
    return float((pressure * arm).mean() / pressure.mean())


def sticking_stiffness(contact: Contact) -> float:
    """Torque over turn of the sticking contact, over k [m^3]."""
    a, b, e, r_s = contact.a, contact.b, contact.e, contact.r_s
    return 2 * a * ((a**2 + b**2) / 3 + e**2 + r_s**2)


@cache
def softening(contact: Contact) -> float:
    """Factor on the stiffness with which the line's virgin torque comes closest to the rectangle's."""
    turns = np.geomspace(0.05, 8.0, 120)
    own = _virgin(*_bristles(contact), turns)
    x = np.linspace(-1, 1, 4001)[1:-1]
    line = _virgin(1 - x**2, np.abs(x - OFFSET), np.geomspace(0.03, 16.0, 400))
    factors = np.linspace(0.8, 1.3, 101)
    reached = [np.interp(turns * f, np.geomspace(0.03, 16.0, 400), line) for f in factors]
    return float(factors[int(np.argmin([np.abs(one - own).max() for one in reached]))])


def _virgin(pressure: Array, arm: Array, turns: Array) -> Array:
    """Virgin torque over that of full slide; a sticking contact reaches it after a turn of 1."""
    turn = (pressure * arm).sum() / (arm**2).sum()
    slip = pressure / np.maximum(arm, 1e-9)
    return (
        np.array([(arm**2 * np.minimum(turn * u, slip)).sum() for u in turns]) / (pressure * arm).sum()
    )


@cache
def _bristles(contact: Contact) -> tuple[Array, Array]:
    """Pressure over that in the middle, and arm [m], of bristles spread evenly over the contact."""
    x, y = (((np.arange(n) + 0.5) / n * 2 - 1) for n in (120, 60))
    along, across = np.meshgrid(x, y, indexing="ij")
    arm = np.hypot(contact.a * along + contact.e, contact.b * across + contact.r_s)
    return (1 - along**2).ravel(), arm.ravel()


def _spread(of, contact: Contact, tolerances) -> float:  # type: ignore[no-untyped-def]
    """Tolerance of a quantity of the contact as a share of it [1]."""
    shares = {"a": tolerances.half_length, "b": tolerances.geometry, "e": 0.0, "r_s": 0.0}
    step = 1e-3
    parts = []
    for name, share in shares.items():
        value = getattr(contact, name)
        up, down = (of(replace(contact, **{name: value * (1 + s)})) for s in (step, -step))
        parts.append(share * (up - down) / (2 * step))
    # Trail and scrub radius are known to so many metres, as the kingpin's point on the ground is.
    for name in ("e", "r_s"):
        value = getattr(contact, name)
        up, down = (of(replace(contact, **{name: value + s})) for s in (1e-4, -1e-4))
        parts.append(tolerances.geometry * contact.a * (up - down) / 2e-4)
    return float(np.linalg.norm(parts) / of(contact))
