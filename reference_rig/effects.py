"""The effects that the rig plants and the library has too: a function of its parameters each.

Every parameter has its neutral value by default.
"""

from dataclasses import replace
from math import exp, inf

import numpy as np

from reference_rig.hooks import Array, BristleStep, MaxwellBranch, PlantedEffect, RigHistory, by_name
from reference_rig.patch import REFERENCE_SPEED, REST_SPEED

MIN_RATE_FACTOR = 0.05
REFERENCE_LOAD = 400.0
BEARING_RATE = 0.01


def rate_friction(c: float = 0.0) -> PlantedEffect:
    """Limit times 1 + c ln(sqrt(v² + v_0²)/v_ref)."""

    def friction(step: BristleStep) -> Array:
        regular = np.sqrt(step.speed**2 + REST_SPEED**2)
        return np.maximum(MIN_RATE_FACTOR, 1 + c * np.log(regular / REFERENCE_SPEED))

    return PlantedEffect(friction=friction)


def speed_law(slow: float = 0.0, middle: float = 0.0, fast: float = 0.0) -> PlantedEffect:
    """Limit times 1 + its slopes over ln v, added up: below 2 mm/s, to 6 mm/s, above."""

    def level(speed: Array) -> Array:
        v2 = np.square(speed)
        rest, first, second = (0.5 * np.log(v2 + knot**2) for knot in (REST_SPEED, 2e-3, 6e-3))
        return slow * (rest - first) + middle * (first - second) + fast * second

    def friction(step: BristleStep) -> Array:
        growth = level(step.speed) - level(np.array(REFERENCE_SPEED))
        return np.maximum(MIN_RATE_FACTOR, 1 + growth)

    return PlantedEffect(friction=friction)


def frictional_creep(c: float = 0.0) -> PlantedEffect:
    """Limit times 1 + c ln(v/v_ref), v the bristle's own speed."""
    return PlantedEffect(rate=c)


def stribeck(ratio: float = 1.0, v_s: float = 3e-3) -> PlantedEffect:
    """Limit times 1 + (ratio - 1) exp(-v/v_s)."""
    return PlantedEffect(friction=lambda step: 1 + (ratio - 1) * np.exp(-step.speed / v_s))


def carcass_torsion(k_t: float = inf) -> PlantedEffect:
    """The patch is turned by psi + M_z/k_t, k_t in N m/rad."""
    return PlantedEffect(compliance=1 / k_t)


def contact_length(n: float = 0.0, F_0: float = 400.0, m: float = 2.0) -> PlantedEffect:
    """The half-length is a (F_N / (F_0 (a / 45 mm)^m))^n, F_0 in N."""
    return PlantedEffect(
        span=1.6 if n else 1.0, growth=lambda F_N, a: (F_N / (F_0 * (a / 0.045) ** m)) ** n
    )


def patch_width(half_width: float = 0.0) -> PlantedEffect:
    """Bristles fill |y| <= half_width [m]."""
    return PlantedEffect(half_width=half_width)


def pressure_shape(exponent: float = 2.0) -> PlantedEffect:
    """Pressure ~ 1 - |x/a|^exponent with the load unchanged."""

    def pressure(xi: Array) -> Array:
        shape = (exponent + 1) / (2 * exponent) * (1 - np.abs(xi) ** exponent)
        return shape / (0.75 * (1 - xi**2))

    return PlantedEffect(pressure=pressure)


def pressure_skew(skew: float = 0.0) -> PlantedEffect:
    """Pressure times 1 + skew x/a."""
    return PlantedEffect(pressure=lambda xi: 1 + skew * xi)


def viscoelastic_relaxation(gain: float = 0.0, time: float = 0.5) -> PlantedEffect:
    """Maxwell branch of stiffness gain k and relaxation time [s]."""
    return PlantedEffect(relaxation=MaxwellBranch(gain=gain, time=time))


def contact_damping(c: float = 0.0) -> PlantedEffect:
    """M_z -= c psi_dot, c in N m s/rad."""
    return PlantedEffect(torque=lambda history: history.M_z - c * history.drive.psi_dot)


def bearing_friction(M_c: float = 0.0) -> PlantedEffect:
    """M_z -= M_c tanh(psi_dot/omega_0), M_c in N m."""
    return PlantedEffect(
        torque=lambda history: history.M_z - M_c * np.tanh(history.drive.psi_dot / BEARING_RATE)
    )


def steering_return(stiffness: float = 0.0) -> PlantedEffect:
    """M_z -= stiffness psi, stiffness in N m/rad."""
    return PlantedEffect(torque=lambda history: history.M_z - stiffness * history.drive.psi)


def torque_offset(M_0: float = 0.0) -> PlantedEffect:
    """M_z += M_0 [N m]."""
    return PlantedEffect(torque=lambda history: history.M_z + M_0)


def zero_drift(rate: float = 0.0) -> PlantedEffect:
    """M_z += rate times the time since the first sample, rate in N m/s."""

    def torque(history: RigHistory) -> Array:
        t = history.drive.t
        return history.M_z + rate * (t - t[0])

    return PlantedEffect(torque=torque, in_sensor=True)


def sensor_delay(delay: float = 0.0) -> PlantedEffect:
    """The torque channel shows the torque of `delay` [s] ago; at first, that of the first sample."""

    def torque(history: RigHistory) -> Array:
        t = history.drive.t
        return np.interp(t - delay, t, history.M_z)

    return PlantedEffect(torque=torque, in_sensor=True)


def pretwist(psi_0: float = 0.0) -> PlantedEffect:
    """A virgin patch was turned by psi_0 [rad] before the first sample."""
    return PlantedEffect(drive=lambda drive: replace(drive, psi_virgin=drive.psi_virgin - psi_0))


def tared_pretwist(psi_0: float = 0.0, M_0: float = 0.0) -> PlantedEffect:  # noqa: ARG001
    """As `pretwist`, but the torque channel was set to zero at the first sample, whatever that took."""
    return replace(pretwist(psi_0), torque=lambda history: history.M_z - history.M_z[0], in_sensor=True)


def load_dependent_friction(n: float = 0.0) -> PlantedEffect:
    """Limit times (F_N/F_ref)^(-n)."""
    return PlantedEffect(friction=lambda step: (step.F_N / REFERENCE_LOAD) ** -n)


def asymmetric_friction(ratio: float = 1.0) -> PlantedEffect:
    """Limit times ratio while psi_dot > 0."""
    return PlantedEffect(friction=lambda step: ratio if step.psi_dot > 0 else 1.0)


def friction_drift(gain: float = 0.0, scale: float = 0.5) -> PlantedEffect:
    """Limit times 1 + gain (1 - exp(-s/scale)), s the angle turned so far, scale in rad."""
    return PlantedEffect(friction=lambda step: 1 + gain * (1 - exp(-step.travel / scale)))


def backlash(gap: float = 0.0) -> PlantedEffect:
    """A gap [rad], from flank to flank, that is crossed at no torque; flanks are hard."""
    return PlantedEffect(lost_motion=gap)


LIBRARY_EFFECTS = by_name(
    rate_friction, speed_law, frictional_creep, stribeck, carcass_torsion, contact_length,
    patch_width, pressure_shape, viscoelastic_relaxation, contact_damping, sensor_delay,
    torque_offset, pretwist, tared_pretwist, zero_drift,
    load_dependent_friction, asymmetric_friction, friction_drift, pressure_skew, bearing_friction,
    steering_return, backlash,
)  # fmt: skip
