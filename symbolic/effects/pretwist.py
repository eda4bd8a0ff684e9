"""A patch that is already deformed at the first sample.

[Györök 2022], section 3.1, assumes zero deformation at t = 0; this effect drops the assumption.
"""

from dataclasses import dataclass

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Values


@dataclass(frozen=True, kw_only=True)
class Pretwist(Effect):
    """A virgin patch was turned by psi_0 before the first sample, one value a recording."""

    name: str = "pretwist"
    summary: str = "the patch is deformed before the recording begins"
    family = "sensor and steering"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="psi_0", unit="rad", neutral=0.0, start=0.02, lower=-1.0, upper=1.0, scale=0.05,
            scope="recording",
        ),
    )  # fmt: skip
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("a constant of each recording", rank=1),
        ResidualSignature("time"),
        ResidualSignature("the initial twist that remains"),
    )

    def initial_angle(self, values: Values) -> Expression:
        """Angle turned before the recording begins [rad]."""
        return values["psi_0"]
