"""The filter's C in single precision: the same filter, and sound under random samples."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from observers import Ekf, run
from reference_rig import RigRecording, SteeringRecording
from symbolic import compiler
from tests.observers.factories import columns_of, samples_of
from tests.observers.float32 import (
    CASES,
    HARSH,
    NO_COMPILER,
    PLAIN,
    Outcome,
    Single,
    Trial,
    build,
    in_single,
)

pytestmark = pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
STEPS = 100_000
QUICK = {
    "steering": PLAIN,
    "steering, 5 states, huge prior": HARSH,
}
"""Filters and trials of the quick tier: a plain one and the hardest."""
TRIALS = [
    pytest.param(
        case, trial, id=f"{case}-{name}", marks=[] if QUICK.get(case) is trial else pytest.mark.long
    )
    for case in CASES
    for name, trial in (("plain", PLAIN), ("harsh", HARSH))
]
FilterFactory = Callable[[Ekf], Single]


@pytest.fixture(scope="module")
def single(tmp_path_factory: pytest.TempPathFactory) -> FilterFactory:
    """Makes a filter in single precision, compiling each kind once."""
    built: dict[Any, Path] = {}

    def made(observer: Ekf) -> Single:
        kind = (observer.model, observer.measurement_model, observer.iterations)
        if kind not in built:
            built[kind] = build(observer, tmp_path_factory.mktemp("single")).library
        return Single(observer, built[kind])

    return made


def description(outcome: Outcome, observer: Ekf) -> str:
    """What a fault needs to be understood."""
    parts = [name for name in observer.layout.places if name not in ("memory", "memory_sensitivity")]
    part = observer.layout.part
    before, after = outcome.before.astype(float), outcome.state.astype(float)
    changes = [
        f"{name}: {part(before, name).tolist()} -> {part(after, name).tolist()}" for name in parts
    ]
    where = f"{outcome.fault} at {outcome.report.at} after {outcome.report.steps} samples"
    return "\n".join([where, f"sample: {outcome.sample.tolist()}", *changes])


@pytest.mark.parametrize(("case", "trial"), TRIALS)
def test_covariance_stays_positive_definite(case: str, trial: Trial, single: FilterFactory) -> None:
    observer = CASES[case].observer
    outcome = single(observer).drive(STEPS, 1, trial)
    report = outcome.report
    print(f"{case}: D from {report.least_D:.1e} to {report.greatest_D:.1e}, {report.resets} resets")

    assert outcome.fault == "sound", description(outcome, observer)
    assert report.steps == STEPS
    # The samples were trying: sensors failed, and the ground changed where that can be noticed.
    assert 0.04 * STEPS < report.missing < 0.2 * STEPS
    assert report.held > 0.08 * STEPS
    assert report.resets > 100 or observer.tuning.gate == np.inf


@pytest.mark.parametrize(
    ("part", "at", "value", "fault"),
    [("factor", 4, 0.0, "not positive"), ("x", 1, np.nan, "not finite")],
)
def test_faults_are_noticed(part: str, at: int, value: float, fault: str, single: FilterFactory) -> None:
    # Without walks a variance of 0 stays one.
    filtered = single(CASES["3 states, huge prior, no walk"].observer)
    state = filtered.drive(10, 1).state
    state[filtered.observer.layout.places[part][0].start + at] = value
    outcome = filtered.drive(100, 1, state=state)

    assert outcome.fault == fault
    assert outcome.report.steps <= 1


@pytest.mark.parametrize("seed", [1, 2])
def test_samples_are_the_seeds(seed: int, single: FilterFactory) -> None:
    filtered = single(CASES["as it comes"].observer)
    first, second = (filtered.drive(1000, seed) for _ in range(2))
    other = filtered.drive(1000, seed + 1)

    np.testing.assert_array_equal(first.state, second.state)
    assert not np.array_equal(first.sample, other.sample, equal_nan=True)


def test_generated_c_holds_no_double() -> None:
    x = ca.SX.sym("x")
    text = in_single(ca.Function("small", [x], [ca.exp(0.5 * x) + 1e-3 + x**2.5 + 3]))

    assert "expf(" in text
    assert "1.0000000000000000e-03f" in text
    assert "5.0000000000000000e-01f" in text


def test_aligning_torque_is_filtered_as_in_double(
    recording: RigRecording, single: FilterFactory
) -> None:
    compare(single(CASES["as it comes"].observer), recording)


def test_steering_torque_is_filtered_as_in_double(
    steered: SteeringRecording, single: FilterFactory
) -> None:
    compare(single(CASES["steering"].observer), steered)


def compare(filtered: Single, made: RigRecording | SteeringRecording) -> None:
    """On a recording, single precision says what double says."""
    columns = columns_of(made)
    rows = [(s.psi, s.psi_dot, s.F_N, s.dt, s.M_z, s.M) for s in samples_of(columns)]
    mu, std, *_ = filtered.follow(np.array(rows, np.float32)).T
    double = run(filtered.observer, **columns)
    off = np.abs(mu - double.mu) / double.mu_std
    print(f"mu {mu[-1]:.4f}, off by {np.abs(mu - double.mu).max():.1e}, {off.max():.1e} of its std")

    assert off.max() < 0.05
    np.testing.assert_allclose(std, double.mu_std, rtol=0.01)
    assert np.ptp(double.mu) > 0.05, "the comparison saw no correction"
