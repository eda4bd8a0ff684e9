"""Effects that the rig plants and no library has; a diagnosis has to report them as unexplained."""

from dataclasses import dataclass, replace
from math import exp, log1p

import numpy as np

from reference_rig.hooks import Array, BristleStep, PlantedEffect, RigDrive, RigHistory


@dataclass(frozen=True, kw_only=True)
class PlantedPlay(PlantedEffect):
    """Play before a tyre that dry friction holds, `gap` [rad] from flank to flank."""

    gap: float = 0.0

    def drive(self, drive: RigDrive) -> RigDrive:
        """The tyre's angle follows the sensor's as a play operator does."""
        if self.gap == 0:
            return drive
        half = self.gap / 2
        psi = np.empty_like(drive.psi)
        tyre = float(drive.psi[0])
        for i, sensor in enumerate(drive.psi):
            tyre = min(max(tyre, sensor - half), sensor + half)
            psi[i] = tyre
        driven = np.diff(psi, prepend=psi[0]) != 0
        return replace(drive, psi=psi, psi_dot=np.where(driven, drive.psi_dot, 0.0))


@dataclass(frozen=True, kw_only=True)
class PlantedSlideOscillation(PlantedEffect):
    """The torque swings with `amplitude` [N m] and `frequency` [Hz] while the patch slides."""

    amplitude: float = 0.0
    frequency: float = 5.0

    def torque(self, history: RigHistory) -> Array:
        """The swing fades in as most bristles let go."""
        swell = np.clip((history.sliding - 0.4) / 0.4, 0, 1)
        swing = np.sin(2 * np.pi * self.frequency * history.drive.t)
        return history.M_z + self.amplitude * swell * swing


@dataclass(frozen=True, kw_only=True)
class PlantedGust(PlantedEffect):
    """Slow random disturbance of the torque's load cell: `level` [N m] rms, `time` [s] long."""

    level: float = 0.0
    time: float = 0.6
    seed: int = 0

    def torque(self, history: RigHistory) -> Array:
        """White noise twice smoothed over `time`, brought to the level."""
        if self.level == 0:
            return history.M_z
        t = history.drive.t
        knots = np.arange(t[0] - 8 * self.time, t[-1] + 8 * self.time, self.time / 4)
        noise = np.random.default_rng(self.seed).standard_normal(len(knots))
        window = np.hanning(9)
        slow = np.interp(t, knots, np.convolve(noise, window / window.sum(), mode="same"))
        return history.M_z + self.level * slow / np.sqrt(np.mean(slow**2))


@dataclass(frozen=True, kw_only=True)
class PlantedFreeBranch(PlantedEffect):
    """A Maxwell branch beside the whole patch: its torque relaxes, and friction does not bound it."""

    stiffness: float = 0.0
    """Of its spring [N m/rad]."""
    time: float = 0.5
    """In which its torque falls to 1/e [s]."""

    def torque(self, history: RigHistory) -> Array:
        """Torque with the branch, which turns at an even rate between samples."""
        t, psi = history.drive.t, history.psi_patch
        twist = np.zeros_like(psi)
        for i in range(1, len(psi)):
            fade = exp(-(t[i] - t[i - 1]) / self.time)
            share = self.time * (1 - fade) / (t[i] - t[i - 1])
            twist[i] = fade * twist[i - 1] + share * (psi[i] - psi[i - 1])
        return history.M_z - self.stiffness * twist


@dataclass(frozen=True, kw_only=True)
class PlantedEncoderEccentricity(PlantedEffect):
    """An encoder off its axis reads psi where the wheel is at psi + A sin(n psi + phi)."""

    amplitude: float = 0.0
    """A [rad]."""
    cycles: float = 8.0
    """Turns n of the encoder, which is geared, in one of the wheel [1]."""
    phase: float = 0.0
    """phi [rad]."""

    def drive(self, drive: RigDrive) -> RigDrive:
        """The tyre's angle and rate from the encoder's."""
        angle = self.cycles * drive.psi + self.phase
        stretched = 1 + self.amplitude * self.cycles * np.cos(angle)
        return replace(
            drive,
            psi=drive.psi + self.amplitude * np.sin(angle),
            psi_dot=drive.psi_dot * stretched,
            psi_virgin=drive.psi_virgin
            + self.amplitude * float(np.sin(self.cycles * drive.psi_virgin + self.phase)),
        )


@dataclass(frozen=True, kw_only=True)
class PlantedSensorHysteresis(PlantedEffect):
    """The torque channel follows the torque as a play operator does, `height` [N m] behind it."""

    height: float = 0.0

    @property
    def rank(self) -> int:
        """Last: the sensor sees whatever makes the torque."""
        return 1

    def torque(self, history: RigHistory) -> Array:
        """What the channel shows."""
        shown, channel = 0.0, np.empty_like(history.M_z)
        for i, M_z in enumerate(history.M_z):
            shown = min(max(shown, M_z - self.height), M_z + self.height)
            channel[i] = shown
        return channel


@dataclass(frozen=True, kw_only=True)
class PlantedContactAgeing(PlantedEffect):
    """Limit times 1 + gain ln(1 + age/1 s): contacts that rest grow, those that slide are new.

    The age is that of rate-and-state friction (Dieterich 1979, Ruina 1983), for the patch as a whole.
    """

    gain: float = 0.0

    def friction(self, sample: BristleStep) -> float:
        """Factor of all bristles."""
        return 1 + self.gain * log1p(sample.age)


UNMODELLED_EFFECTS: dict[str, type[PlantedEffect]] = {
    "play": PlantedPlay,
    "slide_oscillation": PlantedSlideOscillation,
    "gust": PlantedGust,
    "free_branch": PlantedFreeBranch,
    "encoder_eccentricity": PlantedEncoderEccentricity,
    "sensor_hysteresis": PlantedSensorHysteresis,
    "contact_ageing": PlantedContactAgeing,
}
"""Name of the effect -> its class, neutral by default."""
