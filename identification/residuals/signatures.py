"""What the residual of a fit follows, before any effect is tried: signatures with their chance bands."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from identification.fits.fitting import Fit
from identification.reading.recordings import Recording
from identification.residuals.correlation import (
    CONFIDENCE,
    Noise,
    Rows,
    added,
    correlation,
    directions_of,
    noise_of,
    rows_of,
    without,
)
from identification.residuals.signals import SIGNALS, Signal, motion_of

Array = NDArray[np.float64]
LONGEST = 2.0
"""Longest lag of the autocorrelation that is kept [s]."""
LEAST_SIZE = 1.5e-3
"""Structure below this share of the torque range goes without a word; the model resolves no finer."""
LEAST_CORRELATION = 0.1
"""So does a signature that explains less than one per cent of the residual."""
MOST_FOLLOWED = 3
"""Signals that are looked for one after the other."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Autocorrelation:
    """Autocorrelation of the residual, pooled over recordings.

    Attributes:
        lags: from one sample on [s], shape (n,).
        values: correlation at each lag [1], shape (n,).
        band: half-width of the 99 % band of white noise [1].
        memory: the first lag at which the correlation is within the band [s], 0 if the first one is.
    """

    lags: Array
    values: Array
    band: float
    memory: float


@dataclass(frozen=True, kw_only=True)
class Signature:
    """How far the residual follows a signal.

    Attributes:
        signal: name of the signal.
        unit: of the signal.
        correlation: partial correlation of the residual with the signal [1]; its square is the share of
            the residual that the signal explains. Without sign where each recording has its own.
        band: 99 % of the residuals that do not know the signal have a correlation within this [1].
        slope: change of the residual with the signal [N m per unit]; rms over the recordings where each
            has its own.
        size: rms of what the signal explains, over torque range [1].
        effects: candidate effects that usually leave it, the likeliest first; empty if there is none.
        reading: what physics usually leaves it, in plain words.
    """

    signal: str
    unit: str
    correlation: float
    band: float
    slope: float
    size: float
    effects: tuple[str, ...]
    reading: str

    @property
    def leaves_band(self) -> bool:
        """Whether chance leaves as much in less than one of a hundred cases."""
        return abs(self.correlation) > self.band

    @property
    def stands_out(self) -> bool:
        """Whether it also is large enough to matter."""
        matters = self.size > LEAST_SIZE and abs(self.correlation) > LEAST_CORRELATION
        return self.leaves_band and matters


@dataclass(frozen=True, kw_only=True, eq=False)
class Signatures:
    """What the residuals of a fit follow.

    Attributes:
        rms: root mean square of the residuals over torque range [1].
        autocorrelation: how long they remember.
        signatures: one for every signal, in the order of `SIGNALS`.
        followed: the strongest signature that leaves its band, then the strongest in what that one
            leaves of the residual, and so on. Signals go together: the angle's rate and its direction
            both stand out where only one of them is followed.
    """

    rms: float
    autocorrelation: Autocorrelation
    signatures: tuple[Signature, ...]
    followed: tuple[Signature, ...]

    @property
    def reading(self) -> str:
        """All in one paragraph, the strongest first."""
        if not self.followed:
            return self._quiet()
        first, *then = [f"{_figures(s)}: {s.reading}" for s in self.followed]
        shadows = [s for s in self.signatures if s.stands_out]
        known = {s.signal for s in self.followed}
        names = [s.signal for s in sorted(shadows, key=lambda s: -abs(s.correlation))]
        others = ", ".join(name for name in names if name not in known)
        also = f" What that leaves follows {'; then '.join(then)}." if then else ""
        shade = f" Outside their bands because they go along with these: {others}." if others else ""
        return f"The residual follows {first}.{also}{shade}"

    def _quiet(self) -> str:
        known = self.autocorrelation
        kept = self.rms * float(np.sqrt(max(0.0, known.values[0]))) if known.memory > 0 else 0.0
        if kept > LEAST_SIZE:
            closest = max(self.signatures, key=lambda s: abs(s.correlation))
            return (
                f"The residual is correlated over {known.memory:.2g} s, so it is not only noise, yet it"
                " follows none of the signals by more than chance may leave; closest comes"
                f" {_figures(closest)}."
            )
        return "The residual is nothing but noise: it follows none of the signals."

    def to_dict(self) -> dict[str, Any]:
        """Everything, as JSON knows it."""
        known = self.autocorrelation
        return {
            "rms": self.rms,
            "autocorrelation": {
                "lags": known.lags.tolist(),
                "values": known.values.tolist(),
                "band": known.band,
                "memory": known.memory,
            },
            "signatures": [_as_dict(s) for s in self.signatures],
            "followed": [_as_dict(s) for s in self.followed],
            "reading": self.reading,
        }


def signatures(
    residuals: Mapping[str, Array], recordings: Sequence[Recording], fits: Sequence[Fit] = ()
) -> Signatures:
    """What these residuals follow.

    Residuals and signals are divided by the torque range of their recording and stacked, as in the fit:
    a slope is one number for all recordings, and a recording counts by the square of its residual over
    range. Taken out of both by least squares are the mean of every recording (not before the constant
    and the size of the torque are looked at) and the sensitivities of all parameters that `fits` has
    adjusted. For what k and mu can absorb they have absorbed, and the residual is orthogonal to it; a
    signal that keeps its part of it seems to be followed less than it is.

    Args:
        residuals: simulated minus measured torque of every recording [N m], NaN where missing.
        recordings: what was measured, two samples or more of each with a torque.
        fits: what left the residuals: the fit to the training recordings, that to the held-out ones.
    """
    rows = rows_of(residuals, recordings)
    adjusted = rows.sensitivities(fits)
    absorbed = _Absorbed(
        adjusted=directions_of(adjusted), centred=directions_of(np.hstack([adjusted, rows.means()]))
    )
    motions = [motion_of(recording, residuals[recording.name]) for recording in recordings]
    columns = {}
    for signal in SIGNALS:
        each = rows.columns([signal.of(motion) for motion in motions])
        columns[signal] = each if signal.own else each.sum(axis=1, keepdims=True)
    found = _look(columns, absorbed, noise_of(rows))
    return Signatures(
        rms=_rms(rows),
        autocorrelation=_autocorrelation(noise_of(rows)),
        signatures=found,
        followed=_followed(columns, absorbed, rows, found),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Absorbed:
    """Orthonormal directions that are taken out: of every signal, and of those that are centred."""

    adjusted: Array
    centred: Array

    def of(self, signal: Signal) -> Array:
        return self.centred if signal.centred else self.adjusted

    def and_also(self, columns: Array) -> "_Absorbed":
        parts = (self.adjusted, self.centred)
        adjusted, centred = (np.hstack([p, added(columns, p)]) for p in parts)
        return _Absorbed(adjusted=adjusted, centred=centred)


def _look(columns: Mapping[Signal, Array], absorbed: _Absorbed, noise: Noise) -> tuple[Signature, ...]:
    """How far the residual follows each signal."""
    found, rms = [], _rms(noise.rows)
    for signal, own in columns.items():
        freedom = 1e9 if signal.centred else noise.freedom
        value, band, slopes = correlation(own, absorbed.of(signal), noise, freedom)
        reading = signal.along if value >= 0 else signal.against
        found.append(
            Signature(
                signal=signal.name,
                unit=signal.unit,
                correlation=value,
                band=band,
                slope=float(np.sqrt(np.mean(slopes**2))) if signal.own else float(slopes[0]),
                size=abs(value) * rms,
                effects=reading.effects,
                reading=reading.meaning,
            )
        )
    return tuple(found)


def _followed(
    columns: Mapping[Signal, Array], absorbed: _Absorbed, rows: Rows, found: tuple[Signature, ...]
) -> tuple[Signature, ...]:
    """The strongest that stands out, then the strongest in what is left without it."""
    by_name = {signal.name: signal for signal in columns}
    followed: list[Signature] = []
    least = LEAST_CORRELATION * _rms(rows)
    while len(followed) < MOST_FOLLOWED:
        outside = [s for s in found if s.stands_out and s.size > least]
        if not outside:
            break
        followed.append(max(outside, key=lambda s: abs(s.correlation)))
        absorbed = absorbed.and_also(columns[by_name[followed[-1].signal]])
        left = replace(rows, residual=without(rows.residual, absorbed.adjusted))
        found = _look(columns, absorbed, noise_of(left))
    return tuple(followed)


def _rms(rows: Rows) -> float:
    return float(np.sqrt(np.sum(rows.residual**2) / rows.present.sum()))


def _autocorrelation(noise: Noise) -> Autocorrelation:
    """The pooled autocorrelation, over at most a quarter of the longest recording."""
    last = min(LONGEST, float(noise.lags[-1]) / 4)
    shown = slice(1, max(2, int(np.searchsorted(noise.lags, last, side="right"))))
    values = noise.correlation[shown]
    # Each recording's autocorrelation has the variance 1/n and counts by its energy.
    weights = noise.energies / max(float(noise.energies.sum()), 1e-300)
    band = float(norm.ppf((1 + CONFIDENCE) / 2) * np.sqrt(np.sum(weights**2 / noise.counts)))
    within = np.flatnonzero(np.abs(values) < band)
    end = int(within[0]) if within.size else values.size - 1
    lags = noise.lags[shown]
    return Autocorrelation(
        lags=lags, values=values, band=band, memory=float(lags[end]) if end > 0 else 0.0
    )


def _as_dict(signature: Signature) -> dict[str, Any]:
    return {
        **asdict(signature),
        "effects": list(signature.effects),
        "leaves_band": signature.leaves_band,
    }


def _figures(signature: Signature) -> str:
    """The signature with its figures."""
    return f"{signature.signal} ({signature.correlation:+.2f}, chance within {signature.band:.2f})"
