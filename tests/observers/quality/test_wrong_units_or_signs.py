"""Other units and signs are named; right recordings are not."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from observers import Ekf, Estimate, Loop, Sample, Status, suspicions_of
from reference_rig import FOURTEEN_BIT_STEP, RigRecording
from tests.observers.conftest import RIG, K, make
from tests.observers.factories import columns_of, samples_of

WRONG = {
    "psi looks like degrees": {"psi": 180 / np.pi},
    "time looks like milliseconds": {"dt": 1e3},
    "F_N looks like kN": {"F_N": 1e-3},
    "torque looks like N mm": {"M_z": 1e3},
    "psi or the torque has the other sign": {"M_z": -1.0},
}


def converted(samples: list[Sample], factors: dict[str, float]) -> list[Sample]:
    return [replace(s, **{n: getattr(s, n) * f for n, f in factors.items()}) for s in samples]


def along(samples: list[Sample], *, acquire: bool = True) -> tuple[Loop, list[Estimate]]:
    loop = Loop(make(Ekf, acquire=acquire))
    return loop, [loop(sample) for sample in samples]


@pytest.mark.parametrize("cause", WRONG)
def test_the_cause_is_named_and_no_estimate_is_informed(recording: RigRecording, cause: str) -> None:
    samples = converted(samples_of(columns_of(recording)), WRONG[cause])
    loop, (*_, last) = along(samples)

    assert len(loop.suspicions) == 1
    assert cause in loop.suspicions[0]
    assert loop.suspicions == suspicions_of(samples, RIG, "M_z")
    assert Status.SUSPECT in last.status
    assert not last.informed
    assert not last.usable
    loop.reset()
    assert loop.suspicions == ()


def test_right_samples_raise_no_suspicion(recording: RigRecording) -> None:
    loop, (*_, last) = along(samples_of(columns_of(recording)))

    assert loop.suspicions == ()
    assert last.usable


def test_a_few_odd_samples_a_wheel_that_stands_and_a_lifted_one_are_no_evidence(
    recording: RigRecording,
) -> None:
    samples = samples_of(columns_of(recording))
    odd: dict[int, dict[str, Any]] = {
        50: {"psi": 30.0}, 150: {"F_N": 1e-3}, 250: {"dt": 5.0}, 350: {"M_z": -1e6},
        450: {"psi": np.nan},
    }  # fmt: skip
    faulty = [replace(s, **odd.get(i, {})) for i, s in enumerate(samples)]
    assert suspicions_of(faulty[:50] + faulty[51:], RIG, "M_z") == ()
    rng = np.random.default_rng(4)
    still = [replace(samples[200], psi=FOURTEEN_BIT_STEP * b) for b in rng.integers(0, 2, 5000).tolist()]
    assert suspicions_of(still, RIG, "M_z") == ()
    lifted = [replace(s, F_N=1.0, M_z=2.0) for s in samples[300:330]]
    assert suspicions_of(samples[:300] + lifted + samples[330:], RIG, "M_z") == ()


def test_an_estimator_alone_does_not_check(recording: RigRecording) -> None:
    samples = converted(samples_of(columns_of(recording)), {"psi": 180 / np.pi})
    assert along(samples, acquire=False)[0].suspicions == ()


def test_a_quick_turn_from_sample_to_sample_is_evidence_of_a_wrong_sign() -> None:
    """0.06 rad in each tenth of a second, to and fro; the ground would turn the wheel."""
    psi = np.abs(np.arange(100) % 10 - 5) * 0.06
    turns = np.sign(np.gradient(psi))
    samples = [
        Sample(psi=p, psi_dot=np.nan, F_N=400.0, dt=0.1, M_z=4.0 * s + 0.01 * i)
        for i, (p, s) in enumerate(zip(psi, turns, strict=True))
    ]
    assert any("other sign" in cause for cause in suspicions_of(samples, RIG, "M_z"))


@pytest.mark.parametrize("cause", ["has the other sign", "stays the same"])
def test_a_torque_more_seldom_than_the_angle_is_evidence(recording: RigRecording, cause: str) -> None:
    """Nine samples without a torque beside each with one."""
    columns = columns_of(recording)
    torque = -columns["M_z"] if "sign" in cause else columns["M_z"].copy()
    if "same" in cause:
        torque[150:] = torque[150]
    seldom = samples_of({**columns, "M_z": torque})
    between = [replace(s, dt=0.001, M_z=np.nan) for s in seldom]
    turns = np.diff([s.psi for s in seldom], append=seldom[-1].psi)
    samples = []
    for sample, empty, turn in zip(seldom, between, turns, strict=True):
        samples.append(replace(sample, dt=0.001))
        samples += [replace(empty, psi=empty.psi + turn * i / 10) for i in range(1, 10)]

    assert any(cause in named for named in suspicions_of(samples, RIG, "M_z"))


@pytest.mark.parametrize("step", [0.05, 0.1])
def test_a_torque_in_coarse_steps_is_no_clipped_one(recording: RigRecording, step: float) -> None:
    """A sliding patch gives such a sensor the same torque to the last digit."""
    quantised = step * np.round(recording.M_z_true / step)
    loop, _ = along(samples_of({**columns_of(recording), "M_z": quantised}))

    assert not any("the same" in cause for cause in loop.suspicions)


@pytest.mark.parametrize(
    ("changes", "is_told"),
    [
        ((0.5, -0.02, 0.06, -0.08, 0.09, 0.005), True),
        ((0.5, 0.06, -0.02, 0.03, -0.005), True),
        ((0.5, 0.06, 0.03, 0.005), False),
        ((0.5, -0.3, 0.2, 0.1, 0.06, 0.03, 0.005), False),
    ],
    ids=["noise", "noise turned", "full slide", "full slide after a turn back"],
)
def test_of_a_noisy_torque_the_last_change_before_a_limit_may_be_small(
    changes: tuple[float, ...], is_told: bool
) -> None:
    torques = 4.0 + np.cumsum([*changes, *[0.0] * 12])
    psi = -0.004 * np.arange(torques.size)
    rows, usual = zip(psi, torques, strict=True), {"psi_dot": -0.4, "F_N": 400.0, "dt": 0.01}
    samples = [Sample(psi=p, M_z=m, **usual) for p, m in rows]

    assert any("the same" in cause for cause in suspicions_of(samples, RIG, "M_z")) == is_told


@pytest.mark.parametrize("step", [0.0, 0.02, 0.1])
def test_a_torque_that_was_clipped_stays_suspected(recording: RigRecording, step: float) -> None:
    columns = columns_of(recording)
    if step:
        columns["M_z"] = step * np.round(recording.M_z_true / step)
    most = 0.5 * np.abs(columns["M_z"]).max()
    loop, estimates = along(samples_of({**columns, "M_z": np.clip(columns["M_z"], -most, most)}))
    flags = [bool(now.status & Status.SUSPECT) for now in estimates]

    named = [cause for cause in loop.suspicions if "the same" in cause or "clip" in cause]
    assert named, loop.suspicions
    # Also where the torque lies between the ends of the sensor again.
    assert all(flags[flags.index(True) :])


def test_a_torque_that_noise_hides_at_first_raises_no_suspicion() -> None:
    """Where a wheel begins to turn, s is anything from below 0 to above 2, and so is its logarithm."""
    turning = 1.25 * (0.01 * np.arange(1, 13)) ** 2
    psi = np.append(np.zeros(50), turning)
    # Full stick: k (2 a^3 / 3 + 2 a e^2) times the turn.
    slope = K * (2 * RIG.a**3 / 3 + 2 * RIG.a * RIG.e**2)
    for seed in range(60):
        torque = -slope * psi + 0.15 * np.random.default_rng(seed).standard_normal(psi.size)
        rows, usual = zip(psi, torque, strict=True), {"psi_dot": 0.0, "F_N": 400.0, "dt": 0.01}
        _, estimates = along([Sample(psi=angle, M_z=M_z, **usual) for angle, M_z in rows])

        assert not any(Status.SUSPECT in one.status for one in estimates)
