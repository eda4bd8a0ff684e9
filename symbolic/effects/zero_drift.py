"""A zero of the torque channel that wanders while a recording runs.

A charge amplifier's output drifts with the charge that leaks in or out, a strain gauge's with its
temperature: over the seconds of one recording both do so in proportion to time. Reference: Gautschi,
Piezoelectric Sensorics (2002), on the drift of charge amplifiers.
"""

from dataclasses import dataclass

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Signals, Values


@dataclass(frozen=True, kw_only=True)
class ZeroDrift(Effect):
    """Adds rate times the time since the first sample, one rate a recording."""

    name: str = "zero_drift"
    summary: str = "the zero of the torque channel drifts with time"
    family = "sensor and steering"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="rate", unit="N m/s", neutral=0.0, start=0.005, lower=-5.0, upper=5.0, scale=0.05,
            scope="recording",
        ),
    )  # fmt: skip
    signatures: tuple[ResidualSignature, ...] = (ResidualSignature("time"),)
    memory: int = 1

    def initial(self, signals: Signals) -> Expression:
        """Before the first sample by its period, so that the time begins at zero there [s]."""
        return -signals.dt

    def transform_inputs(
        self, signals: Signals, memory: Expression, values: Values
    ) -> tuple[Signals, Expression]:
        """Add up the time."""
        return signals, memory + signals.dt

    def torque_of_memory(self, memory: Expression, values: Values) -> Expression:
        """How far the zero is off by now [N m]."""
        return values["rate"] * memory
