"""Recordings and samples made for observers, and where in them friction shows."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import inf, nan
from typing import Any, ClassVar

import numpy as np
import pytest
from numpy.typing import NDArray

from observers import (
    ESTIMATE,
    AligningTorque,
    Ekf,
    Estimate,
    Estimates,
    Mhe,
    Observer,
    Sample,
    SteeringTorque,
    causal_rate,
    run,
)
from reference_rig import RigRecording, RigTyre, SteeringRecording, hand_path, simulate_bristles
from symbolic import Model, effects_named, simulate
from symbolic.float_array_type import Array
from tests.observers.conftest import RIG, K

Recording = RigRecording | SteeringRecording
FIELDS = ESTIMATE
UNLIMITED: dict[str, Any] = {"psi_limit": inf, "psi_rate_limit": inf}
"""Tuning for samples that turn as no wheel does."""
CLEAN_RIG: dict[str, Any] = {"noise": 0.01, "error": inf, "gate": inf, **UNLIMITED}
"""Tuning for white torque noise of 0.4 % of range, about 1 % of the full-slide torque at mu = 1."""


LONG = pytest.mark.long
STIFF, STEERED = AligningTorque(stiffness=True), SteeringTorque()


def kinds(window: int = 20, *, marks: Any = ()) -> list[Any]:
    """Parameters kind and settings: both estimators by what they measure; marks for all but three."""
    return [
        pytest.param(Ekf, {}, id="ekf"),
        pytest.param(Mhe, {"window": window}, id="mhe"),
        pytest.param(Ekf, {"measurement_model": STEERED}, id="ekf steering"),
        *(
            pytest.param(kind, settings, id=name, marks=marks)
            for kind, settings, name in (
                (Mhe, {"measurement_model": STEERED, "window": window}, "mhe steering"),
                (Ekf, {"measurement_model": STIFF}, "ekf stiffness"),
                (Mhe, {"measurement_model": STIFF, "window": window}, "mhe stiffness"),
            )
        ),
    ]


DECLARED: dict[str, Any] = {"model": Model(), "values": {"k": K}}


def found_model(values: Mapping[str, float], k: float = K, **model: Any) -> dict[str, Any]:
    """Model and values of an observer, of the effects whose parameters these are."""
    names = dict.fromkeys(name.partition(".")[0] for name in values)
    return {"model": Model(effects=effects_named([*names]), **model), "values": {"k": k, **values}}


MODEL_OBSERVERS: dict[str, Callable[[], Ekf | Mhe]] = {
    "ekf": lambda: Ekf(**DECLARED, rig=RIG, acquire=False),
    "mhe": lambda: Mhe(**DECLARED, rig=RIG, window=10, acquire=False),
    "steering": lambda: Ekf(
        **DECLARED, rig=replace(RIG, J_A=0.15, b_t=1.0), measurement_model=SteeringTorque()
    ),
}
"""Observers of the declared model, made when they are asked for."""


def acquiring_ekf() -> Ekf:
    """A filter of the declared model that acquires friction, all else as it is by default."""
    return Ekf(**DECLARED, rig=RIG)


@dataclass(frozen=True)
class SampleRecorder:
    """An observer of a user's own: it keeps every sample, and estimates their number."""

    samples: list[Sample] = field(default_factory=list)
    channel: ClassVar[str] = "M_z"

    def init(self, first: Sample) -> int:
        del first
        return 0

    def step(self, state: int, sample: Sample) -> int:
        self.samples.append(sample)
        return state + 1

    def estimate(self, state: int) -> Estimate:
        return Estimate(mu=float(state), mu_std=0.1, M_z_predicted=0.0, informed=True)


def wrong_and_usable(estimates: Estimates, mu: float | Array) -> NDArray[np.bool_]:
    """Where a usable estimate is off the true friction by more than three standard deviations."""
    return estimates.usable & (np.abs(estimates.mu - mu) > 3 * estimates.mu_std)


def slide(F_N: float = 400.0) -> float:
    """3/8 F_N a, in which a tuning counts torques [N m]."""
    return 0.375 * F_N * RIG.a


def columns_of(made: Recording, part: slice = slice(None)) -> dict[str, Array]:  # type: ignore[assignment]
    """What `run` takes, from either recording, by name."""
    torque = "M_z" if isinstance(made, RigRecording) else "M"
    return {name: getattr(made, name)[part] for name in ("t", "psi", "F_N", torque)}


def samples_of(columns: dict[str, Array]) -> list[Sample]:
    """The samples that `run` makes of its columns where no angle is missing."""
    t, psi, F_N = columns["t"], columns["psi"], columns["F_N"]
    nothing = np.full(t.size, nan)
    torques = (columns.get(name, nothing) for name in ("M_z", "M"))
    rows = zip(psi, causal_rate(t, psi), F_N, np.diff(t, prepend=2 * t[0] - t[1]), *torques, strict=True)
    return [Sample(psi=p, psi_dot=v, F_N=F, dt=dt, M_z=M_z, M=M) for p, v, F, dt, M_z, M in rows]


def sparse(samples: list[Sample]) -> list[Sample]:
    """The samples, each seventh without what it measures of the tyre."""
    gone = [replace(s, M_z=nan) if np.isfinite(s.M_z) else replace(s, psi=nan) for s in samples]
    return [gone[i] if i % 7 == 6 else s for i, s in enumerate(samples)]


def states_of(observer: Any, samples: list[Sample]) -> Iterator[Any]:
    """The state after each sample."""
    state = observer.init(samples[0])
    for sample in samples:
        state = observer.step(state, sample)
        yield state


def estimates_of(observer: Any, samples: list[Sample]) -> list[Estimate]:
    """The estimate after each sample."""
    return [observer.estimate(state) for state in states_of(observer, samples)]


def full_slide(mu: Array, *, every: int = 6) -> list[Sample]:
    """Samples in full slide to and fro at changing mu; M_z is linear in mu but for 1e-6.

    The first stands at rest; after it the wheel turns through 1000 rad at once, and back.
    """
    turn, F_N = 1e3, 400.0
    side = np.where(np.arange(mu.size) // every % 2 == 0, 1.0, -1.0)
    psi = np.concatenate([[0.0], turn * side[1:]])
    level = virgin(turn, F_N)
    M_z = np.concatenate([[0.0], -side[1:] * mu[1:] * level])
    return [Sample(psi=p, psi_dot=0.0, F_N=F_N, dt=0.01, M_z=M) for p, M in zip(psi, M_z, strict=True)]


def virgin(turn: float, F_N: float) -> float:
    """Size of M_z at mu = 1 after a turn from rest [N m]."""
    signals = np.array([[0.0, turn], [0.0, 0.0], [F_N, F_N], [0.01, 0.01]])
    return -float(simulate(Model(), signals, np.array([1.0, K]), np.array([RIG.a, RIG.e])).M_z[1])


def first_full_slide(made: RigRecording) -> int:
    """First sample after the torque has been at 90 % of its full-slide level, never quite reached."""
    x = np.linspace(-made.tyre.a, made.tyre.a, 4001)
    share = np.mean((1 - (x / made.tyre.a) ** 2) * np.abs(x - made.tyre.e)) * 1.5
    level = made.tyre.mu * made.F_N_true * share
    return int(np.flatnonzero(np.abs(made.M_z_true) > 0.9 * level)[0]) + 1


def change_of_ground(first: float = 1.5, then: float = 1.1) -> tuple[Array, Array, Array, Array]:
    """t, psi, F_N and M_z; mu is another one from 7 s on, as if the wheel were lifted over."""
    path = hand_path(31, 14.0, load=400.0, rate=100.0)
    mu = np.where(path.t < 7, first, then)
    M_z = simulate_bristles(replace(path, F_N=path.F_N * mu), RigTyre(k=K, mu=1.0), bristles=1000).M_z
    M_z = M_z + 0.004 * np.ptp(M_z) * np.random.default_rng(31).standard_normal(M_z.size)
    return path.t, path.psi, path.F_N, M_z


def assert_steps_are_the_run(observer: Observer, columns: dict[str, Array]) -> None:
    """Sample by sample, an observer says what it says of the whole recording."""
    estimates = run(observer, **columns)
    states = states_of(observer, samples_of(columns))
    said = [observer.estimate(state) for state in states]
    for name in FIELDS:
        stepped = np.array([getattr(now, name) for now in said], dtype=float)
        whole = np.asarray(getattr(estimates, name), dtype=float)
        np.testing.assert_allclose(whole, stepped, rtol=0, atol=1e-12, err_msg=name)
    assert np.ptp(estimates.mu) > 0.05, "the comparison saw no correction"
    assert said[-1].mu == pytest.approx(estimates.mu[-1], abs=1e-12)
