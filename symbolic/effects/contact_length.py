"""A patch that grows with the load it carries.

Source: Hertz's law for a sphere, a ~ F_N^(1/3) (Johnson, Contact Mechanics, Cambridge 1985, sec. 4.2);
a tyre's half-length lies between that and the square root of the load (Pacejka, Tire and Vehicle
Dynamics, 3rd ed. 2012). A declared half-length holds at one load, to as many millimetres as were read.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symbolic.effects.base import Effect, Expression, Parameter, Signals, Values

REFERENCE_LENGTH = 0.045
"""The a_0 that goes with the load F_0 [m]."""


@dataclass(frozen=True, kw_only=True)
class ContactLength(Effect):
    """Half-length a (F_N / F(a))^n, with F(a) = F_0 (a / a_0)^3 the load that goes with a declared a.

    n = 0 is the declared half-length at any load, n = 1/3 Hertz's at any declared one. As the patch
    grows, every bristle keeps its place and its deformation as shares of the length.

    F_0 is never fitted: with another one the same torque comes from another mu and k. It is such that
    the declared half-lengths hold on the average of the recordings.
    """

    name: str = "contact_length"
    summary: str = "the contact patch grows with the load"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="n", unit="1", neutral=0.0, start=0.1, lower=0.0, upper=1.0, scale=0.2),
        Parameter(
            name="F_0",
            unit="N",
            neutral=None,
            start=400.0,
            lower=1e-3,
            upper=1e9,
            scale=100.0,
            given=True,
        ),
    )
    discrete: bool = True

    def given(self, a: Sequence[float], F_N: Sequence[float]) -> Mapping[str, float]:
        """F_0, the geometric mean of the loads, each brought to the length a_0."""
        loads = np.log(F_N) - 3 * np.log(np.divide(a, REFERENCE_LENGTH))
        return {"F_0": float(np.exp(loads.mean()))}

    def half_length(self, signals: Signals, a: Expression, values: Values) -> Expression:
        """Factor on the declared half-length [1]."""
        expected = values["F_0"] * (a / REFERENCE_LENGTH) ** 3
        return (signals.F_N / expected) ** values["n"]
