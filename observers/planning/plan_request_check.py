"""What a plan may be asked for: a target, limits, frictions and a load."""

from collections.abc import Sequence
from math import inf

from observers.estimators.model_observer import ModelObserver
from observers.planning.forecast import unreachable_target_text
from observers.planning.steering_limits_and_paths import SteeringLimits, swings_within_limits
from observers.tuning import NO_LIMIT
from symbolic import InvalidInputError
from symbolic.rig_and_tyre import FRICTION

MUS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.2)
"""Prior of mu: a car's grounds from ice to dry asphalt [1]."""
MIN_SAMPLES, MIN_TARGET = 10, 1e-3
"""Least number of samples of a path; least target that makes sense [1]."""


def check_plan_request(
    observer: ModelObserver, target: float, limits: SteeringLimits, mus: Sequence[float], dt: float,
    F_N: float | None = None,
) -> None:  # fmt: skip
    """Refuse what no steering can fulfil; without a load [N], what none can under any load.

    That is a target, friction or load out of range, limits that leave no rate or too few samples dt
    apart [s], and a target below what no steering lowers, on every ground.
    """
    if not MIN_TARGET <= target < 1:
        raise InvalidInputError(
            f"target must be a share of mu from {MIN_TARGET:g} to below 1, got {target:g}"
        )
    if not mus or not all(FRICTION[0] <= mu <= FRICTION[1] for mu in mus):
        raise InvalidInputError(
            f"frictions must be from {FRICTION[0]:g} to {FRICTION[1]:g}, got {list(mus)}"
        )
    if F_N is not None and not 0 < F_N < NO_LIMIT:
        raise InvalidInputError(f"the load must be greater than 0 N, got {F_N:g}")
    if limits.time < (least := MIN_SAMPLES * dt):
        raise InvalidInputError(f"limit time must be at least {least:g} s, got {limits.time:g}")
    swings_within_limits(limits, coarse=True)
    # A torque's zero and friction count the less the greater the load.
    hopeless = [unreachable_target_text(observer, target, mu, inf if F_N is None else F_N) for mu in mus]
    if all(hopeless):
        raise InvalidInputError(f"mu = {mus[-1]:g}: {hopeless[-1]}: ask for well above that")
