"""The source's way from free vibrations to k and b_t: one frequency and one damping a recording.

The place of the peak of a Fourier transform is taken for the damped frequency, the logarithmic decrement
for the damping, and the curves (5.7) and (5.8) are laid through both over the contact length. The source
prints (5.8) as zeta = b_t / (2 omega_n), which lacks J_A: what it calls b_t is b_t / J_A, in 1/s. Both
are given here.

The ends of the patch slide in every swing, which no linear oscillator knows, and a decaying vibration
has the peak of its transform elsewhere than at the damped frequency.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from identification.free_decay.likelihood import contact_of
from identification.free_decay.onset import Release
from identification.free_decay.vibration import stiffness

Array = NDArray[np.float64]

_FINE = 0.01
"""Distance of two frequencies of the padded transform [Hz]; the source's is one over the duration."""
_FAINT, _WEAK = 3.0, 0.1
"""The last amplitude of a decrement is at least so many steps, and so large a share of the first."""


@dataclass(frozen=True, kw_only=True)
class SourceSwing:
    """What the source's way makes of one recording.

    Attributes:
        name: the recording.
        a: half-length of the contact patch [m].
        omega_n: undamped natural frequency, source (5.5) [rad/s].
        zeta: relative damping, source (5.4) [1].
        periods: over which the decrement was taken [1].
    """

    name: str
    a: float
    omega_n: float
    zeta: float
    periods: int


@dataclass(frozen=True, kw_only=True)
class SourceWay:
    """What the source's way makes of all recordings.

    Attributes:
        swings: each recording.
        k: distributed lateral stiffness [N/m^2].
        b_t_printed: damping by (5.8) as printed; it is b_t / J_A [1/s].
        b_t: damping by (5.8) with J_A [N m s/rad].
    """

    swings: tuple[SourceSwing, ...]
    k: float
    b_t_printed: float
    b_t: float


def source_way(releases: Sequence[Release]) -> SourceWay:
    """Frequencies, decrements and the curves through them, source (5.2)-(5.8)."""
    swings = tuple(_swing(of) for of in releases)
    omega_n, zeta = (np.array([getattr(s, name) for s in swings]) for name in ("omega_n", "zeta"))
    J_A = np.array([of.decay.inertia for of in releases])
    # omega_n is sqrt(k) times this, so that least squares need no iteration.
    per_root_k = np.sqrt([stiffness(1.0, *contact_of(of)) / of.decay.inertia for of in releases])
    root_k = _through_origin(per_root_k, omega_n)
    per_damping = 1 / (2 * root_k * per_root_k)
    return SourceWay(
        swings=swings,
        k=root_k**2,
        b_t_printed=_through_origin(per_damping, zeta),
        b_t=_through_origin(per_damping / J_A, zeta),
    )


def _swing(of: Release) -> SourceSwing:
    # The vibration up to the end of the recording; its centre is where the wheel comes to rest.
    t, psi = of.decay.t[of.first :], of.decay.psi[of.first :]
    swing = psi - np.median(psi[-psi.size // 4 :])
    omega_d = 2 * np.pi * _frequency(t, swing)
    heights = np.maximum(_heights(t, swing * np.sign(of.reach), 2 * np.pi / omega_d), of.step / 2)
    told = heights >= max(_FAINT * of.step, _WEAK * heights[0])
    periods = max(int(np.argmin(told)) - 1 if not told.all() else heights.size - 1, 1)
    decrement = float(np.log(heights[0] / heights[periods])) / periods
    zeta = decrement / float(np.hypot(2 * np.pi, decrement))
    return SourceSwing(
        name=of.decay.name,
        a=of.decay.rig.a,
        omega_n=omega_d / float(np.sqrt(1 - zeta**2)),
        zeta=zeta,
        periods=periods,
    )


def _frequency(t: Array, swing: Array) -> float:
    """Place of the highest peak of the transform [Hz], source (5.2)."""
    even = np.linspace(t[0], t[-1], t.size)
    rate = (t.size - 1) / float(t[-1] - t[0])
    count = max(t.size, int(rate / _FINE))
    spectrum = np.abs(np.fft.rfft(np.interp(even, t, swing), count))
    slowest = int(np.ceil(count / t.size))
    return float(slowest + np.argmax(spectrum[slowest:])) * rate / count


def _heights(t: Array, swing: Array, period: float) -> Array:
    """The largest deflection of every period towards the side of the first [rad]."""
    number = np.round((t - t[0]) / period).astype(np.intp)
    whole = int((t[-1] - t[0]) / period)
    return np.array([swing[number == i].max(initial=0.0) for i in range(whole + 1)])


def _through_origin(x: Array, y: Array) -> float:
    """Slope of the straight line through the origin, by least squares."""
    return float(np.dot(x, y)) / float(np.dot(x, x))
