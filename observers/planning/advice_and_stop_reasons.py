"""What a probe advises, and why it stops: what no steering lowers, or the limit that binds, in words."""

from dataclasses import dataclass
from math import exp, hypot, log

from observers.estimators.model_observer import ModelObserver
from observers.planning.forecast import irreducible_mu_std, percent_text_beside_target
from observers.planning.plan import Plan
from observers.planning.steering_limits_and_paths import SteeringLimits
from observers.protocol import Estimate, Status

VAGUE = 0.15
"""Deviation of ln mu below which one friction stands for all [1]."""
MAX_DEVIATION = 5.0
"""Deviation of ln mu within which all frictions are [1]."""
AT_LIMIT = 0.95
"""Share of the limit of the angle from which on the wheel has come to it [1]."""


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


def irreducible_reason_text(
    observer: ModelObserver, target: float, estimate: Estimate, F_N: float, greatest: float,
    excess: float,
) -> str:  # fmt: skip
    """Why no steering reaches a target under a load [N]; empty where one may, or the load is missing.

    A vague estimate counts as the greatest friction of the prior, at which the least remains; excess is
    what this run adds to the deviation for good, as its torque is not that of the declared stiffness.
    """
    if not F_N > 0:
        return ""
    is_vague = not estimate.mu_std < VAGUE * estimate.mu
    mu = greatest if is_vague else estimate.mu
    causes = irreducible_mu_std(observer, mu, F_N)
    declared = hypot(*causes.values())
    causes["a stiffness that is not the declared one, or not known better"] = excess
    floor = hypot(*causes.values())
    if not floor >= target:
        return ""
    cause = max(causes, key=lambda name: causes[name])
    remains = f"{percent_text_beside_target(floor, target)} remains, most of it by {cause}"
    above = "ask for well above that"
    if declared >= target:
        ground = "" if is_vague else f" on mu = {mu:.2g}"
        return f"{target:.1%} of mu cannot be reached by any steering{ground}: {remains}; {above}"
    # Another run, with another noise, may find the stiffness closer to the declared one.
    return (
        f"{target:.1%} of mu cannot be reached in this run: by its estimate {remains}; begin anew with a"
        f" patch free of torque, or {above}"
    )


def time_limit_reason_text(
    plan: Plan, estimate: Estimate, limits: SteeringLimits, farthest: float, held: str
) -> str:
    """What kept the target out of reach in the time, and what would do.

    farthest is the greatest angle from the first one [rad], held what the torque's limit has left of it.
    """
    deviation = estimate.mu_std / estimate.mu
    over = (
        f"the time of {limits.time:g} s is over at {percent_text_beside_target(deviation, plan.target)}"
    )
    if deviation <= plan.target:
        lacks = "but moved by more than that lately" if estimate.usable else "but not usable"
        over = f"{over}, within {plan.target:.1%} {lacks}"
    # A flag of the sensors goes first; that friction is being acquired is said better by the limits.
    is_flagged = estimate.status & ~(Status.ACQUIRING | Status.BOUND)
    told = [over, estimate.remedy if is_flagged else "", held, unreached_friction_text(plan, estimate)]
    if not any(told[1:]):
        is_at_limit = farthest >= AT_LIMIT * limits.angle
        told += [
            f"the wheel came to the limit of angle, {limits.angle:g} rad: a wider one, more time"
            " or a wider target may do" if is_at_limit
            else "no limit but the time was met: more time or a wider target may do"
        ]  # fmt: skip
    return "; ".join(filter(None, told))


def unreached_friction_text(plan: Plan, estimate: Estimate) -> str:
    """What a plan said of the nearest likely friction that it does not reach; empty for none."""
    unreached = [mu for mu, at in zip(plan.mus, plan.reached, strict=True) if at is None]
    mu = estimate.mu_eff if estimate.mu_eff > 0 else estimate.mu
    deviation = estimate.mu_std / estimate.mu
    # At least those on either side of the estimate.
    low = max((one for one in plan.mus if one <= mu), default=min(plan.mus))
    high = min((one for one in plan.mus if one >= mu), default=max(plan.mus))
    # Of a deviation of all that may be, the exponential overflows.
    reach = exp(2 * min(deviation, MAX_DEVIATION))
    low, high = min(low, mu / reach), max(high, mu * reach)
    likely = (item for item in zip(unreached, plan.reasons, strict=True) if low <= item[0] <= high)
    _, reason = min(likely, key=lambda item: abs(log(item[0] / mu)), default=(mu, ""))
    return reason and f"as planned for {reason}"
