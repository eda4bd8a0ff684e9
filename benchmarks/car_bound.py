"""The least standard deviation of a car's friction that any estimate can have: a Cramer-Rao bound.

The force on the rack by `symbolic.vehicle`, the bus's noise alone, and every declared value an unknown
with the variance of its tolerance, the bound of [van Trees 1968]. A real car differs from that model by
more than noise: an error of the model, a share of the tyres' force, may be added.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from observers import Tuning
from symbolic import Model, Vehicle, full_slide_arm, rig_of, simulate
from symbolic.array_alias import Array
from symbolic.parameters import EVEN
from symbolic.vehicle.mean_wheel import aligning_torque_with_friction, straight_ahead_angle
from symbolic.vehicle.steering import jacking_torque, lever, mean_angle

RELATIVE_STEP = 1e-3
"""Relative step of the derivatives [1]."""
VAGUE = 2.0
"""Standard deviation of ln mu before any force [1]."""
FORCE_ZERO = 30.0
"""Within which the zero of a car's force lies, either way [N]."""
BOUNDS = {
    "model exact": (0.0, 0.0),
    "model wrong by 2 %": (0.02, 0.0),
    "and the return torque by 8 %": (0.02, 0.08),
}
"""Cases of the least standard deviation that any estimate can have: errors of the model as a share of
the tyres' force, and of the return torque as a share of it, which otherwise weighs the car [1]."""
VEHICLE_FIELDS = {
    "front_axle_load": "axle_load", "half_length": "half_length", "contact_width": "half_width",
    "stiffness": "k", "gear_friction": "gear_friction", "gear_load_share": "gear_load_share",
    "steering_arm": "lever", "inclination": "inclination", "caster": "caster", "trail": "trail",
    "scrub_radius": "scrub_radius", "lever_loss": "lever_loss", "wheel_radius": "wheel_radius",
}  # fmt: skip
"""Fields of the vehicle that are unknowns of that deviation, and the names of their tolerances."""


def force_on_rack(vehicle: Vehicle, mu: float, rack: Array) -> Array:
    """F_R [N] along a way of the rack [m], from rest, the gear's bristles unstretched."""
    (rig, tyre), held = rig_of(vehicle), vehicle.brakes
    psi = straight_ahead_angle(vehicle, mean_angle(vehicle, rack), brakes=held)
    still = np.zeros_like(psi)
    signals = np.vstack([psi, still, still + vehicle.wheel_load, still + 0.01])
    theta = np.array(Model().theta({"mu": mu, "k": tyre.k})).ravel()
    M_z = simulate(Model(), signals, theta, np.array([rig.a, rig.e])).M_z
    none, one = (
        aligning_torque_with_friction(vehicle, rack, force, brakes=held) for force in (0.0, 1.0)
    )
    force, slip = (M_z - none) / (one - none), [0.0]
    for way in np.diff(rack):
        side = 1.0 if way >= 0 else -1.0
        slip.append(side - (side - slip[-1]) * float(np.exp(-abs(way) / vehicle.presliding)))
    dry = vehicle.gear_friction + vehicle.gear_load_share * np.abs(force)
    return np.asarray(force + dry * slip, dtype=float)


def least_deviations(
    vehicle: Vehicle, mu: float, rack: Array, tolerances: Mapping[str, float], ends: Sequence[int], *,
    noise: float, error: float = 0.0, returned: float = 0.0,
) -> list[float]:  # fmt: skip
    """Least standard deviations of ln mu [1] from the samples before each of the ends.

    The rack's way has the shape (n,) [m], tolerances are shares of the vehicle's fields, the noise is
    the white error of a sample's force [N]. An error of the model is a share of the tyres' force of full
    slide, independent after the turn `Tuning.error_travel`; `returned` is the share that the return
    torque is off by beside what the vehicle's angles and lengths make it off by, and 0 lets it weigh the
    car as well as those are known.
    """
    slopes, stds = [_slope(lambda factor: force_on_rack(vehicle, mu * factor, rack))], [VAGUE]
    for name, tolerance in tolerances.items():

        def force_with(factor: float, name: str = name) -> Array:
            changed = replace(vehicle, **{name: factor * getattr(vehicle, name)})
            return force_on_rack(changed, mu, rack)

        slopes.append(_slope(force_with))
        stds.append(EVEN * tolerance)
    # The sensor's zero, with what the gear's friction differs by direction.
    slopes.append(np.ones_like(rack))
    stds.append(EVEN * vehicle.force_zero)
    if returned:
        lifting = jacking_torque(vehicle, mean_angle(vehicle, rack)) / lever(vehicle, rack)
        slopes.append(2 * np.asarray(lifting))
        stds.append(returned)
    jacobian, prior = np.array(slopes).T, np.diag(np.array(stds) ** -2.0)
    rig, _ = rig_of(vehicle)
    slide = mu * vehicle.wheel_load * full_slide_arm(rig.a, rig.e) * 2 / vehicle.steering_arm
    turn = np.abs(np.diff(mean_angle(vehicle, rack), prepend=rack[0]))
    share = np.minimum(1, turn / Tuning().error_travel) if error else np.ones_like(rack)
    weight = share / (share * noise**2 + (error * slide) ** 2)
    weighed = jacobian * weight[:, None]
    informations = (prior + jacobian[:end].T @ weighed[:end] for end in ends)
    return [float(np.sqrt(np.linalg.inv(each)[0, 0])) for each in informations]


def _slope(of: Callable[[float], Array]) -> Array:
    """Derivative of a force by the logarithm of what is multiplied by a factor."""
    return (of(1 + RELATIVE_STEP) - of(1 - RELATIVE_STEP)) / (2 * RELATIVE_STEP)


def bounds_by_case(
    vehicle: Vehicle, mu: float, rack: Array, tolerances: Mapping[str, float], ends: Sequence[int],
    noise: float,
) -> Array:  # fmt: skip
    """`least_deviations` by `BOUNDS` and ends; arguments are those."""
    within = replace(vehicle, force_zero=FORCE_ZERO)
    return np.array(
        [
            least_deviations(
                within, mu, rack, tolerances, ends, noise=noise, error=error, returned=returned
            )
            for error, returned in BOUNDS.values()
        ]
    )
