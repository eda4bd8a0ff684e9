"""Options of a fit, as one frozen value."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from identification.fits.loss import LEAST_SQUARES, Loss
from symbolic import InvalidInputError

OwnerAndName = tuple[str | None, str]
"""Whose a parameter's value is (a recording, a ground, None for all of them), and its name."""


@dataclass(frozen=True, kw_only=True)
class FitOptions:
    """How a fit is made.

    Attributes:
        loss: cost of a residual.
        tolerance: relative change of the cost and of the scaled parameters at which the fit ends.
        max_evaluations: simulations of the whole set of recordings after which it ends all the same.
        free_shared: False keeps every shared parameter at its start and fits only what belongs to a
            recording, as on held-out data.
        fixed: further parameters that keep their start.
        reweightings: how often the fit is repeated at most because its residuals give another weight to
            what was declared with a tolerance.
        prior_weights: that weight at first by recording, their mean for one without; None for those that
            the residuals at the start give.
        threads: recordings simulated at a time; the result is the same.

    Raises:
        InvalidInputError: the tolerance is not greater than 0, or no evaluation is allowed.
    """

    loss: Loss = LEAST_SQUARES
    tolerance: float = 1e-6
    max_evaluations: int = 60
    free_shared: bool = True
    fixed: Collection[OwnerAndName] = ()
    reweightings: int = 2
    prior_weights: Mapping[str, float] | None = None
    threads: int = 1

    def __post_init__(self) -> None:
        """Check the ranges."""
        if not self.tolerance > 0:
            raise InvalidInputError(f"tolerance must be greater than 0, got {self.tolerance}")
        if not self.max_evaluations >= 1:
            raise InvalidInputError(f"max_evaluations must be at least 1, got {self.max_evaluations}")


FINE_FIT = FitOptions()
"""For whatever is reported."""
COARSE_FIT = FitOptions(tolerance=1e-3, max_evaluations=20, reweightings=1)
"""For models that are only ranked, from the values of a model that is nearly the same."""
