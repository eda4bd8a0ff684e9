"""Whether the residual is noise, and if not, which signals it follows."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from identification.fits.autocorrelation import autocorrelation_time, autoregression, predict_gaps
from identification.fits.least_squares_problem import torque_range
from identification.fits.loss import LEAST_SQUARES, Loss, influence, rmse_of
from identification.reading.recordings import Recording
from identification.residuals.partial_correlations import MIN_STRUCTURE_SHARE, Signatures
from symbolic.float_array_type import Array

MAX_NOISE_RATIO = 1.15
"""Largest rms of residuals that counts as noise, over the noise of the torque channel [1]."""
LINE, BAND = 30.0, 0.05
"""Power of a frequency over the median of those beside it, within this share of the spectrum, that noise
has once in 10^9, whatever a filter before the sampling left of it [1]."""
MAX_LINES = 1 - MAX_NOISE_RATIO**-2
"""Share of a residual's power in such lines beyond which it oscillates [1]."""


@dataclass(frozen=True, kw_only=True)
class Unexplained:
    """Whether the residual has structure, and the evidence in plain words.

    Attributes:
        present: whether it has.
        evidence: in plain words.
        structured: root mean square of the residual beyond the noise of the torque channel, over the
            torque range [1].
    """

    present: bool
    evidence: str
    structured: float = 0.0


def white_noise_std(torque: Array) -> float:
    """Standard deviation of the white noise on a torque channel [N m].

    From second differences of neighbouring samples, to which a smooth torque contributes little; the
    median is robust to the few corners of the torque.
    """
    second = np.diff(torque, 2)
    second = second[np.isfinite(second)]
    return float(np.median(np.abs(second)) / 0.6745 / np.sqrt(6)) if second.size else 0.0


def _spectral_line_share(residual: Array) -> float:
    """Share of the power of a residual that stands in lines of its spectrum [1]."""
    centred = np.nan_to_num(residual - np.nanmean(residual))
    power = np.abs(np.fft.rfft(centred * np.hanning(centred.size))) ** 2
    level = median_filter(power, size=2 * max(8, int(BAND * power.size)) + 1, mode="mirror")
    return float(power[power > LINE * level].sum() / power.sum()) if power.any() else 0.0


def _innovation_std(residual: Array) -> float:
    """Standard deviation of what the samples before do not predict of a residual, in its unit."""
    centred = residual - np.nanmean(residual)
    weights = autoregression(centred)
    innovations = np.convolve(predict_gaps(centred, weights), weights)[: centred.size]
    known = np.isfinite(residual)
    known[: weights.size - 1] = False
    return float(np.sqrt(np.mean(innovations[known] ** 2))) if known.any() else 0.0


def find_residual_structure(
    residuals: Mapping[str, Array],
    recordings: Sequence[Recording],
    followed: Signatures,
    loss: Loss = LEAST_SQUARES,
) -> Unexplained:
    """Whether the residuals of these recordings [N m] have structure, and which signals it follows.

    `followed` are their signatures, see `signatures`; an outlier counts as little as in the fit.
    """
    errors, noise, samples, shares = [], [], [], []
    for recording in recordings:
        span = torque_range(recording)
        share = residuals[recording.name] / span
        errors.append(rmse_of(np.sqrt(loss(share**2)[0])))
        counted = influence(loss, share)
        shares.append(_spectral_line_share(counted))
        # Torques may come more slowly than the samples.
        known = np.isfinite(recording.M_z)
        floor = min(white_noise_std(recording.M_z[known]) / span, white_noise_std(share[known]))
        # A fast oscillation has large second differences too, but is predictable.
        noise.append(min(floor, _innovation_std(counted)) if shares[-1] > MAX_LINES else floor)
        samples.append(autocorrelation_time(counted))
    rms, floor = float(np.mean(errors)), float(np.mean(noise))
    structured = float(np.sqrt(max(0.0, rms**2 - floor**2)))
    correlated = float(np.median(samples))
    oscillates = float(np.median(shares)) > MAX_LINES
    above = structured > MIN_STRUCTURE_SHARE and rms > MAX_NOISE_RATIO * floor
    present = above and (correlated > 2 or oscillates)
    lasting = "independent from sample to sample"
    if oscillates:
        lasting = "predictable from the samples before"
    if round(correlated) > 1:
        lasting = f"correlated over {correlated:.0f} samples"
    white = f"white noise of the torque channel about {floor:.2%}"
    if floor < 5e-5:  # Rounds to zero.
        white = "no white noise (the torque is smooth, as a filter leaves it)"
    opening = f"residual {rms:.2%} of range, mean of all recordings; {white}"
    evidence = f"{opening}; {structured:.2%} beyond it, {lasting}: too little for an effect"
    if present:
        evidence = (
            f"{opening}; structured part {structured:.2%}, {lasting}. {followed.summary_paragraph}"
        )
    return Unexplained(present=present, evidence=evidence, structured=structured)
