"""How sure it is that an effect that was found is the one that is missing."""

from typing import Literal

Grade = Literal["strong", "weak", "ambiguous", "stands_in"]
CLEAR_ERRORS = 3.0
"""Standard errors by which the judged error has to fall for a strong grade."""
CLEAR_BIC = -6.0
"""Change of the information criterion that is strong evidence (Kass and Raftery, JASA 90 (1995) 773)."""


def grade_of(standard_errors: float, delta_bic: float, *, has_rivals: bool, at_bound: bool) -> Grade:
    """The grade of an effect.

    Args:
        standard_errors: by how many the judged error fell when it was added, paired over blocks that
            outlast the correlation of the residual.
        delta_bic: change of the information criterion by its addition; negative speaks for it.
        has_rivals: whether the judged data cannot distinguish it from other effects.
        at_bound: whether one of its parameters ends where its range does.

    Returns:
        stands_in: it fits only with an implausible value, in place of something unknown;
        weak: what it gains may be chance; ambiguous: what it gains is clear, but others gain as much;
        strong: none of these.
    """
    if at_bound:
        return "stands_in"
    if not (standard_errors >= CLEAR_ERRORS and delta_bic <= CLEAR_BIC):
        return "weak"
    return "ambiguous" if has_rivals else "strong"
