"""Tunings by name, and the tuning that follows from what a diagnosis found of a model's error.

| name | for |
|---|---|
| `real_tyre` | a real tyre on ground that stays for a while; the default |
| `clean` | a torque that the model explains to its sensor's noise, as in simulation |
| `changing_ground` | a real tyre on ground that also changes little by little |
"""

from collections.abc import Mapping
from dataclasses import replace
from math import sqrt
from types import MappingProxyType

from observers.tuning import REFERENCE_STEP, Tuning
from symbolic import FoundModel, InvalidInputError, ModelError

CAR_ERROR = 0.03
"""Greatest `Tuning.error` of a car [1]: its contacts match their model better than a small wheel's."""
TURNING_RATE = 0.1
"""Yaw rate at which a correlation time is taken for a turn [rad/s]: that of hand-turned recordings."""
SENSOR_SHARE = 0.1
"""Least share of the model error that counts as white noise, however long its correlation time [1]."""
UNMEASURED_ERROR = 0.02
"""Error of a found model beside that measured, as a share of the torque [1]: an observer knows the rate
so far, a diagnosis the rate of the whole recording, and half-length and caster as they were in it."""
EXPLAINED = 2.5
"""Consistency beyond which a spread that was measured is exceeded [1]: chi-square with 40 degrees of
freedom over 40, which it exceeds about once in two million independent windows."""
UNSTEADY_ALARM = 7.0
"""Least `Tuning.alarm` where friction walks from stroke to stroke, or a gear has its own [1]."""
PROFILES: Mapping[str, Tuning] = MappingProxyType(
    {
        "real_tyre": Tuning(),
        "clean": Tuning(
            mu_walk=0.001, mu_floor=0.0, noise=0.02, error=0.02, error_travel=0.0, alarm=20.0,
            explained=EXPLAINED,
        ),
        "changing_ground": Tuning(mu_walk=0.02),
    }
)  # fmt: skip
"""The tuning of each profile."""


def profile(name: str) -> Tuning:
    """The tuning of a profile.

    Raises:
        InvalidInputError: there is none of this name.
    """
    if name not in PROFILES:
        raise InvalidInputError(f"unknown tuning {name!r}; allowed: {', '.join(PROFILES)}")
    return PROFILES[name]


def tuning_for(
    found: FoundModel | None,
    tuning: Tuning | None = None,
    by_hand: Mapping[str, float] | None = None,
    *,
    by_direction: bool = False,
    car: bool = False,
) -> Tuning:
    """A tuning with the error of the model that was found in place of its own, where that is known.

    Args:
        found: the model; None for the declared one.
        tuning: the tuning to begin with; None for `real_tyre`.
        by_hand: fields that go before all of that.
        by_direction: friction has one value each way; it walks as much as it did under that model.
        car: it is for a car, see `CAR_ERROR`; its tolerances count in full, without a floor.
    """
    tuning = Tuning() if tuning is None else tuning
    if car:
        tuning = replace(
            tuning, mu_floor=0.0, error=min(tuning.error, CAR_ERROR),
            alarm=max(tuning.alarm, UNSTEADY_ALARM),
        )  # fmt: skip
    if found is not None and found.error is not None:
        if found.basis is not None and found.basis.explains_nothing:
            tuning = replace(tuning, error=max(tuning.error, found.error.share_of_torque))
        else:
            tuning = with_model_error(tuning, found.error)
        if by_direction and found.error.friction_walk:
            alarm = max(tuning.alarm, UNSTEADY_ALARM)
            tuning = replace(tuning, mu_walk=found.error.friction_walk, alarm=alarm)
    return replace(tuning, **dict(by_hand or {}))  # type: ignore[arg-type]


def with_model_error(tuning: Tuning, error: ModelError) -> Tuning:
    """A tuning with this error of the model, nothing set by hand.

    The spread is what the torque of recordings that were not fitted differs by, noise of the sensor
    included; over a correlation time, which counts as the turn made in it at `TURNING_RATE`, it is worth
    one independent sample. `UNMEASURED_ERROR` was not measured and lasts as the tuning's own error does:
    the squares of both, over the turn that each lasts, add up.
    """
    if error.spread == 0:
        return tuning
    lasts = TURNING_RATE * error.correlation_time
    squares = error.share_of_torque**2 + UNMEASURED_ERROR**2
    measured = error.share_of_torque**2 / squares
    # An error that lasts for no longer than a sample is the sensor's noise.
    white = min(1.0, max(SENSOR_SHARE, REFERENCE_STEP / error.correlation_time))
    return replace(
        tuning, noise=white * error.spread, error=sqrt(squares),
        error_travel=measured * lasts + (1 - measured) * max(lasts, tuning.error_travel),
        explained=EXPLAINED,
    )  # fmt: skip
