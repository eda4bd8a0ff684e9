"""What a probe advises."""

from dataclasses import dataclass

from observers.protocol import Estimate


@dataclass(frozen=True, kw_only=True, slots=True)
class Advice:
    """Advice what to steer now.

    Attributes:
        psi: angle for the next sample [rad].
        psi_dot: rate there [rad/s].
        toward: angle at which to turn back, or to end [rad].
        finished: friction is known to the target.
        stopped: it cannot be, see `reason`; the wheel is to stay.
        reason: why it has stopped; empty else.
        travel: of the wheel so far [rad].
        left: travel that is expected until the target [rad]; NaN where none is.
        estimate: of the observer.
    """

    psi: float
    psi_dot: float
    toward: float
    finished: bool
    stopped: bool
    reason: str
    travel: float
    left: float
    estimate: Estimate
