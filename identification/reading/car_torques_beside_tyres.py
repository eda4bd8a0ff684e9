r"""Torques that a vehicle file declares beside the tyres': gear, return torque, damping, growth.

Each is a torque C(t) of the mean wheel [N m] that is as declared at a share of 1 and known to a
tolerance of it. A recording that is fitted has all of them as declared taken off, so that a fit adds

    sum_j (share_j - 1) C_j(t)

with every share a parameter of the recording, as a zero is. The gear's friction turns over by its
presliding [Dahl 1968] along the angle; the others are those of `symbolic.vehicle.steering`.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from identification.reading.car_as_mean_wheel import Standstills
from identification.reading.recordings import Recording
from identification.reading.trimming_and_thinning import recording_at_samples
from symbolic.float_array_type import Array
from symbolic.rig_and_tyre import EVEN
from symbolic.vehicle.contact_about_kingpin import contact_growth_at_full_lock
from symbolic.vehicle.mean_wheel import lever_and_contact_growth, rig_of
from symbolic.vehicle.steering import jacking_torque, lock_angle

JACKING, GROWTH = 0.08, 0.5
"""Standard deviation of the return torque and of the torque's growth towards the locks as shares of
them [1]: angles of the kingpin within 1 deg, and the nose that gives way."""
SHARES = {
    "gear_share": "the gear's dry friction over that declared",
    "return_share": "the return torque of the kingpins over that declared",
    "damping_share": "damping of joints and gear over that declared",
    "growth_share": "growth of the wheels' torque towards the locks over that by the declared kingpin",
}
"""What each share of `declared_vehicle_torques` is."""
SLACK = 2e-4
"""Play of the angle's noise, either way [rad]."""


class TorqueWithTolerance(NamedTuple):
    """A torque as declared, shape (n,) [N m], and its tolerance as a share of it [1]."""

    torque: Array
    tolerance: float


def declared_vehicle_torques(recording: Recording) -> Mapping[str, TorqueWithTolerance]:
    """Declared torques of a recording's vehicle, by name of the share; empty for a wheel on a rig."""
    if (car := recording.standstills) is None:
        return {}
    vehicle, psi, tolerances = car.vehicle, recording.psi, car.vehicle.tolerances
    growth = contact_growth_at_full_lock(vehicle, brakes=car.brakes[0]).torque * np.sin(psi) ** 2
    measured = np.nan_to_num(recording.M_z)
    declared = {
        "gear_share": (_declared_gear_friction_torque(recording, car), tolerances.gear_friction),
        "return_share": (-jacking_torque(vehicle, psi) / (1 + growth), JACKING / EVEN),
        "damping_share": (-vehicle.damping * recording.psi_dot, tolerances.damping),
        "growth_share": (growth * measured, GROWTH / EVEN),
    }
    return {n: TorqueWithTolerance(c, tol) for n, (c, tol) in declared.items() if tol > 0 and np.any(c)}


def widest_standstill_less_gear(recording: Recording) -> tuple[Recording, str]:
    """The standstill of a car in which it was steered farthest, its gear's declared friction taken off.

    A note tells where it has others; a wheel on a rig stays as it is.
    """
    if (car := recording.standstills) is None:
        return recording, ""
    numbers = np.unique(car.stretch[car.stretch >= 0])
    number = max(numbers, key=lambda n: float(np.ptp(recording.psi[car.stretch == n])))
    rig, tyre = rig_of(car.vehicle, brakes=(brakes := car.brakes[number]))
    alone = replace(car, brakes=(brakes,))
    own = replace(recording, rig=rig, tyre=tyre, standstills=alone)
    stood = recording_at_samples(own, np.flatnonzero(car.stretch == number))
    note = (
        f"{recording.name}: of {numbers.size} standstills that from {stood.t[0]:.6g} to"
        f" {stood.t[-1]:.6g} s, in which it was steered farthest, is diagnosed"
    )
    return replace(stood, M_z=stood.M_z - _declared_gear_friction_torque(stood, alone)), note * (
        numbers.size > 1
    )


def _declared_gear_friction_torque(recording: Recording, car: Standstills) -> Array:
    """Torque of the gear's dry friction as declared [N m]."""
    vehicle, psi = car.vehicle, recording.psi
    presliding = vehicle.presliding / vehicle.steering_arm
    angle, slip, slips = float(psi[0]), 0.0, []
    for now in psi.tolist():
        before, angle = angle, max(now - SLACK, min(now + SLACK, angle))
        side = 1.0 if angle >= before else -1.0
        slip = side - (side - slip) * np.exp(-abs(angle - before) / presliding)
        slips.append(slip)
    at_lock = lever_and_contact_growth(vehicle, brakes=car.brakes[0]) / lock_angle(vehicle) ** 2
    level = vehicle.steering_arm / 2 * vehicle.gear_friction / (1 + at_lock * psi**2)
    level = level + vehicle.gear_load_share * np.abs(np.nan_to_num(recording.M_z))
    return np.asarray(-level * np.array(slips))
