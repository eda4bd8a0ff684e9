"""What the residual still holds: is it noise, and if not, what does it follow?"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from identification.fitting import torque_range
from identification.recordings import Recording
from identification.results import Unexplained
from identification.scoring import autocorrelation_time, rmse_of

Array = NDArray[np.float64]
LEAST_SHARE = 1.5e-3
"""Structure below this share of the torque range is not reported; the model resolves no finer."""
LEAST_RATIO = 1.15
"""Residuals count as noise up to this multiple of the noise of the torque channel."""


def white_noise(torque: Array) -> float:
    """Standard deviation of the white noise on a torque channel [N m].

    From second differences of neighbouring samples, which a smooth torque hardly enters; the median
    makes it deaf to the few corners of the torque.
    """
    second = np.diff(torque, 2)
    second = second[np.isfinite(second)]
    return float(np.median(np.abs(second)) / 0.6745 / np.sqrt(6)) if second.size else 0.0


def unexplained(residuals: Mapping[str, Array], recordings: Sequence[Recording]) -> Unexplained:
    """Whether structure is left in the residuals of these recordings, and what it follows."""
    left, noise = [], []
    for recording in recordings:
        size, floor = rmse_of(residuals[recording.name]), white_noise(recording.M_z)
        left.append(size / torque_range(recording))
        noise.append(floor / torque_range(recording))
    rms, floor = float(np.mean(left)), float(np.mean(noise))
    structured = float(np.sqrt(max(0.0, rms**2 - floor**2)))
    correlated = float(np.median([autocorrelation_time(residuals[r.name]) for r in recordings]))
    present = structured > LEAST_SHARE and rms > LEAST_RATIO * floor and correlated > 2
    opening = (
        f"residual {rms:.2%} of range, white noise of the torque channel {floor:.2%},"
        f" structured part {structured:.2%}, {correlated:.0f} samples correlated"
    )
    if not present:
        return Unexplained(present=False, evidence=f"{opening}: nothing beyond noise")
    return Unexplained(present=True, evidence=f"{opening}; {_strongest(residuals, recordings)}")


def _strongest(residuals: Mapping[str, Array], recordings: Sequence[Recording]) -> str:
    """The signals that the residual follows most, in plain words."""
    found: dict[str, list[float]] = {}
    for recording in recordings:
        residual = residuals[recording.name]
        present = np.isfinite(residual)
        for name, signal in _signals(recording).items():
            if np.std(signal[present]) > 0 and np.std(residual[present]) > 0:
                value = np.corrcoef(signal[present], residual[present])[0, 1]
                found.setdefault(name, []).append(float(value))
    means = {name: float(np.mean(values)) for name, values in found.items()}
    ranked = sorted(means, key=lambda name: -abs(means[name]))[:3]
    listed = ", ".join(f"{name} ({means[name]:+.2f})" for name in ranked)
    return f"it correlates most with {listed}"


def _signals(recording: Recording) -> dict[str, Array]:
    """Signals that a residual may follow."""
    rate = recording.psi_dot
    turning = np.tanh(rate / 0.01)
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(recording.psi)))])
    reversal = np.flatnonzero(np.diff(np.sign(turning)) != 0)
    since = travelled.copy()
    for index in reversal:
        since[index + 1 :] = travelled[index + 1 :] - travelled[index]
    return {
        "the angle": recording.psi,
        "the yaw rate": rate,
        "the direction of turning": turning,
        "direction times log speed": turning * np.log(np.abs(rate) + 1e-3),
        "the load": recording.F_N,
        "the size of the torque": np.abs(np.nan_to_num(recording.M_z)),
        "time": recording.t,
        "the way since the last reversal, signed": since * turning,
    }
