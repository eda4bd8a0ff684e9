"""A simple car for tests, of its own code: bristles on two wheels, dry friction in the gear."""

import tomllib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbolic import Vehicle, vehicle_from_tables

Array = NDArray[np.float64]
DT = 0.01
BOTH_WAYS = (3.0, 1.2, 1.2, 3.0, 1.2)
"""Speeds of the handwheel, first to the left [rad/s]: slowly and quickly to either side."""
STEP = 0.02
"""Of the bus [s]."""


@dataclass(frozen=True, kw_only=True)
class SimulatedCar:
    """Two equal wheels whose contacts turn about their middles, kingpins upright."""

    mu: tuple[float, float] = (0.5, 0.5)
    load: float = 4000.0
    half_length: float = 0.055
    half_width: float = 0.08
    k: float = 9e6
    arm: float = 0.125
    gear: float = 200.0
    presliding: float = 6e-5
    noise: float = 15.0

    def force(self, rack: Array) -> Array:
        """Force of the gear on the rack [N] along its way [m]."""
        x, y = np.meshgrid(*(((np.arange(n) + 0.5) / n * 2 - 1) for n in (40, 20)), indexing="ij")
        arm = np.hypot(self.half_length * x, self.half_width * y)
        area = 4 * self.half_length * self.half_width / x.size
        pressure = (1 - np.abs(x) ** 2.5) * (1 - y**8)
        pressure *= self.load / (pressure.sum() * area)
        stiffness = self.k / (2 * self.half_width)
        q, slip, before, forces = [np.zeros_like(arm) for _ in self.mu], 0.0, rack[0], []
        for s in rack:
            turn, way = (s - before) / self.arm, s - before
            side = 1.0 if way >= 0 else -1.0
            slip = side - (side - slip) * np.exp(-abs(way) / self.presliding)
            limits = [mu * pressure / stiffness for mu in self.mu]
            q = [np.clip(one - arm * turn, -most, most) for one, most in zip(q, limits, strict=True)]
            M = sum(float((stiffness * one * arm).sum() * area) for one in q)
            forces.append(-M / self.arm + self.gear * slip)
            before = s
        noise = self.noise * np.random.default_rng(4).standard_normal(rack.size)
        return np.array(forces) + noise


def vehicle_text(**more: object) -> str:
    """The vehicle file of `SimulatedCar` as it is by default."""
    values = {
        "front_axle_load": 8000.0, "tyre": '"205/55 R16"', "pressure": 2.4e5, "wheelbase": 2.6,
        "track": 1.5, "steering_arm": 0.125, "half_length": 0.055, "contact_width": 0.16,
        "stiffness": 9e6, "trail": 0.0, "scrub_radius": 0.0, "inclination": 0.0, "caster": 0.0,
        "lever_loss": 0.0, "damping": 0.0,
    } | more  # fmt: skip
    return "[vehicle]\n" + "".join(f"{name} = {value}\n" for name, value in values.items())


def declared_vehicle(**more: object) -> Vehicle:
    """The vehicle that `vehicle_text` declares."""
    return vehicle_from_tables(tomllib.loads(vehicle_text(**more)))


def steering(seconds: float = 14.0, reach: float = 0.06) -> tuple[Array, Array]:
    """Time [s] and way of the rack [m]: to one side, back, to both locks."""
    t = np.arange(0, seconds, DT)
    ends = np.array([0, 0, 0.5, 0.3, -1.0, -0.7, 1.0, 0.8]) * reach
    at = np.array([0, 0.04, 0.2, 0.28, 0.55, 0.62, 0.95, 1.0]) * seconds
    return t, np.interp(t, at, ends)


def drive(lock: float, speeds: tuple[float, ...], step: float) -> Array:
    """From the middle to both locks, twice, and back to the middle; every corner is round."""
    ends = np.array([0.0, 0.0, lock, -lock, lock, -lock, 0.0])
    times = np.cumsum([0.0, 0.6, *np.abs(np.diff(ends[1:])) / speeds])
    path = np.interp(np.arange(0.0, times[-1] + 0.3, step), times, ends)
    width = round(0.15 / step)
    return np.convolve(np.pad(path, width, mode="edge"), np.ones(width) / width, "valid")


def on_plates(
    *, mu: float = 0.0, speeds: tuple[float, ...] = BOTH_WAYS, reach: float = 0.07, drift: float = 0.0
) -> tuple[Array, Array, Array]:
    """Time [s], way [m] and force of the rack [N]: 200 N of friction, 3000 N s/m, a zero of 20 N."""
    rack = 0.0075 * drive(reach / 0.0075, speeds, STEP)
    rate = np.gradient(rack, STEP)
    if mu:
        force = SimulatedCar(mu=(mu, mu)).force(rack)
    else:
        noise = 15.0 * np.random.default_rng(3).standard_normal(rack.size)
        force = 200.0 * np.tanh(rate / 1e-4) + noise
    t = STEP * np.arange(rack.size)
    return t, rack, force + 3000 * rate + 20.0 + drift * np.sin(t)
