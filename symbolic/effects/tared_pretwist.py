"""A patch that is twisted alike before every recording, and a torque that was set to zero on it.

A load cell is tared before a run. A wheel that was lowered or aligned just then is rarely free of twist,
and what the patch bears at that moment is missing from every later sample. [Györök 2022], section 5.3,
subtracts such offsets before the evaluation. `pretwist` and `torque_offset` have values of their own for
each recording; wheels that are aligned and tared in the same way share them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Signals, Values


@dataclass(frozen=True, kw_only=True)
class TaredPretwist(Effect):
    """A virgin patch was turned by psi_0 before the first sample, at which the torque became zero.

    M_0 is what that took off. It is not fitted: it follows from psi_0, see `Effect.tare`.
    """

    name: str = "tared_pretwist"
    summary: str = "every recording begins with the same twist, on which the torque was set to zero"
    family = "sensor and steering"
    parameters: tuple[Parameter, ...] = (
        Parameter(
            name="psi_0", unit="rad", neutral=0.0, start=0.005, lower=-0.05, upper=0.05, scale=0.01
        ),
        Parameter(
            name="M_0", unit="N m", neutral=0.0, start=0.05, lower=-1e9, upper=1e9, scale=0.5, fixed=True
        ),
    )  # fmt: skip
    tare: str = "M_0"
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("a constant of each recording", rank=1),
        ResidualSignature("the initial twist that remains"),
    )

    def fixed_values(self, a: Sequence[float], F_N: Sequence[float]) -> Mapping[str, float]:
        """None taken off, until a fit knows the twist [N m]."""
        return {"M_0": 0.0}

    def initial_angle(self, values: Values) -> Expression:
        """Angle turned before the recording begins [rad]."""
        return values["psi_0"]

    def torque(self, signals: Signals, values: Values) -> Expression:
        """What the taring added [N m]."""
        return values["M_0"]
