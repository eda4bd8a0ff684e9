"""An effect of somebody else's, with one number in memory."""

from dataclasses import dataclass
from typing import Any

import casadi as ca

from symbolic import Effect, Parameter


@dataclass(frozen=True, kw_only=True)
class Warmth(Effect):
    """Friction that falls with one number in memory."""

    name: str = "warmth"
    summary: str = "a rubber that warms up loses friction"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="loss", unit="1", neutral=0.0, start=0.3, lower=0.0, upper=0.9, scale=0.1),
    )
    memory: int = 1

    def initial(self, signals: Any) -> Any:
        del signals
        return 0

    def transform_inputs(self, signals: Any, memory: Any, values: Any) -> tuple[Any, Any]:
        del values
        return signals, memory + signals.dt * (ca.fabs(signals.psi_dot) - memory)

    def friction(self, signals: Any, memory: Any, values: Any) -> Any:
        del signals
        return 1 - values["loss"] * ca.tanh(memory)
