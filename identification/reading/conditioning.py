"""From raw channels to a recording: units, offsets, filtering and resampling.

The rig of [Györök 2022] samples at 4 kHz. Its evaluation removes the offsets of angle, force and torque,
smooths the angle by a moving average and keeps every fortieth sample (section 5.3), which aliases mains
hum and all noise above 50 Hz. Here every channel goes through a low-pass first, the same for all,
so that angle and torque stay simultaneous.

No step is causal and none shifts a channel in time: they are for recordings, not for a control loop.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce

import numpy as np

from identification.reading.recordings import Recording
from identification.reading.yaw_rate_from_angle import smoothed_rate
from symbolic import InvalidInputError, Rig, Tyre
from symbolic.float_array_type import Array
from symbolic.tables.toml_and_json_parsing import prefix_errors

CHANNELS = ("psi", "M_z", "F_N")
"""Quantities that a recording needs: yaw angle [rad], aligning torque [N m], vertical load [N]."""
_MIN_QUIET_SAMPLES = 10
"""Samples that the mean of an offset needs."""
_FINEST_RATIO = 1000
"""Largest denominator of a ratio of rates."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """One channel, evenly sampled.

    Attributes:
        values: without gaps, shape (n,), n >= 3; in the sensor's unit, as volts, until it is scaled.
        rate: samples a second [Hz].

    Raises:
        InvalidInputError: the rate is not greater than 0, or the values are no such array.
    """

    values: Array
    rate: float

    def __post_init__(self) -> None:
        """Check shape, gaps and rate."""
        _require_positive("rate", self.rate)
        if self.values.ndim != 1 or self.values.size < 3:
            raise InvalidInputError(f"a channel needs shape (n,) with n >= 3, got {self.values.shape}")
        if not np.isfinite(self.values).all():
            gap = int(np.argmin(np.isfinite(self.values)))
            raise InvalidInputError(f"sample {gap} is not finite; a filter needs a channel without gaps")


def _require_positive(name: str, frequency: float) -> None:
    if not 0 < frequency < np.inf:
        raise InvalidInputError(f"{name} must be finite and greater than 0 Hz, got {frequency}")


@dataclass(frozen=True, kw_only=True)
class Scaled:
    """Converts volts by a factor of the sensor [unit/V], negative where it counts the other way."""

    factor: float

    def __post_init__(self) -> None:
        """Check the factor."""
        if self.factor == 0 or not np.isfinite(self.factor):
            raise InvalidInputError(f"factor must be finite and not 0, got {self.factor}")

    def __call__(self, channel: Channel) -> Channel:
        """The channel in the unit."""
        return Channel(values=self.factor * channel.values, rate=channel.rate)


@dataclass(frozen=True, kw_only=True)
class OffsetRemoved:
    """Subtracts the mean over a quiet stretch, where the true value is `level`.

    Attributes:
        start, stop: the stretch [s] from the first sample. For angle and torque the wheel stands
            untwisted in it; for the load it is lifted, or `level` is known from a scale.
        level: true value there, in the channel's unit.
    """

    start: float
    stop: float
    level: float = 0.0

    def __post_init__(self) -> None:
        """Check the order, and that the level is a number."""
        if not 0 <= self.start < self.stop < np.inf:
            raise InvalidInputError(
                f"a quiet stretch needs 0 <= start < stop, got {self.start} s to {self.stop} s"
            )
        if not np.isfinite(self.level):
            raise InvalidInputError(f"level must be finite, got {self.level}")

    def __call__(self, channel: Channel) -> Channel:
        """The channel without its offset."""
        first, last = round(self.start * channel.rate), round(self.stop * channel.rate)
        quiet = channel.values[first:last]
        if last > channel.values.size or quiet.size < _MIN_QUIET_SAMPLES:
            raise InvalidInputError(
                f"the quiet stretch from {self.start} s to {self.stop} s must hold at least"
                f" {_MIN_QUIET_SAMPLES} samples and end within {channel.values.size / channel.rate:g} s"
            )
        return Channel(values=channel.values - quiet.mean() + self.level, rate=channel.rate)


@dataclass(frozen=True, kw_only=True)
class LowPass:
    """Butterworth's filter, run forwards and backwards: no phase shift, 6 dB of loss at the edge.

    Beyond its ends the channel is extended by its mirror image. The usual point reflection would pin the
    first and the last sample to their noise.

    Attributes:
        cutoff: edge of the pass band [Hz].
        order: of the filter in one direction [1].
    """

    cutoff: float
    order: int = 4

    def __post_init__(self) -> None:
        """Check the ranges."""
        _require_positive("cutoff", self.cutoff)
        if not (isinstance(self.order, int) and 1 <= self.order <= 10):
            raise InvalidInputError(f"order must be a whole number from 1 to 10, got {self.order}")

    def __call__(self, channel: Channel) -> Channel:
        """The channel without frequencies above the edge."""
        if not self.cutoff < channel.rate / 2:
            raise InvalidInputError(
                f"cutoff must be less than half the rate, {channel.rate / 2:g} Hz, got {self.cutoff} Hz"
            )
        # Here, not above, as in `Resampler`: it takes half a second to load.
        from scipy.signal import butter, sosfiltfilt

        sections = butter(self.order, self.cutoff, fs=channel.rate, output="sos")
        # Three periods of the edge settle at the ends, as far as the channel is long enough.
        padding = min(round(3 * channel.rate / self.cutoff), channel.values.size - 1)
        values = sosfiltfilt(sections, channel.values, padtype="even", padlen=padding)
        return Channel(values=values, rate=channel.rate)


@dataclass(frozen=True, kw_only=True)
class Resampler:
    """Resamples to a rate [Hz] by a filter of linear phase against aliasing, its delay compensated."""

    rate: float

    def __post_init__(self) -> None:
        """Check the rate."""
        _require_positive("rate", self.rate)

    def __call__(self, channel: Channel) -> Channel:
        """The channel at the rate; its first sample stays at the same time."""
        ratio = Fraction(self.rate / channel.rate).limit_denominator(_FINEST_RATIO)
        if not np.isclose(float(ratio) * channel.rate, self.rate, rtol=1e-9):
            raise InvalidInputError(
                f"{self.rate} Hz from {channel.rate} Hz is no ratio of whole numbers up to"
                f" {_FINEST_RATIO}"
            )
        from scipy.signal import resample_poly

        # The ends are held level by a straight line from end to end, so that they do not ring.
        values = resample_poly(channel.values, ratio.numerator, ratio.denominator, padtype="line")
        return Channel(values=values, rate=self.rate)


@dataclass(frozen=True)
class Pipeline:
    """Steps in their order, as `Scaled`, `OffsetRemoved`, `LowPass`, `Resampler`."""

    steps: tuple[Callable[[Channel], Channel], ...]

    def __call__(self, channel: Channel) -> Channel:
        """The channel after all of them."""
        return reduce(lambda given, step: step(given), self.steps, channel)


def default_pipeline(
    factor: float,
    quiet: tuple[float, float],
    *,
    level: float = 0.0,
    cutoff: float = 20.0,
    rate: float = 100.0,
) -> Pipeline:
    """Scale, offset, low-pass and resampling for a channel of a wheel turned by hand.

    Args:
        factor: as of `Scaled`.
        quiet: stretch for the offset [s], see `OffsetRemoved`.
        level: true value there, in the unit.
        cutoff: edge of the low-pass [Hz]: far above a turn by hand, far below mains hum.
        rate: samples a second afterwards [Hz].
    """
    start, stop = quiet
    return Pipeline(
        (
            Scaled(factor=factor),
            OffsetRemoved(start=start, stop=stop, level=level),
            LowPass(cutoff=cutoff),
            Resampler(rate=rate),
        )
    )


def recording_from_raw(
    name: str, raw: Mapping[str, Channel], pipelines: Mapping[str, Pipeline], rig: Rig, tyre: Tyre
) -> Recording:
    """A recording from raw channels that begin at the same instant.

    Channels and their pipelines, which all must end at the same rate, are by the names in `CHANNELS`.

    Raises:
        InvalidInputError: a channel or its pipeline is missing, a step cannot be done (the message
            names the channel), or the channels end up with different rates or lengths.
    """
    missing = [channel for channel in CHANNELS if channel not in raw or channel not in pipelines]
    if missing:
        raise InvalidInputError(
            f"{name}: {', '.join(missing)} needs a raw channel and a pipeline; give both for"
            f" {', '.join(CHANNELS)}"
        )
    clean = {}
    for channel in CHANNELS:
        with prefix_errors(f"{name}: {channel}"):
            clean[channel] = pipelines[channel](raw[channel])
    kinds = {(channel.rate, channel.values.size) for channel in clean.values()}
    if len(kinds) > 1:
        ends = ", ".join(f"{n} {c.values.size} at {c.rate:g} Hz" for n, c in clean.items())
        raise InvalidInputError(f"{name}: all channels must end alike, got samples of {ends}")
    ((rate, size),) = kinds
    t, psi = np.arange(size) / rate, clean["psi"].values
    return Recording(
        name=name,
        t=t,
        psi=psi,
        psi_dot=smoothed_rate(t, psi),
        M_z=clean["M_z"].values,
        F_N=clean["F_N"].values,
        rig=rig,
        tyre=tyre,
    )
