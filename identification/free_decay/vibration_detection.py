"""Onset and end of the free vibration in a recording, with first guesses of its parameters."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from identification.free_decay.recording import Decay
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

ContactGeometry = tuple[float, float]
"""a and e [m]; recordings that share them share the slip."""

MIN_DEFLECTION_STEPS = 3.0
"""Least first deflection, in steps of the encoder."""
MAX_DEFLECTION = 0.2
"""Largest first deflection [rad], as all formulas take angles for small."""
MIN_PERIODS = 1.5
"""Least length of the recording after the first turning point, in periods."""
_MIN_AMPLITUDE, _MAX_LENGTH = 0.25, 6.0
"""Amplitude at which the vibration ends, in steps, and its greatest length, in time constants."""
_LOUD = 0.05
"""Deflections below this share of the first one are no vibration."""
_PADDING, _FILTER = 8, 5
_MIN_DAMPING, _MAX_DAMPING = 0.005, 0.5
"""Bounds of the guessed relative damping [1]."""

_WHOLE = 0.05
"""Largest deviation of the distance of two readings from a whole number of steps, in steps."""
_LEVELS, _SELDOM = 4, 200
"""Levels that determine the step, each the value of more than one reading in so many."""
_NO_STEP = 1e-6
"""A channel without steps has cells as wide as this share of its range [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeVibration:
    """The free vibration within a recording; centre, omega and damping are guesses."""

    decay: Decay
    first: int  # At the first turning point: the largest deflection, after which no impact acts.
    last: int  # After the last sample of the vibration, where it has sunk into the encoder's step.
    step: float  # Of the encoder [rad].
    peak: float  # Reading at the first turning point [rad].
    centre: float  # Reading about which the wheel swings [rad].
    omega: float  # Its angular frequency [rad/s].
    damping: float  # Its decay rate [1/s].

    @property
    def t(self) -> Array:
        """Times of the vibration [s], shape (n,)."""
        return self.decay.t[self.first : self.last]

    @property
    def psi(self) -> Array:
        """Readings of the vibration [rad], shape (n,)."""
        return self.decay.psi[self.first : self.last]

    @property
    def contact(self) -> ContactGeometry:
        """Half-length and caster length of the contact [m]."""
        return self.decay.rig.a, self.decay.rig.e

    @property
    def first_deflection(self) -> float:
        """First deflection from the centre [rad]."""
        return self.peak - self.centre


def find_vibration(decay: Decay) -> FreeVibration:
    """The free vibration; refused where the wheel swings by too little, too far, or too short a time."""
    if np.ptp(decay.psi) == 0:
        raise InvalidInputError(f"{decay.name}: psi is constant; the wheel has to be struck")
    step = encoder_step(decay.psi)
    centre = float(np.median(decay.psi))
    psi = without_spikes(decay.psi)
    first = _middle_of_top(psi, int(np.argmax(np.abs(psi - centre))), step)
    t, swing = decay.t[first:], psi[first:] - centre
    deflection = abs(float(swing[0]))
    if deflection < MIN_DEFLECTION_STEPS * step:
        raise InvalidInputError(
            f"{decay.name}: the wheel swings by {1000 * deflection:.2g} mrad,"
            f" {deflection / step:.2g} steps of the encoder; at least"
            f" {MIN_DEFLECTION_STEPS:g} steps are needed: strike it harder"
        )
    if deflection > MAX_DEFLECTION:
        raise InvalidInputError(
            f"{decay.name}: the wheel swings by {deflection:.3g} rad; allowed: up to"
            f" {MAX_DEFLECTION:g} rad, as all angles are taken for small; is psi in rad?"
        )
    omega = _frequency(t, swing) if t.size >= 4 else 0.0
    if not (t[-1] - t[0]) * omega > MIN_PERIODS * 2 * np.pi:
        raise InvalidInputError(
            f"{decay.name}: holds {t[-1] - t[0]:.3g} s after its largest deflection, in which psi does"
            f" not swing {MIN_PERIODS:g} times; record the vibration until it has died away"
        )
    loud = max(1.5 * step, _LOUD * deflection)
    calm, end = _calm_after_vibration(t, np.abs(swing), loud, 2 * np.pi / omega)
    damping = _decay_rate_by_centroid(t[:calm], swing[:calm], loud, omega)
    length = min(np.log(deflection / (_MIN_AMPLITUDE * step)), _MAX_LENGTH) / damping
    length = max(length, MIN_PERIODS * 2 * np.pi / omega)
    return FreeVibration(
        decay=decay,
        first=first,
        last=first + min(end, int(np.searchsorted(t - t[0], length))),
        step=step,
        peak=float(psi[first]),
        centre=centre,
        omega=omega,
        damping=damping,
    )


def encoder_step(psi: Array) -> float:
    """Step of readings that are not all equal [rad]; for a channel without steps a very small one."""
    least = _NO_STEP * float(np.ptp(psi))
    _, places, visits = np.unique(np.round(psi / least), return_index=True, return_counts=True)
    levels = psi[places]
    # A wrong reading stands alone; where the wheel turns back or comes to rest, levels are met often.
    often = visits > psi.size // _SELDOM
    if np.count_nonzero(often) >= _LEVELS:
        levels = levels[often]
    span = float(levels[-1] - levels[0])
    gaps = np.diff(levels)
    counts = gaps / gaps.min()
    # Rounding in the file moves every gap a little; all of the range together tells the step best.
    step = span / float(np.round(counts).sum())
    if np.abs(gaps / step - np.round(gaps / step)).max() > _WHOLE:
        return least
    return max(step, least)


def without_spikes(psi: Array) -> Array:
    """Readings with one or two wrong ones in a row replaced by a median of their neighbours [rad]."""
    return np.asarray(median_filter(psi, _FILTER, mode="reflect"))


def _middle_of_top(psi: Array, top: int, step: float) -> int:
    """Middle of the run of samples around the top that are within half a step of it."""
    other = np.flatnonzero(np.abs(psi - psi[top]) > step / 2)
    at = int(np.searchsorted(other, top))
    before = int(other[at - 1]) if at > 0 else -1
    after = int(other[at]) if at < other.size else psi.size
    return (before + after) // 2


def _frequency(t: Array, swing: Array) -> float:
    """Place of the peak of the spectrum [rad/s]."""
    even = np.linspace(t[0], t[-1], t.size)
    even_swing = np.interp(even, t, swing)
    even_swing = even_swing - even_swing.mean()
    count = _PADDING * t.size
    spectrum = np.abs(np.fft.rfft(even_swing, count))
    # Below one period in the whole recording there is drift, no vibration.
    spectrum[:_PADDING] = 0
    return 2 * np.pi * float(np.argmax(spectrum)) / (count * float(even[1] - even[0]))


def _calm_after_vibration(t: Array, away: Array, loud: float, period: float) -> tuple[int, int]:
    """Begin of a whole period without loud samples, and the next loud sample or else the end."""
    is_loud = np.flatnonzero(away > loud)
    pauses = np.flatnonzero(np.diff(t[is_loud]) > period)
    if pauses.size:
        return int(is_loud[pauses[0]]) + 1, int(is_loud[pauses[0] + 1])
    return int(is_loud[-1]) + 1, t.size


def _decay_rate_by_centroid(t: Array, swing: Array, least: float, omega: float) -> float:
    """Decay rate from the centroid of the energy, which lies at half a time constant [1/s]."""
    energy = np.where(np.abs(swing) > least, swing**2, 0) * np.gradient(t)
    delay = float(((t - t[0]) * energy).sum() / energy.sum())
    return float(np.clip(1 / (2 * delay), _MIN_DAMPING * omega, _MAX_DAMPING * omega))
