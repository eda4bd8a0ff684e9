"""Torque and angle channels that are not simultaneous.

The torque measured now belongs to an earlier angle and load. The effect stores the last 150 ms of angle,
rate and load and interpolates them linearly at `delay` ago, so it works sample by sample on a target. It
stores one sample in 10 ms and the newest one, at any sampling rate.

In the simulation files published with [Györök 2022] the torque is one sample, 10 ms, late.
"""

from dataclasses import dataclass, replace

import casadi as ca

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Signals, Values

DEPTH = 17
"""Number of samples stored [1]."""
SPACING = 9.5e-3
"""Least time between stored samples [s]; with `DEPTH` of them the memory is at least 150 ms long."""
CHANNELS = ("psi", "psi_dot", "F_N")


@dataclass(frozen=True, kw_only=True)
class SensorDelay(Effect):
    """The patch sees the angle of `delay` ago; the torque channel is late."""

    name: str = "sensor_delay"
    summary: str = "the torque channel is late against the angle"
    family = "sensor and steering"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="delay", unit="s", neutral=0.0, start=0.004, lower=0.0, upper=0.15, scale=0.01),
    )
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the rate of the torque", sign=1),
        ResidualSignature("the yaw rate", sign=-1, rank=1),
        ResidualSignature("the direction of turning", sign=-1, rank=1),
        ResidualSignature("the signed angle since the last reversal", sign=-1, rank=1),
        ResidualSignature("the signed time since the last reversal", sign=-1, rank=1),
    )
    sensor: bool = True
    memory: int = (1 + len(CHANNELS)) * DEPTH

    def initial(self, signals: Signals) -> Expression:
        """Ages, then angles, rates and loads of the last samples, all as in the first one."""
        ages = ca.DM(range(DEPTH)) * SPACING
        channels = [ca.repmat(getattr(signals, channel), DEPTH, 1) for channel in CHANNELS]
        return ca.vertcat(ages, *channels)

    def transform_inputs(
        self, signals: Signals, memory: Expression, values: Values
    ) -> tuple[Signals, Expression]:
        """Angle, rate and load of `delay` ago, at most as old as the oldest stored sample."""
        ages = memory[:DEPTH] + signals.dt
        # The newest sample always stands first; the one before it stays if it is far from the next.
        # Ages differ, as no sample takes less than `symbolic.model.MIN_PERIOD`.
        keeps = ages[1] - ages[0] >= SPACING
        ages = _push_newest_sample(ages, 0, keeps)
        span = ages[1:] - ages[:-1]
        into = ca.fmax(0, ca.fmin(1, (values["delay"] - ages[:-1]) / span))
        late, parts = {}, [ages]
        for number, channel in enumerate(CHANNELS, start=1):
            past = memory[number * DEPTH : (number + 1) * DEPTH]
            values_ago = _push_newest_sample(past, getattr(signals, channel), keeps)
            late[channel] = values_ago[0] + ca.dot(into, values_ago[1:] - values_ago[:-1])
            parts.append(values_ago)
        return replace(signals, **late), ca.vertcat(*parts)


def _push_newest_sample(past: Expression, newest: Expression, keeps: Expression) -> Expression:
    """The newest value in front; behind it all of the past, or the past without its first."""
    return ca.vertcat(newest, ca.if_else(keeps, past[:-1], past[1:]))
