"""The uncertainty budget of an estimate: what its standard deviation is made of."""

from math import hypot, sqrt

import numpy as np

from observers.compiled_step import compiled_stretch, first_sample, run_stretches
from observers.estimators.model_observer import ModelObserver
from observers.interfaces.run import samples_and_first_index
from observers.planning.forecast import Forecast, irreducible_mu_std
from observers.planning.steering_limits_and_paths import SteeringPath
from observers.protocol import OUTPUT, SAMPLE
from observers.quality.acquisition import OWN
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.trajectory_sensitivity import SAMPLES_PER_CALL

SLOPE = "slope of the torque that k does not explain"
"""How much the torque grows with the angle, beyond what k and its tolerance say."""
REST = "noise and the model's error"
_AT_ONCE = 100 * SAMPLES_PER_CALL
"""Samples whose states are held at once."""


def uncertainty_budget(
    observer: ModelObserver,
    at: int,
    t: Array,
    psi: Array,
    F_N: Array,
    M_z: Array | None = None,
    psi_dot: Array | None = None,
    *,
    M: Array | None = None,
) -> dict[str, float]:
    """Relative standard deviation of mu after a sample, by cause [1]; its square is the sum of squares.

    The tolerances of lengths and load, `Tuning.mu_floor` and dry friction stay as they are however the
    wheel is steered. `SLOPE` is by how much the torque grows otherwise with the angle than k and its
    tolerance say, as far as that was known when friction was acquired. `REST` is the filter's own
    variance. `at` is the index of a sample at which friction is usable, all other arguments are as for
    `observers.run`.

    Raises:
        InvalidInputError: nothing is known at this sample; or as of `observers.run`.
    """
    samples, begins = samples_and_first_index(observer, t, psi, F_N, M_z, psi_dot, M)
    if not begins <= at < samples.shape[1]:
        raise InvalidInputError(f"at must be from {begins} to {samples.shape[1] - 1}, got {at}")
    used = samples[:, begins : at + 1]
    state, stretch = observer.init(first_sample(used)).values, compiled_stretch(observer.screened_step)
    for first in range(0, used.shape[1], _AT_ONCE):
        some = used[:, first : first + _AT_ONCE]
        state = run_stretches(stretch, state, some, observer.constants, result=0)[:, -1]
    places = observer.layout.places
    output = dict(zip(OUTPUT, state[places["output"][0]].tolist(), strict=True))
    own = dict(zip(OWN, state[places["own"][0]].tolist(), strict=True)) if observer.acquire else {}
    loads = used[SAMPLE.index("F_N")]
    # Dry friction counts before the results are multiplied by s.
    mu = output["mu"] / own.get("scale", 1.0)
    budget = irreducible_mu_std(observer, mu, float(loads[np.isfinite(loads)][-1]))
    budget[SLOPE] = own.get("excess", 0.0)
    rest = (output["mu_std"] / output["mu"]) ** 2 - sum(part**2 for part in budget.values())
    return {**budget, REST: sqrt(max(0.0, rest))}


def largest_uncertainty_part(
    observer: ModelObserver, path: SteeringPath, forecast: Forecast, F_N: float, at: int
) -> tuple[str, float, float]:
    """Largest part of a forecast's deviation at a sample, its cause first, and all that stays [1].

    What stays is lowered by no steering. The load is in N.
    """
    path, torque = path.first_samples(at + 1), {observer.channel: forecast.torque[: at + 1]}
    load = np.full(at + 1, F_N)
    budget = uncertainty_budget(observer, at, path.t, path.psi, load, **torque)
    cause = max(budget, key=lambda name: budget[name])
    stays = irreducible_mu_std(observer, float(forecast.mu[at]), F_N)
    return cause, budget[cause], hypot(*stays.values())
