"""Which signals the residual of a fit follows: partial correlations with their bands by chance."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from scipy.special import ndtri

from identification.fits.fitting import Fit
from identification.reading.recordings import Recording
from identification.residuals.correlation import (
    CONFIDENCE,
    ResidualNoise,
    StackedResiduals,
    additional_basis,
    orthogonal_part,
    orthonormal_basis,
    partial_correlation,
    residual_noise,
    stack_residuals,
)
from identification.residuals.residual_signals import (
    RESIDUAL_SIGNALS,
    Signal,
    check_signatures,
    correlation_meaning_text,
    effects_with_signature,
    motion_and_model_torque,
)
from symbolic import EFFECTS, Effect
from symbolic.float_array_type import Array

MAX_LAG = 2.0
"""Longest lag of the autocorrelation that is kept [s]."""
MIN_STRUCTURE_SHARE = 1.5e-3
"""Structure below this share of the torque range is not reported; the model resolves no finer."""
MIN_CORRELATION = 0.1
"""Nor is a signature that explains less than one per cent of the residual."""
MAX_EXTRACTED = 3
"""Most signals that are extracted one after the other."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Autocorrelation:
    """Autocorrelation of the residual, pooled over recordings."""

    lags: Array  # From one sample on [s], shape (n,).
    values: Array  # Correlation at each lag [1], shape (n,).
    band: float  # Half-width of the 99 % band of white noise [1].
    memory: float  # First lag at which the correlation is within the band [s], 0 if the first one is.


@dataclass(frozen=True, kw_only=True)
class SignalCorrelation:
    """How far the residual follows a signal.

    Attributes:
        signal: name of the signal.
        unit: of the signal.
        correlation: partial correlation of the residual with the signal [1]; its square is the share of
            the residual that the signal explains. Without sign where each recording has its own.
        band: 99 % of residuals that are independent of the signal have a correlation within this [1].
        slope: change of the residual with the signal [N m per unit]; rms over the recordings where each
            has its own.
        size: rms of what the signal explains, over torque range [1].
        effects: candidate effects that declare it, the likeliest first; empty if there is none.
        reading: what usually leaves it, and which effects of that kind the search did not add; where an
            effect of the model leaves the opposite, that it may be too strong there. In plain words.
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
    def is_significant(self) -> bool:
        """Whether it is significant: by chance it would be in less than one of a hundred cases."""
        return abs(self.correlation) > self.band

    @property
    def is_significant_and_large(self) -> bool:
        """Whether it also is large enough to matter."""
        matters = self.size > MIN_STRUCTURE_SHARE and abs(self.correlation) > MIN_CORRELATION
        return self.is_significant and matters

    @property
    def correlation_text(self) -> str:
        """The signal with correlation and band."""
        value = f"{self.correlation:+.2f}".replace("-", "−")
        return f"{self.signal} (correlation {value}, by chance within ±{self.band:.2f})"

    def to_dict(self) -> dict[str, Any]:
        """The content of `diagnosis.json`."""
        return {**asdict(self), "effects": list(self.effects), "leaves_band": self.is_significant}


@dataclass(frozen=True, kw_only=True, eq=False)
class Signatures:
    """What the residuals of a fit follow.

    Attributes:
        rms: root mean square of the residuals over torque range [1].
        autocorrelation: of the residuals.
        signatures: one for every signal, in the order of `RESIDUAL_SIGNALS`.
        followed: the strongest significant signature, then the strongest in the residual that remains
            without it, and so on. Signals are collinear: the yaw rate and the direction of turning are
            both significant where the residual follows only one of them.
    """

    rms: float
    autocorrelation: Autocorrelation
    signatures: tuple[SignalCorrelation, ...]
    followed: tuple[SignalCorrelation, ...]

    @property
    def summary_paragraph(self) -> str:
        """All in one paragraph, the strongest first."""
        if not self.followed:
            return self._no_signal_sentence()
        first, *others = self.followed
        followed = {s.signal for s in self.followed}
        significant = [
            s for s in self.signatures if s.is_significant_and_large and s.signal not in followed
        ]
        names = [s.signal for s in sorted(significant, key=lambda s: -abs(s.correlation))]
        then = [f"{s.signal}: {s.reading}" for s in others]
        rest = f" The remaining residual follows {'; then '.join(then)}." if then else ""
        collinear = f" Also significant, but collinear with these: {', '.join(names)}." if names else ""
        return f"The residual follows {first.correlation_text}: {first.reading}.{rest}{collinear}"

    def _no_signal_sentence(self) -> str:
        known = self.autocorrelation
        correlated = self.rms * float(np.sqrt(max(0.0, known.values[0]))) if known.memory > 0 else 0.0
        if correlated > MIN_STRUCTURE_SHARE:
            closest = max(self.signatures, key=lambda s: abs(s.correlation))
            return (
                f"The residual is correlated over {known.memory:.2g} s, so it is not white noise, but it"
                " follows none of the signals significantly; the strongest is"
                f" {closest.correlation_text}."
            )
        return "The residual is noise: it follows none of the signals."

    def to_dict(self) -> dict[str, Any]:
        """The content of `diagnosis.json`."""
        known = self.autocorrelation
        return {
            "rms": self.rms,
            "autocorrelation": {
                **asdict(known),
                "lags": known.lags.tolist(),
                "values": known.values.tolist(),
            },
            "signatures": [s.to_dict() for s in self.signatures],
            "followed": [s.to_dict() for s in self.followed],
            "reading": self.summary_paragraph,
        }


def signatures(
    residuals: Mapping[str, Array],
    recordings: Sequence[Recording],
    fits: Sequence[Fit] = (),
    effects: Iterable[Effect] = tuple(EFFECTS.values()),
) -> Signatures:
    """Which signals these residuals follow.

    Residuals and signals are divided by the torque range of their recording and stacked, as in the fit:
    a slope is one number for all recordings, and a recording counts by the square of its residual over
    range. Both are projected, by least squares, off the sensitivities of all parameters that `fits` has
    adjusted and off the mean of every recording (not for the constant and the magnitude of the torque).
    The fit has already made the residual orthogonal to these sensitivities. A signal that was not
    projected too would show too small a correlation.

    Args:
        residuals: simulated minus measured torque of every recording [N m], NaN where missing.
        recordings: what was measured, two samples or more of each with a torque.
        fits: those that left the residuals: to the training recordings and to the held-out ones.
        effects: candidates, whose declared signatures say which of them a signal points at.

    Raises:
        InvalidInputError: an effect declares a signature of an unknown signal.
    """
    candidates = tuple(effects)
    check_signatures(candidates)
    rows = stack_residuals(residuals, recordings)
    adjusted = rows.sensitivities(fits)
    motions = [motion_and_model_torque(recording, residuals[recording.name]) for recording in recordings]
    columns = {}
    for signal in RESIDUAL_SIGNALS:
        each = rows.signal_columns([signal.of(motion) for motion in motions])
        columns[signal] = each if signal.differs_by_recording else each.sum(axis=1, keepdims=True)
    tests = _SignalTests(
        columns=columns,
        effects=candidates,
        added=fits[0].model.effects if fits else (),
        adjusted=orthonormal_basis(adjusted),
        centred=orthonormal_basis(np.hstack([adjusted, rows.indicator_columns()])),
    )
    noise = residual_noise(rows)
    every = tests.correlations(noise)
    return Signatures(
        rms=rows.rms,
        autocorrelation=_autocorrelation(noise),
        signatures=every,
        followed=_strongest_signals(tests, rows, every),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _SignalTests:
    """Signals, and the orthonormal directions off which they and the residual are projected."""

    columns: Mapping[Signal, Array]
    effects: Sequence[Effect]  # Candidates.
    added: Sequence[Effect]  # Effects of the model.
    adjusted: Array  # Directions for signals whose mean counts.
    centred: Array  # For all others.

    def correlations(self, noise: ResidualNoise) -> tuple[SignalCorrelation, ...]:
        """How far the residual of this noise follows each signal."""
        every = []
        for signal, own in self.columns.items():
            absorbed = self.centred if signal.centred else self.adjusted
            degrees_of_freedom = 1e9 if signal.centred else noise.degrees_of_freedom
            value, band, slopes = partial_correlation(own, absorbed, noise, degrees_of_freedom)
            slope = np.sqrt(np.mean(slopes**2)) if signal.differs_by_recording else slopes[0]
            every.append(
                SignalCorrelation(
                    signal=signal.name,
                    unit=signal.unit,
                    correlation=value,
                    band=band,
                    slope=float(slope),
                    size=abs(value) * noise.rows.rms,
                    effects=effects_with_signature(signal, 1 if value >= 0 else -1, self.effects),
                    reading=correlation_meaning_text(signal, value, self.effects, self.added),
                )
            )
        return tuple(every)

    def without_signal(self, name: str) -> "_SignalTests":
        """The tests of what remains without what follows a signal."""
        columns = next(own for signal, own in self.columns.items() if signal.name == name)
        parts = (self.adjusted, self.centred)
        adjusted, centred = (np.hstack([p, additional_basis(columns, p)]) for p in parts)
        return replace(self, adjusted=adjusted, centred=centred)


def _strongest_signals(
    tests: _SignalTests, rows: StackedResiduals, every: Sequence[SignalCorrelation]
) -> tuple[SignalCorrelation, ...]:
    """The strongest that stands out, then the strongest in the residual that remains without it."""
    followed: list[SignalCorrelation] = []
    least = MIN_CORRELATION * rows.rms
    while len(followed) < MAX_EXTRACTED:
        candidates = [s for s in every if s.is_significant_and_large and s.size > least]
        if not candidates:
            break
        followed.append(max(candidates, key=lambda s: abs(s.correlation)))
        tests = tests.without_signal(followed[-1].signal)
        remaining = replace(rows, residual=orthogonal_part(rows.residual, tests.adjusted))
        every = tests.correlations(residual_noise(remaining))
    return tuple(followed)


def _autocorrelation(noise: ResidualNoise) -> Autocorrelation:
    """The pooled autocorrelation, over at most a quarter of the longest recording."""
    last = min(MAX_LAG, float(noise.lags[-1]) / 4)
    lags_used = slice(1, max(2, int(np.searchsorted(noise.lags, last, side="right"))))
    values = noise.correlation[lags_used]
    # Each recording's autocorrelation has the variance 1/n and counts by its energy.
    weights = noise.energies / max(float(noise.energies.sum()), 1e-300)
    band = float(ndtri((1 + CONFIDENCE) / 2) * np.sqrt(np.sum(weights**2 / noise.counts)))
    within = np.flatnonzero(np.abs(values) < band)
    end = int(within[0]) if within.size else values.size - 1
    lags = noise.lags[lags_used]
    return Autocorrelation(
        lags=lags, values=values, band=band, memory=float(lags[end]) if end > 0 else 0.0
    )
