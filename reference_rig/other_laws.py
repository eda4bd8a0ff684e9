"""Laws of mechanisms that the library knows by another formula; a diagnosis has to name the mechanism.

A function of its parameters each, which are neutral by default.
"""

from math import exp, log1p, tanh

import numpy as np
from scipy.signal import lfilter
from scipy.special import beta

from reference_rig.hooks import Array, PlantedEffect, RigHistory, by_name


def log1p_friction(c: float = 0.0, v_0: float = 1e-3) -> PlantedEffect:
    """Limit times 1 + c ln(1 + v/v_0): it has a value at rest."""
    return PlantedEffect(friction=lambda step: 1 + c * np.log1p(step.speed / v_0))


def power_friction(p: float = 0.0) -> PlantedEffect:
    """Limit times (v/(1 mm/s))^p, v not below 0.1 mm/s."""
    return PlantedEffect(friction=lambda step: (np.maximum(step.speed, 1e-4) / 1e-3) ** p)


def saturating_friction(gain: float = 0.0, v_0: float = 3e-3) -> PlantedEffect:
    """Limit times 1 + gain v/(v + v_0)."""
    return PlantedEffect(friction=lambda step: 1 + gain * step.speed / (step.speed + v_0))


def gaussian_stribeck(ratio: float = 1.0, v_s: float = 3e-3) -> PlantedEffect:
    """Limit times 1 + (ratio - 1) exp(-(v/v_s)²)."""
    return PlantedEffect(friction=lambda step: 1 + (ratio - 1) * np.exp(-((step.speed / v_s) ** 2)))


def hyperbolic_stribeck(ratio: float = 1.0, v_s: float = 3e-3) -> PlantedEffect:
    """Limit times 1 + (ratio - 1)/(1 + v/v_s)."""
    return PlantedEffect(friction=lambda step: 1 + (ratio - 1) / (1 + step.speed / v_s))


def logarithmic_drift(gain: float = 0.0, scale: float = 0.3) -> PlantedEffect:
    """Limit times 1 + gain ln(1 + s/scale), s the angle turned so far [rad]."""
    return PlantedEffect(friction=lambda step: 1 + gain * log1p(step.travel / scale))


def exponential_load(n: float = 0.0) -> PlantedEffect:
    """Limit times exp(-n (F_N/400 N - 1))."""
    return PlantedEffect(friction=lambda step: exp(-n * (step.F_N / 400.0 - 1)))


def smooth_asymmetry(gain: float = 0.0) -> PlantedEffect:
    """Limit times 1 + gain tanh(psi_dot/(0.05 rad/s))."""
    return PlantedEffect(friction=lambda step: 1 + gain * tanh(step.psi_dot / 0.05))


def pressure_power(power: float = 1.0) -> PlantedEffect:
    """Pressure ~ (1 - (x/a)²)^power with the load unchanged."""
    share = 4 / 3 / beta(0.5, power + 1)
    return PlantedEffect(pressure=lambda xi: share * (1 - xi**2) ** (power - 1))


def torque_lag(time: float = 0.0) -> PlantedEffect:
    """The torque channel follows by a first-order lag [s]."""

    def torque(history: RigHistory) -> Array:
        if time == 0:
            return history.M_z
        decay = exp(-float(np.diff(history.drive.t).mean()) / time)
        begin = [decay * history.M_z[0]]
        lagged: Array = lfilter([1 - decay], [1.0, -decay], history.M_z, zi=begin)[0]
        return lagged

    return PlantedEffect(torque=torque, in_sensor=True)


def quadratic_damping(c: float = 0.0) -> PlantedEffect:
    """M_z -= c psi_dot |psi_dot|, c in N m s²/rad²."""

    def torque(history: RigHistory) -> Array:
        return history.M_z - c * history.drive.psi_dot * np.abs(history.drive.psi_dot)

    return PlantedEffect(torque=torque)


def hardening_return(stiffness: float = 0.0) -> PlantedEffect:
    """M_z -= stiffness psi (1 + (psi/(0.3 rad))²), stiffness in N m/rad."""

    def torque(history: RigHistory) -> Array:
        psi = history.drive.psi
        return history.M_z - stiffness * psi * (1 + (psi / 0.3) ** 2)

    return PlantedEffect(torque=torque)


OTHER_LAWS = by_name(
    log1p_friction, power_friction, saturating_friction, gaussian_stribeck, hyperbolic_stribeck,
    logarithmic_drift, exponential_load, smooth_asymmetry, pressure_power, torque_lag,
    quadratic_damping, hardening_return,
)  # fmt: skip
MECHANISMS: dict[str, str] = {
    **dict.fromkeys(list(OTHER_LAWS)[:5], "friction over speed"),
    "logarithmic_drift": "friction over time",
    "exponential_load": "friction over load",
    "smooth_asymmetry": "friction over direction",
    "pressure_power": "compliance and contact shape",
    **dict.fromkeys(list(OTHER_LAWS)[9:], "sensor and steering"),
}
"""The family of the library's effects that each of them belongs to."""
