"""Effects that the rig plants and no library has; a diagnosis has to report them as unexplained.

A function of its parameters each, which are neutral by default.
"""

from dataclasses import replace
from math import exp, log1p

import numpy as np

from reference_rig.hooks import Array, PlantedEffect, RigDrive, RigHistory, by_name


def play(gap: float = 0.0) -> PlantedEffect:
    """Play before a tyre that dry friction holds, `gap` [rad] from flank to flank."""

    def drive(at_sensor: RigDrive) -> RigDrive:
        if gap == 0:
            return at_sensor
        psi = _play_operator(at_sensor.psi, gap / 2, float(at_sensor.psi[0]))
        driven = np.diff(psi, prepend=psi[0]) != 0
        return replace(at_sensor, psi=psi, psi_dot=np.where(driven, at_sensor.psi_dot, 0.0))

    return PlantedEffect(drive=drive)


def slide_oscillation(amplitude: float = 0.0, frequency: float = 5.0) -> PlantedEffect:
    """The torque swings with `amplitude` [N m] and `frequency` [Hz] while the patch slides."""

    def torque(history: RigHistory) -> Array:
        # The swing fades in as most bristles let go.
        swell = np.clip((history.sliding - 0.4) / 0.4, 0, 1)
        return history.M_z + amplitude * swell * np.sin(2 * np.pi * frequency * history.drive.t)

    return PlantedEffect(torque=torque)


def gust(level: float = 0.0, time: float = 0.6, seed: int = 0) -> PlantedEffect:
    """Slow random disturbance of the torque's load cell: `level` [N m] rms, `time` [s] long."""

    def torque(history: RigHistory) -> Array:
        if level == 0:
            return history.M_z
        # White noise twice smoothed over `time`, brought to the level.
        t = history.drive.t
        knots = np.arange(t[0] - 8 * time, t[-1] + 8 * time, time / 4)
        noise = np.random.default_rng(seed).standard_normal(len(knots))
        window = np.hanning(9)
        slow = np.interp(t, knots, np.convolve(noise, window / window.sum(), mode="same"))
        return history.M_z + level * slow / np.sqrt(np.mean(slow**2))

    return PlantedEffect(torque=torque)


def free_branch(stiffness: float = 0.0, time: float = 0.5) -> PlantedEffect:
    """A Maxwell branch beside the whole patch: its torque relaxes, and friction does not bound it.

    Its spring has a stiffness [N m/rad], and its torque falls to 1/e in a time [s].
    """

    def torque(history: RigHistory) -> Array:
        # The patch turns at an even rate between samples.
        t, psi = history.drive.t, history.psi_patch
        twist = np.zeros_like(psi)
        for i in range(1, len(psi)):
            fade = exp(-(t[i] - t[i - 1]) / time)
            share = time * (1 - fade) / (t[i] - t[i - 1])
            twist[i] = fade * twist[i - 1] + share * (psi[i] - psi[i - 1])
        return history.M_z - stiffness * twist

    return PlantedEffect(torque=torque)


def encoder_eccentricity(
    amplitude: float = 0.0, cycles: float = 8.0, phase: float = 0.0
) -> PlantedEffect:
    """An encoder off its axis reads psi where the wheel is at psi + A sin(n psi + phi).

    A and phi are in rad; n is how often the geared encoder turns in a turn of the wheel.
    """

    def error(psi: Array | float) -> Array:
        return amplitude * np.sin(cycles * psi + phase)

    def drive(at_sensor: RigDrive) -> RigDrive:
        stretched = 1 + amplitude * cycles * np.cos(cycles * at_sensor.psi + phase)
        return replace(
            at_sensor,
            psi=at_sensor.psi + error(at_sensor.psi),
            psi_dot=at_sensor.psi_dot * stretched,
            psi_virgin=at_sensor.psi_virgin + float(error(at_sensor.psi_virgin)),
        )

    return PlantedEffect(drive=drive)


def sensor_hysteresis(height: float = 0.0) -> PlantedEffect:
    """The torque channel follows the torque as a play operator does, `height` [N m] behind it."""
    return PlantedEffect(torque=lambda history: _play_operator(history.M_z, height, 0.0), in_sensor=True)


def contact_ageing(gain: float = 0.0) -> PlantedEffect:
    """Limit times 1 + gain ln(1 + age/1 s): contacts that rest grow, those that slide are new.

    The age is that of rate-and-state friction (Dieterich 1979, Ruina 1983), for the patch as a whole.
    """
    return PlantedEffect(friction=lambda step: 1 + gain * log1p(step.age))


def _play_operator(signal: Array, half_gap: float, start: float) -> Array:
    """What follows a signal no farther than half a gap behind, from a start on."""
    follower, followed = np.empty_like(signal), start
    for i, value in enumerate(signal):
        followed = min(max(followed, value - half_gap), value + half_gap)
        follower[i] = followed
    return follower


UNMODELLED_EFFECTS = by_name(
    play, slide_oscillation, gust, free_branch, encoder_eccentricity, sensor_hysteresis,
    contact_ageing,
)  # fmt: skip
