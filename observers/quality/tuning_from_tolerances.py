"""What a rig declares and its tuning takes: tolerances of its values, the range of its torque sensor.

Full slide measures mu times load and lever, so that an error of either is one of mu which no measurement
lowers: a parameter that is considered, not estimated, [Schmidt 1966]. An error of half-length or caster
also makes the patch stiffer or softer, as one of k does. A sensor that ends looks like full slide: what
is near the end is left out.
"""

from dataclasses import replace
from math import hypot

from observers.tuning import Tuning
from symbolic import Rig
from symbolic.parameters import EVEN, USUAL, relative_std_by_lengths
from symbolic.patch_moment import full_slide_arm, unit_corner_moment

OF_LENGTHS = "tolerances of half-length and caster"
OF_LOAD = "tolerance of the load"
OF_SCALE = "scale of the torque, by what is declared beside the load or found"
OF_TUNING = "mu_floor of the tuning"
"""Causes of a floor of mu."""
LEAST_STIFFNESS = 1.5
"""Least deviation of the stiffness over the model's error [1], that of an undeclared k at most: a torque
that is off by that error tells k no closer, and a k that is declared closer would never be confirmed."""


def tuning_with_tolerances(tuning: Tuning, rig: Rig, stiffness: float) -> Tuning:
    """The tuning with the floor of mu and the deviation of the stiffness that tolerances make.

    They add to its own in quadrature; where no tolerance is declared, `symbolic.parameters.USUAL`
    counts. Its limit of the torque is within the range of the sensor. stiffness is the rig's k [N/m^2].
    """
    tolerance = USUAL["k"] if rig.tolerances.k is None else rig.tolerances.k / stiffness
    patch = relative_std_by_lengths(lambda a, e: unit_corner_moment(0.0, a, e), rig)
    least = min(LEAST_STIFFNESS * tuning.error, EVEN * USUAL["k"])
    return replace(
        tuning,
        torque_limit=min(tuning.torque_limit, rig.torque_limit),
        mu_floor=hypot(*friction_floor(tuning, rig).values()),
        stiffness_std=max(hypot(tuning.stiffness_std, EVEN * tolerance, patch), least),
    )


def friction_floor(tuning: Tuning, rig: Rig) -> dict[str, float]:
    """Deviations that no measurement lowers, by cause, as shares of mu [1]; they add in quadrature."""
    load = USUAL["load"] if rig.tolerances.load is None else rig.tolerances.load
    return {
        OF_LENGTHS: relative_std_by_lengths(full_slide_arm, rig),
        OF_LOAD: EVEN * load,
        OF_SCALE: EVEN * rig.tolerances.scale,
        OF_TUNING: tuning.mu_floor,
    }
