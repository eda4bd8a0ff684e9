"""What the tolerances of the rig's declared values add to a tuning.

Full slide measures mu times load and lever, so that an error of either is one of mu which no measurement
lowers: a parameter that is considered, not estimated, [Schmidt 1966]. An error of half-length or caster
also makes the patch stiffer or softer, as one of k does.
"""

from dataclasses import replace
from math import hypot

from observers.tuning import Tuning
from symbolic import Rig
from symbolic.deformation import full_slide_arm, unit_moment
from symbolic.parameters import EVEN, USUAL

_SMALL = 1e-3


def with_tolerances(tuning: Tuning, rig: Rig, k: float) -> Tuning:
    """The tuning with the floor of mu and the deviation of the stiffness that tolerances make.

    Args:
        tuning: its own floor and deviation are added to, in quadrature.
        rig: a and e with their tolerances; where none is declared, `symbolic.parameters.USUAL` counts.
        k: declared stiffness [N/m^2].
    """
    a = USUAL["a"] if rig.tolerances.a is None else rig.tolerances.a
    e = USUAL["e"] if rig.tolerances.e is None else rig.tolerances.e
    load = USUAL["load"] if rig.tolerances.load is None else rig.tolerances.load
    stiffness = USUAL["k"] if rig.tolerances.k is None else rig.tolerances.k / k
    arm = _spread(full_slide_arm, rig, a, e)
    patch = _spread(lambda a, e: unit_moment(0.0, a, e), rig, a, e)
    return replace(
        tuning,
        mu_floor=hypot(tuning.mu_floor, arm, EVEN * load),
        stiffness_std=max(hypot(tuning.stiffness_std, EVEN * stiffness, patch), _SMALL),
    )


def _spread(of, rig: Rig, a: float, e: float) -> float:  # type: ignore[no-untyped-def]
    """Relative standard deviation of a quantity of a and e within their tolerances [1]."""
    least = _SMALL * rig.a
    by_a = (of(rig.a + least, rig.e) - of(rig.a - least, rig.e)) / (2 * least)
    by_e = (of(rig.a, rig.e + least) - of(rig.a, rig.e - least)) / (2 * least)
    return float(EVEN * hypot(by_a * a, by_e * e) / of(rig.a, rig.e))
