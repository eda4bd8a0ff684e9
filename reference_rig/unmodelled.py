"""Effects that no library knows: what remains unexplained has to be reported as such."""

from dataclasses import dataclass, replace

import numpy as np

from reference_rig.hooks import Array, Drive, Effect, History


@dataclass(frozen=True, kw_only=True)
class Backlash(Effect):
    """Play between angle sensor and tyre, `gap` [rad] from flank to flank."""

    gap: float = 0.0

    def drive(self, drive: Drive) -> Drive:
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
class SlideOscillation(Effect):
    """The torque swings with `amplitude` [N m] and `frequency` [Hz] while the patch slides."""

    amplitude: float = 0.0
    frequency: float = 5.0

    def torque(self, history: History) -> Array:
        """The swing fades in as most bristles let go."""
        swell = np.clip((history.sliding - 0.4) / 0.4, 0, 1)
        swing = np.sin(2 * np.pi * self.frequency * history.drive.t)
        return history.M_z + self.amplitude * swell * swing


@dataclass(frozen=True, kw_only=True)
class Gust(Effect):
    """Slow random disturbance of the torque's load cell: `level` [N m] rms, `time` [s] long."""

    level: float = 0.0
    time: float = 0.6
    seed: int = 0

    def torque(self, history: History) -> Array:
        """White noise twice smoothed over `time`, brought to the level."""
        if self.level == 0:
            return history.M_z
        t = history.drive.t
        knots = np.arange(t[0] - 8 * self.time, t[-1] + 8 * self.time, self.time / 4)
        noise = np.random.default_rng(self.seed).standard_normal(len(knots))
        window = np.hanning(9)
        slow = np.interp(t, knots, np.convolve(noise, window / window.sum(), mode="same"))
        return history.M_z + self.level * slow / np.sqrt(np.mean(slow**2))


OUTSIDE: dict[str, type[Effect]] = {
    "backlash": Backlash,
    "slide_oscillation": SlideOscillation,
    "gust": Gust,
}
"""Name of the effect -> its class, neutral by default."""
