"""Friction over sliding speed by a law that the library does not have: a spline over log speed.

Its slope over ln v changes at 2 and 6 mm/s. With equal slopes it is
`rate_friction`. The ramps ln sqrt(v^2 + v_k^2) are smooth, so that the kinks are a factor of about two
wide in speed, as in a transition of Stribeck's; compare the empirical master curves in Grosch, Proc. R.
Soc. A 274 (1963) 21.
"""

from dataclasses import dataclass

import casadi as ca

from symbolic.bristle_patch import BristleTraits
from symbolic.bristle_slip import REFERENCE_SPEED, REST_SPEED
from symbolic.effects.base import Effect, Expression, Parameter, Values, with_limit
from symbolic.effects.rate_friction import MIN_FACTOR

KNOTS = (REST_SPEED, 2e-3, 6e-3)
"""Speeds at which a slope begins [m/s]."""
SLOPES = ("slow", "middle", "fast")
"""Their names, slopes of the factor over ln v [1]."""


@dataclass(frozen=True, kw_only=True)
class SpeedLaw(Effect):
    """Limit times a function of ln v, v = |x - e| |psi_dot|, that is 1 at 1 mm/s."""

    name: str = "speed_law"
    summary: str = (
        "friction changes with sliding speed by a law of its own; the model's mu is friction at 1 mm/s"
    )
    family = "friction over speed"
    flexible = True
    parameters: tuple[Parameter, ...] = tuple(
        Parameter(
            name=name, unit="1", neutral=0.0, start=0.02, lower=-3.0, upper=3.0, scale=0.05,
            of="friction",
        )
        for name in SLOPES
    )  # fmt: skip

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """The limit of each bristle follows the speed at which the wheel drives it."""

        def factor(speed: Expression) -> Expression:
            ramps = [ca.log((speed**2 + v**2) / (REFERENCE_SPEED**2 + v**2)) / 2 for v in KNOTS]
            growth: Expression = 0
            for name, ramp, above in zip(SLOPES, ramps, [*ramps[1:], 0], strict=True):
                growth = growth + values[name] * (ramp - above)
            return ca.fmax(MIN_FACTOR, 1 + growth)

        return with_limit(traits, factor)
