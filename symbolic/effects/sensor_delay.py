"""Torque and angle channels that are not simultaneous.

The torque measured now was made by an earlier angle. The effect keeps the last samples of angle and
rate and reads them `delay` ago, linearly between samples, so it works sample by sample on a target.

Source: the author's published simulation files carry the torque one sample, 10 ms, late.
"""

from dataclasses import dataclass, replace

import casadi as ca

from symbolic.effects.base import Effect, Expression, Parameter, Signals, Values

DEPTH = 16
"""Samples remembered; at 100 Hz they reach 150 ms back."""
SHORTEST = 1e-9
"""Guard against samples of equal time [s]."""


@dataclass(frozen=True, kw_only=True)
class SensorDelay(Effect):
    """The patch sees the angle of `delay` ago; the torque channel is late."""

    name: str = "sensor_delay"
    summary: str = "the torque channel is late against the angle"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="delay", unit="s", neutral=0.0, start=0.004, lower=0.0, upper=0.15, scale=0.01),
    )
    memory: int = 3 * DEPTH

    def initial(self, signals: Signals) -> Expression:
        """Ages, angles and rates of the last samples, all at the first one."""
        ages = ca.linspace(ca.DM(0), ca.DM(DEPTH - 1), DEPTH) * signals.dt
        return ca.vertcat(ages, ca.repmat(signals.psi, DEPTH, 1), ca.repmat(signals.psi_dot, DEPTH, 1))

    def sense(self, signals: Signals, memory: Expression, values: Values) -> tuple[Signals, Expression]:
        """The angle and the rate of `delay` ago; older than the memory holds, the oldest."""
        ages = ca.vertcat(0, memory[: DEPTH - 1] + signals.dt)
        angles = ca.vertcat(signals.psi, memory[DEPTH : 2 * DEPTH - 1])
        rates = ca.vertcat(signals.psi_dot, memory[2 * DEPTH : -1])
        span = ca.fmax(ages[1:] - ages[:-1], SHORTEST)
        into = ca.fmax(0, ca.fmin(1, (values["delay"] - ages[:-1]) / span))
        late = replace(
            signals,
            psi=angles[0] + ca.dot(into, angles[1:] - angles[:-1]),
            psi_dot=rates[0] + ca.dot(into, rates[1:] - rates[:-1]),
        )
        return late, ca.vertcat(ages, angles, rates)
