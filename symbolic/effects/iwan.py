r"""Iwan's model: Jenkins elements in parallel, whose slip limits have a free distribution.

A Jenkins element, or Prandtl's, is a spring in series with a slider: an elastoplastic stop. Any odd
hysteresis without rate is such elements in parallel, each of which slips at a turn of its own (Maxwell
slip), and obeys Masing's rules. The declared patch is one such model: with u = \|x\| / a and e = 0 its
bristle at u has the stiffness 3 u^2 du of the whole and slips at a turn in proportion to (1 - u^2) / u.
Here it slips in proportion to

    (1 - u^plateau)^early u^(-late).

early is the spread of the limits towards zero: near it the density of limits is a power 1/early - 1 of
the limit, so that the work of a small cycle grows with the amplitude to the power 2 + 1/early. late is
their spread towards large ones; below zero elements in the middle slip early too. The larger plateau,
the more elements slip together. With the total stiffness, by k, and the total limit, mu times that of
the declared patch, these are five parameters. Segalman's four are among them where his beta is 0: early
is 1 / (1 + chi), late 0, plateau 3; a larger plateau stands for his beta.

References: [Iwan 1966]; [Segalman 2005]; [Lampaert 2003] on Maxwell slip.
"""

from dataclasses import dataclass
from math import log, pi

import casadi as ca

from symbolic.bristle_patch import BristleTraits
from symbolic.effects.base import Effect, Expression, Parameter, ResidualSignature, Values, with_shape

MIN_ELEMENT_U = 1e-9
"""Least u of an element, whose limit may be infinite in the middle [1]."""
_SHIFT = 8
"""Stirling's series is taken this far beyond its argument, where it is right to rounding."""


@dataclass(frozen=True, kw_only=True)
class IwanContact(Effect):
    """Limits ~ (1 - u^plateau)^early u^(1 - late), at the same total for e = 0; see above.

    Files know it as `stops`.
    """

    name: str = "stops"
    summary: str = "the contact is no parabola but stops with limits of their own"
    family = "compliance and contact shape"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="early", unit="1", neutral=1.0, start=0.8, lower=0.02, upper=10.0, scale=0.5),
        Parameter(name="late", unit="1", neutral=1.0, start=0.7, lower=-1.0, upper=1.9, scale=0.5),
        Parameter(name="plateau", unit="1", neutral=2.0, start=3.0, lower=0.5, upper=40.0, scale=2.0),
    )
    signatures: tuple[ResidualSignature, ...] = (
        ResidualSignature("the angle", rank=2),
        ResidualSignature("the rate of the torque", rank=3),
    )

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """Replace the parabola by the limits of the elements, over the pressure of one unit of load."""
        early, late, plateau = values["early"], values["late"], values["plateau"]
        # The total limit is 3/8 for the parabola, and a Beta function for the elements.
        level = 0.1875 * plateau / beta_function((3 - late) / plateau, early + 1)

        def factor(u: Expression) -> Expression:
            place = ca.log(ca.fmax(ca.fabs(u), MIN_ELEMENT_U))
            limit = early * ca.log(-ca.expm1(plateau * place)) + (1 - late) * place
            return level * ca.exp(limit) / (0.75 * (1 - u**2))

        return with_shape(traits, factor)


EFFECTS = (IwanContact(),)
"""For `--effects symbolic.effects.iwan`: no search tries them unless asked to."""


def beta_function(p: Expression, q: Expression) -> Expression:
    """Euler's Beta function of arguments > 0, which casadi lacks [1]."""
    return ca.exp(_log_gamma(p) + _log_gamma(q) - _log_gamma(p + q))


def _log_gamma(z: Expression) -> Expression:
    """Stirling's series, [Abramowitz 1964], (6.1.41), behind the recurrence (6.1.15)."""
    w, below = z + _SHIFT, 0
    for i in range(_SHIFT):
        below = below + ca.log(z + i)
    series = 1 / (12 * w) - 1 / (360 * w**3) + 1 / (1260 * w**5) - 1 / (1680 * w**7)
    return (w - 0.5) * ca.log(w) - w + log(2 * pi) / 2 + series - below
