r"""The mean wheel of both front wheels: the declared patch of the same torque.

Both wheels turn by nearly the mean angle psi, so that the axle's torque by virtual work, referred to
psi, is twice that of one wheel; what their angles differ by changes it to second order. A bristle at
(x, y) from the middle of the contact moves on a circle about the kingpin's point on the ground. It is a
scalar stop with the arm

    l = sqrt((x + e)^2 + (y + r_s)^2)      brakes on,
    l = sqrt((x + e)^2 + y^2)              brakes off: the wheel rolls by r_s psi,

and slips at the turn mu p(x, y) / (c l), p the pressure of `symbolic.vehicle.contact_about_kingpin`, and
c = k / width. So contact and kingpin matter by the distribution of these turns alone, and the line of
the declared model has nearly the same one for a half-length, a caster and a stiffness of its own: the
same torque of full slide, F_N mean(l), and a line whose kingpin stands `OFFSET` half-lengths from its
middle. Its torque differs from that of the contact by at most 1 % of full slide
for widths and scrub radii of cars.
"""

from dataclasses import replace
from functools import cache
from math import hypot

import numpy as np

from symbolic.float_array_type import Array
from symbolic.patch_interface import Expression
from symbolic.patch_moment_by_zones import full_slide_arm, unit_corner_moment
from symbolic.rig_and_tyre import EVEN, Rig, Tolerances, Tyre
from symbolic.vehicle.contact_about_kingpin import (
    Contact,
    contact_growth_at_full_lock,
    kingpin_axis,
    pressures_and_arms,
)
from symbolic.vehicle.steering import (
    inverse_lever_growth,
    jacking_torque,
    lock_angle,
    mean_wheel_angle,
    rack_lever,
    sine_and_cosine,
)
from symbolic.vehicle.vehicle import STD_PER_TOLERANCE, Vehicle, VehicleTolerances

OFFSET = 0.7
"""Caster of the line over its half-length [1]."""
COMPLIANCE = 0.9
"""Stiffness with rods, joints and suspension in series over that of the tyre alone [1]."""
COMPLIANCE_SPREAD = 0.1
"""Standard deviation of it as a share of it [1]: 0.10 over 51 simulated cars that were as declared."""
ASYMMETRY = 0.2
"""Share of the gear's friction by which it may differ by direction, either way [1]."""
WHEEL_INERTIA = 1.0
"""Of one wheel about its kingpin [kg m^2]."""
UNEVEN = 0.05
"""Share of the load by which left and right may differ [1]."""


def rig_of(vehicle: Vehicle, *, brakes: bool | None = None) -> tuple[Rig, Tyre]:
    """The mean wheel, with the tolerances that follow from those of the vehicle.

    Args:
        vehicle: the vehicle.
        brakes: whether the wheels are held; None for what the vehicle says.
    """
    held = vehicle.brakes if brakes is None else brakes
    contact, tolerances = Contact.from_vehicle(vehicle, brakes=held), vehicle.tolerances
    upright = float(kingpin_axis(vehicle)[2])
    arm, stiffness = upright * contact.slide_arm, upright**2 * contact.stiffness
    calibrated = vehicle.slide_factor is not None
    arm *= vehicle.slide_factor or 1.0
    a = arm / full_slide_arm(1.0, OFFSET)
    k = COMPLIANCE * vehicle.k * stiffness * equivalent_stiffness_factor(contact)
    k /= unit_corner_moment(0.0, a, OFFSET * a)
    # The lever turns force into torque, and way into angle, so that it counts twice for the stiffness.
    by_contact = hypot(
        *_errors_by_dimension("stiffness", contact, tolerances).values(), 2 * tolerances.geometry
    )
    # Under another load than that at which it was measured, k may be as it was, or go with 1/load.
    beside = vehicle.load_change_since_slide if calibrated else by_contact
    k_share = hypot(tolerances.stiffness, beside)
    # A stiffness that was measured has rods and suspension in it.
    k_std = hypot(STD_PER_TOLERANCE * k_share, 0.0 if calibrated else COMPLIANCE_SPREAD)
    uncertain = mu_std_by_cause(vehicle, brakes=held)
    load = uncertain.pop("front_axle_load")
    half_lever = vehicle.steering_arm / 2
    of_gear = ASYMMETRY * vehicle.gear_friction
    arm_of_body = abs(vehicle.scrub_radius) * vehicle.caster + abs(vehicle.trail) * vehicle.inclination
    of_body = UNEVEN * vehicle.wheel_load * arm_of_body
    rig = Rig(
        a=a, e=OFFSET * a,
        tolerances=Tolerances(
            a=0.0, e=0.0, load=min(load / EVEN, 0.99), scale=hypot(*uncertain.values()) / EVEN,
            k=k_std / EVEN * k,
            zero=hypot(half_lever * hypot(vehicle.force_zero, of_gear), of_body),
        ),
        noise=half_lever * vehicle.force_noise, dry_friction=0.0,
    )  # fmt: skip
    return rig, Tyre(k=k)


def mu_std_by_cause(vehicle: Vehicle, *, brakes: bool) -> dict[str, float]:
    """What declared values leave of mu, as standard deviations [1], by their keys in the vehicle file.

    Full slide measures mu times load, arm of the contact and one over the lever, by a force that has a
    scale. Where the half-length follows from the load, an error of the load is in the arm too. A
    measured `slide_factor` has the errors of all of them in it; a load that has changed since has
    changed the half-length.
    """
    contact, tolerances = Contact.from_vehicle(vehicle, brakes=brakes), vehicle.tolerances
    arm = _errors_by_dimension("slide_arm", contact, tolerances)
    of_length = arm.pop("a")
    load, calibrated = tolerances.load, vehicle.slide_factor is not None
    if vehicle.half_length is None or calibrated:
        as_load = replace(tolerances, half_length=load)
        load += _errors_by_dimension("slide_arm", contact, as_load)["a"]
    shares = {"front_axle_load": load}
    if calibrated:
        shares["slide_factor"] = tolerances.slide_factor
    else:
        shares |= {
            "half_length": abs(of_length),
            "geometry": hypot(*arm.values(), tolerances.geometry),
            "gear_load_share": vehicle.gear_load_share,
            "force_scale": tolerances.force_scale,
        }
    return {name: STD_PER_TOLERANCE * share for name, share in shares.items()}


@cache
def equivalent_stiffness_factor(contact: Contact) -> float:
    """Factor on the stiffness with which the line's virgin torque comes closest to the contact's."""
    turns = np.geomspace(0.05, 8.0, 120)
    own = _relative_virgin_torque(*pressures_and_arms(contact), turns)
    x = np.linspace(-1, 1, 4001)[1:-1]
    line = _relative_virgin_torque(1 - x**2, np.abs(x - OFFSET), np.geomspace(0.03, 16.0, 400))
    factors = np.linspace(0.8, 1.3, 101)
    reached = [np.interp(turns * f, np.geomspace(0.03, 16.0, 400), line) for f in factors]
    return float(factors[int(np.argmin([np.abs(one - own).max() for one in reached]))])


def _relative_virgin_torque(pressure: Array, arm: Array, turns: Array) -> Array:
    """Virgin torque over full-slide torque; a sticking contact would reach it after a turn of 1."""
    turn = (pressure * arm).sum() / (arm**2).sum()
    slip = pressure / np.maximum(arm, 1e-9)
    torques = [float((arm**2 * np.minimum(turn * u, slip)).sum()) for u in turns]
    return np.array(torques) / float((pressure * arm).sum())


def _errors_by_dimension(
    quantity: str, contact: Contact, tolerances: VehicleTolerances
) -> dict[str, float]:
    """Tolerance of a quantity of the contact as a share of it [1], by what of the contact makes it."""
    spans = {
        "a": tolerances.half_length * contact.a,
        "b": tolerances.geometry * contact.b,
        # Known to a share of the half-length, and to itself, see `contact_about_kingpin`.
        "e": hypot(contact.e, tolerances.geometry * contact.a),
        "r_s": tolerances.geometry * contact.a,
    }
    step, parts, whole = 1e-4, {}, float(getattr(contact, quantity))
    for name, span in spans.items():
        near = (replace(contact, **{name: getattr(contact, name) + s}) for s in (step, -step))
        up, down = (getattr(each, quantity) for each in near)
        parts[name] = float(span * (up - down) / (2 * step * whole))
    return parts


def equivalent_contact_angle(vehicle: Vehicle, psi: Expression, *, brakes: bool) -> Expression:
    """Angle of the mean wheel's contact straight ahead [rad], see `contact_about_kingpin`."""
    growth = contact_growth_at_full_lock(vehicle, brakes=brakes)
    sine, cosine = sine_and_cosine(psi)
    return psi + (growth.stiffness - growth.torque) * (psi - sine * cosine) / 2


def aligning_torque_with_friction(
    vehicle: Vehicle, s: Expression, force: Expression, speed: Expression = 0.0,
    acceleration: Expression = 0.0, *, brakes: bool,
) -> Expression:  # fmt: skip
    """M_z of the mean wheel [N m], the gear's dry friction in it.

    By way [m], speed [m/s] and acceleration [m/s^2] of the rack and the force F_R on it [N]; brakes hold
    the wheels or not.
    """
    psi, r = mean_wheel_angle(vehicle, s), rack_lever(vehicle, s)
    returned, sine = jacking_torque(vehicle, psi), sine_and_cosine(psi)[0]
    inert = (r / 2 * vehicle.moved_mass + WHEEL_INERTIA / r) * acceleration
    M_z = inert + vehicle.damping / r * speed - r / 2 * force + returned
    return M_z / (1 + contact_growth_at_full_lock(vehicle, brakes=brakes).torque * sine**2)


def wheel_from_rack(
    vehicle: Vehicle, s: Expression, force: Expression, speed: Expression, acceleration: Expression, *,
    brakes: bool,
) -> tuple[Expression, Expression]:  # fmt: skip
    """Angle straight ahead [rad] and M_z [N m] of the mean wheel, as of `aligning_torque_with_friction`.

    Inertia counts where the mass that moves with the rack is declared.
    """
    if vehicle.moved_mass == 0:
        acceleration = 0.0
    psi = equivalent_contact_angle(vehicle, mean_wheel_angle(vehicle, s), brakes=brakes)
    moved = (s, force, speed, acceleration)
    return psi, aligning_torque_with_friction(vehicle, *moved, brakes=brakes)


def lever_and_contact_growth(vehicle: Vehicle, *, brakes: bool) -> float:
    """Growth of one over the gear's lever at full lock, torques divided as above [1]."""
    growth = (
        contact_growth_at_full_lock(vehicle, brakes=brakes).torque * np.sin(lock_angle(vehicle)) ** 2
    )
    return float((1 + inverse_lever_growth(vehicle)) * (1 + growth) - 1)
