"""Zero error of the torque channel.

[Györök 2022], section 5.3, subtracts such offsets by hand before the evaluation.
"""

from dataclasses import dataclass

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Signals, Values


@dataclass(frozen=True, kw_only=True)
class TorqueOffset(Effect):
    """Adds M_0 to the torque, one value a recording."""

    name: str = "torque_offset"
    summary: str = "the torque channel has a zero error"
    family = "sensor and steering"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="M_0", unit="N m", neutral=0.0, start=0.05, lower=-50.0, upper=50.0, scale=0.5,
            scope="recording",
        ),
    )  # fmt: skip
    signatures: tuple[ResidualSignature, ...] = (ResidualSignature("a constant of each recording"),)

    def torque(self, signals: Signals, values: Values) -> Expression:
        """The zero error [N m]."""
        return values["M_0"]
