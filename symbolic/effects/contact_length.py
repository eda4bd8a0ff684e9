"""A patch whose length follows the load.

Declared half-lengths are measured at some load, to as many millimetres as were read; a recording, and a
sample of it, at another load has another one. Reference: Besselink, Schmeitz, Pacejka, An improved Magic
Formula/Swift tyre model that can handle inflation pressure changes, Vehicle System Dynamics 48 (2010)
sup. 1, 337: half the contact length is a sum of terms in F_N and its square root.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from symbolic.bristle_patch import BristleTraits
from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Values

REFERENCE_LENGTH = 0.045
"""The a_0 that goes with the load F_0 [m]."""
USUAL_POWER = 2.0
"""Power of the load over declared half-lengths where these are all the same: no matter then [1]."""


@dataclass(frozen=True, kw_only=True)
class ContactLength(Effect):
    """Half-length a (F_N / F(a))^n, with F(a) = F_0 (a / a_0)^m the load that goes with a declared a.

    n = 0 is the declared half-length at any load, n = 1 / m one that depends on the load alone. As the
    patch grows bristles keep their place and deformation; what newly touches the ground is undeformed.

    F_0 and m are never fitted: they are the line of logarithms through the declared half-lengths and
    mean loads of the recordings, so that the declared lengths hold on the average. Another F_0 is nearly
    another mu and k, exactly so for e = 0.
    """

    name: str = "contact_length"
    summary: str = "the length of the contact patch follows the load"
    family = "contact over load"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="n", unit="1", neutral=0.0, start=0.3, lower=0.0, upper=1.0, scale=0.2),
        Parameter(
            name="F_0", unit="N", neutral=None, start=400.0, lower=1e-3, upper=1e9, scale=100.0,
            fixed=True,
        ),
        Parameter(
            name="m", unit="1", neutral=None, start=USUAL_POWER, lower=1.0, upper=5.0, scale=1.0,
            fixed=True,
        ),
    )  # fmt: skip
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the load"),
        ResidualSignature("the torque times the load", rank=1),
    )
    of_lengths: bool = True

    def fixed_values(self, a: Sequence[float], F_N: Sequence[float]) -> Mapping[str, float]:
        """F_0 and m, see above; m within its bounds."""
        lengths, loads = np.log(np.divide(a, REFERENCE_LENGTH)), np.log(F_N)
        spread = lengths - lengths.mean()
        m = USUAL_POWER
        if np.ptp(lengths) > 1e-6:
            m = float(np.clip(spread @ loads / (spread @ spread), 1.0, 5.0))
        return {"F_0": float(np.exp(loads.mean() - m * lengths.mean())), "m": m}

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """Let the patch grow."""

        def growth(F_N: Expression, a: Expression) -> Expression:
            more = (F_N / (values["F_0"] * (a / REFERENCE_LENGTH) ** values["m"])) ** values["n"]
            return more if traits.growth is None else more * traits.growth(F_N, a)

        return replace(traits, growth=growth)
