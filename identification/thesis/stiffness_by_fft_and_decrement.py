"""k and b_t from free vibrations as in [Györök 2022], section 5.1: one frequency and one damping each.

The peak of a Fourier transform is taken for the damped frequency, the logarithmic decrement gives the
damping, and the curves (5.7) and (5.8) are fitted to both over the contact length. (5.8) is printed as
zeta = b_t / (2 omega_n), which lacks J_A: its b_t is b_t / J_A, in 1/s. Both are given here.

The method neglects that the ends of the patch slide in every swing, and that the transform of a decaying
vibration has its peak elsewhere than at the damped frequency.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from identification.free_decay.recording import Decay
from identification.free_decay.vibration_detection import FreeVibration, find_vibration
from identification.free_decay.vibration_model import rotational_stiffness
from symbolic.float_array_type import Array

_FINE = 0.01
"""Distance of two frequencies of the padded transform [Hz]; [Györök 2022] has one over the duration."""
_MAX_PADDED_LENGTH = 4_000_000
"""Padded length, which a rate above 40 kHz would exceed: frequencies then lie further apart."""
_FAINT, _WEAK = 3.0, 0.1
"""The last amplitude of a decrement is at least so many steps, and so large a share of the first."""


@dataclass(frozen=True, kw_only=True)
class DecrementVibration:
    """Of one recording the half-length [m], natural frequency, (5.5) [rad/s], and damping, (5.4) [1]."""

    name: str
    a: float
    omega_n: float
    zeta: float


@dataclass(frozen=True, kw_only=True)
class DecrementIdentification:
    """Parameters from the frequencies and decrements of all recordings."""

    vibrations: tuple[DecrementVibration, ...]  # Each recording.
    k: float  # Distributed lateral stiffness [N/m^2].
    b_t_printed: float  # Damping by (5.8) as printed; it is b_t / J_A [1/s].
    b_t: float  # Damping by (5.8) with J_A [N m s/rad].

    def to_dict(self) -> dict[str, Any]:
        """The parameters with their units."""
        return {
            "k": {"value": self.k, "unit": "N/m^2"},
            "b_t": {"value": self.b_t, "unit": "N m s/rad"},
            "b_t_printed": {"value": self.b_t_printed, "unit": "1/s"},
        }


def estimate_by_decrement(decays: Sequence[Decay]) -> DecrementIdentification:
    """Fit (5.7) and (5.8) to the frequencies and decrements of recordings."""
    swings = [find_vibration(decay) for decay in decays]
    vibrations = tuple(_decrement_of(one) for one in swings)
    omega_n, zeta = (np.array([getattr(v, name) for v in vibrations]) for name in ("omega_n", "zeta"))
    J_A = np.array([decay.inertia for decay in decays])
    # omega_n is sqrt(k) times this, so that least squares need no iteration.
    per_root_k = np.sqrt([rotational_stiffness(1.0, *one.contact) for one in swings] / J_A)
    root_k = _slope_through_origin(per_root_k, omega_n)
    per_damping = 1 / (2 * root_k * per_root_k)
    return DecrementIdentification(
        vibrations=vibrations,
        k=root_k**2,
        b_t_printed=_slope_through_origin(per_damping, zeta),
        b_t=_slope_through_origin(per_damping / J_A, zeta),
    )


def _decrement_of(vibration: FreeVibration) -> DecrementVibration:
    # The vibration up to the end of the recording; its centre is where the wheel comes to rest.
    decay, step = vibration.decay, vibration.step
    t, psi = decay.t[vibration.first :], decay.psi[vibration.first :]
    swing = psi - np.median(psi[-psi.size // 4 :])
    omega_d = 2 * np.pi * _frequency(t, swing)
    heights = np.maximum(
        _peak_deflections(t, swing * np.sign(vibration.first_deflection), 2 * np.pi / omega_d), step / 2
    )
    distinct = heights >= max(_FAINT * step, _WEAK * heights[0])
    periods = max(int(np.argmin(distinct)) - 1 if not distinct.all() else heights.size - 1, 1)
    decrement = float(np.log(heights[0] / heights[periods])) / periods
    zeta = decrement / float(np.hypot(2 * np.pi, decrement))
    return DecrementVibration(
        name=decay.name,
        a=decay.rig.a,
        omega_n=omega_d / float(np.sqrt(1 - zeta**2)),
        zeta=zeta,
    )


def _frequency(t: Array, swing: Array) -> float:
    """Place of the highest peak of the transform [Hz], (5.2)."""
    even = np.linspace(t[0], t[-1], t.size)
    rate = (t.size - 1) / float(t[-1] - t[0])
    count = max(t.size, min(int(rate / _FINE), _MAX_PADDED_LENGTH))
    spectrum = np.abs(np.fft.rfft(np.interp(even, t, swing), count))
    slowest = int(np.ceil(count / t.size))
    return float(slowest + np.argmax(spectrum[slowest:])) * rate / count


def _peak_deflections(t: Array, swing: Array, period: float) -> Array:
    """The largest deflection of every period towards the side of the first [rad]."""
    number = np.round((t - t[0]) / period).astype(np.intp)
    whole = int((t[-1] - t[0]) / period)
    heights = np.zeros(whole + 2)
    np.maximum.at(heights, number, swing)
    return heights[: whole + 1]


def _slope_through_origin(x: Array, y: Array) -> float:
    """Slope of the straight line through the origin, by least squares."""
    return float(np.dot(x, y)) / float(np.dot(x, x))
