"""How sure it is that an effect that was found is the one that is missing."""

import math
from collections.abc import Mapping
from typing import Literal

from identification.parameter_estimate import ParameterEstimate
from symbolic import Effect

Grade = Literal["strong", "weak", "ambiguous", "stands_in"]
CLEAR_ERRORS = 3.0
"""Standard errors by which the judged error has to fall, and deviations that a parameter has to be off
its neutral value, for a finding."""
CLEAR_BIC = -6.0
"""Change of the information criterion that is strong evidence (Kass and Raftery, JASA 90 (1995) 773)."""


def distance_from_neutral(effect: Effect, estimates: Mapping[str, ParameterEstimate]) -> float | None:
    """Standard deviations between an effect's parameters and no effect at all, of the clearest one.

    Args:
        effect: whose parameters say where it vanishes.
        estimates: by name, of a recording's or a ground's own as `M_0 [fem1]`.

    Returns:
        None where no such parameter has a deviation.
    """
    neutral = {parameter.name: parameter.neutral for parameter in effect.parameters}
    distances = []
    for label, estimate in estimates.items():
        vanishes = neutral.get(label.split(" [")[0])
        if vanishes is None or not estimate.std or not math.isfinite(estimate.std):
            continue
        # What vanishes at infinity, as a stiffness, is off it by its own inverse: value over deviation.
        off = estimate.value - vanishes if math.isfinite(vanishes) else estimate.value
        distances.append(abs(off) / estimate.std)
    return max(distances, default=None)


def grade_of(
    standard_errors: float,
    delta_bic: float,
    distance: float | None = None,
    *,
    has_rivals: bool,
    at_bound: bool,
) -> Grade:
    """The grade of an effect.

    Args:
        standard_errors: by how many the judged error fell when it was added, paired over blocks that
            outlast the correlation of the residual.
        delta_bic: change of the information criterion by its addition; negative speaks for it.
        distance: of its parameters from no effect at all, see `distance_from_neutral`.
        has_rivals: whether the judged data cannot distinguish it from other effects.
        at_bound: whether one of its parameters ends where its range does.

    Returns:
        stands_in: it fits only with an implausible value, in place of something unknown;
        weak: what it gains may be chance; ambiguous: what it gains is clear, but others gain as much;
        strong: none of these.
    """
    if at_bound:
        return "stands_in"
    off = math.inf if distance is None else distance
    if not (min(standard_errors, off) >= CLEAR_ERRORS and delta_bic <= CLEAR_BIC):
        return "weak"
    return "ambiguous" if has_rivals else "strong"
