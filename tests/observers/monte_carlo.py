"""Seeded runs on the rig, friction drawn from the observer's own prior, and what errors they show."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from observers import AligningTorque, Estimates, SteeringTorque, run
from reference_rig import (
    FOURTEEN_BIT_STEP,
    WALK_KNOT,
    Friction,
    GroundRecording,
    SteeringRecording,
    constant_friction,
    friction_between,
    full_slide_moment,
    make_ground_recording,
    make_steering_recording,
)
from symbolic.float_array_type import Array
from tests.observers.conftest import make
from tests.observers.factories import columns_of, slide

Recording = GroundRecording | SteeringRecording
PRIOR = {"mu": 1.0, "mu_std": 0.5}
"""ln mu is normal about ln 1 with standard deviation 0.5."""
LEAST, GREATEST = 0.3, 2.3
"""Draws beyond are thrown back on these [1]."""
NOISE = 0.004
"""Standard deviation of the torque noise over the torque's range [1]."""
ALLOWANCE = 1.05
"""What encoder and load noise add to it [1]."""
SLID = 0.9
"""Share of the full-slide torque from which on a run counts as slid [1]."""


def drawn(seed: int) -> float:
    """Friction coefficient from the prior [1]."""
    ln_mu = np.random.default_rng([seed, 99]).normal(np.log(PRIOR["mu"]), PRIOR["mu_std"])
    return float(np.clip(np.exp(ln_mu), LEAST, GREATEST))


def ground(seed: int, walk: float = 0.0, duration: float = 10.0) -> Friction:
    """Friction that begins with the draw and walks by a share of itself [1/sqrt(s)], or stays."""
    if walk == 0:
        return constant_friction(drawn(seed))
    t = np.arange(round(duration / WALK_KNOT) + 1) * WALK_KNOT
    steps = np.random.default_rng([seed, 98]).standard_normal(t.size - 1) * np.sqrt(WALK_KNOT)
    return friction_between(t, drawn(seed) * np.exp(walk * np.concatenate([[0.0], np.cumsum(steps)])))


@cache
def turned_by_hand(seed: int, walk: float = 0.0) -> GroundRecording:
    """10 s by hand on ground drawn from the prior, which may walk."""
    return make_ground_recording(seed, ground(seed, walk))


@cache
def steered_by_hand(
    seed: int, duration: float = 10.0, rate: float = 1000.0, walk: float = 0.0
) -> SteeringRecording:
    """Steering torque and 14-bit angle on ground drawn from the prior, which may walk."""
    return make_steering_recording(seed, ground(seed, walk), duration=duration, rate=rate)


def tuned(made: Recording, *, scale: float = ALLOWANCE, **beliefs: Any) -> dict[str, Any]:
    """Measurement model and tuning for known white sensor noise, no torque zero, constant friction.

    The noise believed is `scale` times the true one; beliefs are other fields of `Tuning`.
    """
    aligning = isinstance(made, GroundRecording)
    torque = made.M_z_true if aligning else made.M_true
    # `Tuning.noise` is that of samples 10 ms apart; so much of it is seen in the torque at another rate.
    rate = 1.0 if aligning else np.sqrt((made.t[1] - made.t[0]) / 0.01)
    usual = {
        "noise": scale * NOISE * np.ptp(torque) / slide() * rate, "error": inf, "gate": inf, **PRIOR,
        "mu_walk": 0.0 if aligning else 1e-3, "psi_noise": FOURTEEN_BIT_STEP,
    }  # fmt: skip
    measurement_model = AligningTorque(zero=False) if aligning else SteeringTorque()
    return {"measurement_model": measurement_model, **usual, **beliefs}


def estimated(kind: Any, made: Recording, **settings: Any) -> Estimates:
    """What an observer says of a recording; settings as for `tuned`, and the observer's own."""
    return run(make(kind, **tuned(made, **settings)), **columns_of(made))


@dataclass(frozen=True, kw_only=True, eq=False)
class Errors:
    """The errors of one run: of mu, and of ln mu over its standard deviation, shape (n,) [1].

    slid is the first sample after the torque has been near full slide; n where it never is.
    """

    of_mu: Array
    normal: Array
    informed: NDArray[np.bool_]
    slid: int

    @property
    def late_rmse(self) -> float:
        """Root mean square error of mu after the first full slide; NaN where there is none."""
        late = self.of_mu[self.slid :]
        return float(np.sqrt(np.mean(late**2))) if late.size else float("nan")


def errors(made: Recording, estimates: Estimates) -> Errors:
    """What the estimates are off by."""
    full = SLID * full_slide_moment(made.tyre, 1.0) * made.mu_true * made.F_N_true
    near = np.abs(made.M_z_true) > full
    return Errors(
        of_mu=estimates.mu - made.mu_true,
        normal=np.log(estimates.mu / made.mu_true) * estimates.mu / estimates.mu_std,
        informed=estimates.informed,
        slid=int(np.argmax(near)) + 1 if near.any() else near.size,
    )


@dataclass(frozen=True, kw_only=True)
class Figures:
    """What many runs show together.

    Attributes:
        runs: their number.
        coverage: share of the informed samples whose 95 % interval holds the true mu [1].
        nees: mean square of the normalised errors of informed samples, runs weighing alike [1].
        rmse: of mu after the first full slide, all runs that reach it [1].
        worst: the largest of a single run [1].
        beyond: runs with a sample beyond four standard deviations before full slide.
        farthest: the largest normalised error before full slide.
    """

    runs: int
    coverage: float
    nees: float
    rmse: float
    worst: float
    beyond: int
    farthest: float


def figures(campaign: Sequence[Errors]) -> Figures:
    """The figures of many runs."""
    informed = [each.normal[each.informed] for each in campaign]
    early = np.array([np.abs(each.normal[: each.slid]).max() for each in campaign])
    late = np.array([each.late_rmse for each in campaign])
    return Figures(
        runs=len(campaign),
        coverage=float(np.mean(np.abs(np.concatenate(informed)) < 1.96)),
        nees=float(np.mean([np.mean(z**2) for z in informed if z.size])),
        rmse=float(np.sqrt(np.nanmean(late**2))),
        worst=float(np.nanmax(late)),
        beyond=int(np.count_nonzero(early > 4)),
        farthest=float(early.max()),
    )
