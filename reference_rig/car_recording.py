"""Signals of a car's steering on its bus."""

from dataclasses import dataclass
from math import radians

import numpy as np

from reference_rig.car import Car
from reference_rig.car_motion import CarMotion
from reference_rig.hooks import Array
from reference_rig.sensors import jitter_instants, quantise, sample_instants


@dataclass(frozen=True, kw_only=True)
class CarBus:
    """Sensors and bus of a car."""

    period: float = 0.01  # Between two messages [s].
    jitter: float = 2e-3  # Largest delay of a message's time stamp behind its samples [s].
    handwheel_step: float = radians(0.1)  # [rad]
    handwheel_zero: float = 0.0  # Angle shown with the rack in the middle [rad].
    torque_step: float = 0.1  # Of the torsion bar's torque [N m].
    torque_noise: float = 0.03  # Standard deviation [N m].
    torque_zero: float = 0.0  # Torque shown without load [N m].
    motor_step: float = 0.01  # Of the motor's torque [N m].
    motor_gain: float = 1.0  # Torque shown over the true one [1].
    rack_step: float = 5e-5  # [m]
    force_step: float = 10.0  # Of the rack's force [N].
    force_noise: float = 10.0  # Standard deviation [N].
    force_zero: float = 0.0  # Force shown without load [N].
    window: float = 5e-3  # Over which forces and torques are averaged before they are sent [s].


@dataclass(frozen=True, kw_only=True, eq=False)
class CarRecording:
    """Channels of the bus, arrays of shape (n,), with the motion behind them.

    All are positive to the left. `handwheel` [rad], `rack` [m], `F_rack` [N], `T_bar`, `T_motor` and
    `T_hand` [N m], `speed` [m/s]; `brake` is 0 or 1.
    """

    name: str
    t: Array
    handwheel: Array
    rack: Array
    F_rack: Array
    T_bar: Array
    T_motor: Array
    T_hand: Array
    brake: Array
    speed: Array
    taken: Array  # Instants at which the samples were taken [s], which nobody sees.
    motion: CarMotion
    car: Car


def record_car(
    seed: int, car: Car, motion: CarMotion, *, bus: CarBus | None = None, brake: bool = True,
    name: str = "car",
) -> CarRecording:  # fmt: skip
    """Send a motion over the bus.

    Args:
        seed: of noise and jitter.
        car: the car that moved.
        motion: how it moved.
        bus: sensors and bus; None for the usual ones.
        brake: what the brake signal shows.
        name: of the recording.
    """
    bus = bus or CarBus()
    rng = np.random.default_rng([seed, 22])
    even = sample_instants(motion.t[-1] - bus.jitter, 1 / bus.period)
    t = jitter_instants(seed, even, spread=bus.jitter)
    taken = np.maximum(t - rng.uniform(0.0, bus.jitter, len(t)), 0.0)

    def shown(name: str, step: float, noise: float = 0.0, zero: float = 0.0, gain: float = 1.0) -> Array:
        signal = motion.channels[name]
        if noise:
            signal = _lately(motion.t, signal, bus.window)
        sample = np.interp(taken, motion.t, signal)
        return quantise(gain * sample + zero + noise * rng.standard_normal(len(t)), step)

    return CarRecording(
        name=name,
        t=t,
        handwheel=shown("handwheel", bus.handwheel_step, zero=bus.handwheel_zero),
        rack=shown("rack", bus.rack_step, zero=bus.handwheel_zero * car.pinion_radius),
        F_rack=shown("F_rack", bus.force_step, bus.force_noise, bus.force_zero),
        T_bar=shown("T_bar", bus.torque_step, bus.torque_noise, bus.torque_zero),
        T_motor=shown("T_motor", bus.motor_step, 1e-3, gain=bus.motor_gain),
        T_hand=shown("T_hand", bus.torque_step, bus.torque_noise, bus.torque_zero),
        brake=np.full(len(t), float(brake)),
        speed=np.zeros(len(t)),
        taken=taken,
        motion=motion,
        car=car,
    )


def _lately(t: Array, signal: Array, window: float) -> Array:
    """Mean of a signal over the time that has just passed."""
    width = max(round(window / (t[1] - t[0])), 1)
    total = np.cumsum(np.concatenate([np.zeros(1), np.full(width - 1, signal[0]), signal]))
    return (total[width:] - total[:-width]) / width
