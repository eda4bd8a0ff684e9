"""Generated C estimates what Python does: bit for bit in double, to rounding in single precision."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from identification import read_recording
from observers import AligningTorque, Ekf, Mhe, Status, Tuning, run
from observers.embedded import DOUBLE, SINGLE
from reference_rig import RigRecording, SteeringRecording
from symbolic import Tolerances, Tyre
from symbolic.float_array_type import Array
from tests.observers.conftest import RIG, K
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import (
    DECLARED,
    assert_same,
    cases,
    needs_compiler,
    observer_named,
    python_estimates,
    rows_of,
)
from tests.observers.factories import change_of_ground

pytestmark = needs_compiler
LONG = pytest.mark.long
EACH = cases(
    "ekf declared aligning; mhe declared aligning",
    "ekf few aligning; mhe few aligning; ekf effects aligning; mhe effects aligning",
)
OTHERS = "; ".join(
    f"{kind} effects {torque}" for kind in ("ekf", "mhe") for torque in ("aligning", "steering")
)
NOMINAL = (RIG, Tyre(k=K, mu=1.2))
PUBLISHED = "fem3; fem4_ident; fem5; piros1; piros2_ident; piros4; piros7"
PART = {Ekf: 800, Mhe: 250}
"""Samples compared bit for bit, where casadi's own arithmetic takes its time."""


def with_gaps(recording: RigRecording | SteeringRecording) -> Array:
    """Samples (n, 5); every ninth without a torque, the last two thirds without a rate."""
    rows = rows_of(recording)
    rows[8::9, 2] = np.nan
    rows[len(rows) // 3 :, 1] = np.nan
    rows[40:44, 0], rows[60:63, 3] = np.nan, -1.0
    return rows


@pytest.fixture
def rows(name: str, recording: RigRecording, steered: SteeringRecording) -> Array:
    return with_gaps(steered if "steering" in name else recording)


@pytest.mark.parametrize(
    "name",
    cases(
        "ekf declared steering; ekf few aligning; mhe declared aligning; mhe few steering",
        "ekf declared aligning; ekf few steering; mhe declared steering; mhe few aligning; "
        "ekf few direction; mhe few direction; ekf effects direction; ekf found direction; "
        "ekf measured aligning,k; " + OTHERS,
    ),
)
def test_double_is_the_same(generated: Generate, name: str, rows: Array) -> None:
    observer = observer_named(name, acquire=False)

    assert_same(generated(observer, DOUBLE), rows[: PART[type(observer)]], mu=1e-12)


@pytest.mark.parametrize(
    "name",
    cases(
        "ekf declared steering; mhe declared aligning",
        "ekf declared aligning; mhe declared steering; ekf measured aligning,k; " + OTHERS,
    ),
)
def test_single_precision_rounds(generated: Generate, name: str, rows: Array) -> None:
    observer = observer_named(name)
    rounded = SINGLE.round(rows)
    expected = python_estimates(observer, rounded)
    estimates = generated(observer, SINGLE).run(rounded)
    off = np.abs(estimates - expected)[:, 0]
    tracked = (np.cumsum(rows[:, 4]) > 1) & ((expected[:, -1].astype(int) & Status.ACQUIRING) == 0)
    print(f"mu off by {off.max():.1e}, after the acquisition by {off[tracked].max(initial=0.0):.1e}")

    # Behind a compliance the turn of a sample is tried on a part of the bristles, and a window that has
    # just begun to fill follows its torque.
    tried = "effects aligning" in name
    assert off.max() < (2e-2 if tried else 1e-5)
    assert off[tracked].max(initial=0.0) < (2e-2 if tried else 5e-6)
    # The deviation of two states whose errors go together loses a digit.
    rtol = 5e-2 if tried else 1e-3 if name.endswith(",k") else 2e-4
    np.testing.assert_allclose(estimates[:, 1], expected[:, 1], rtol=rtol)
    # A flag at its threshold may come a sample later.
    assert np.mean(estimates[:, -1] != expected[:, -1]) <= (2e-3 if tried else 0)


@pytest.mark.parametrize("name", EACH)
@pytest.mark.parametrize("file", cases("train_a", "train_b; holdout_c; holdout_d"))
def test_embedded_recordings(generated: Generate, repository_root: Path, name: str, file: str) -> None:
    path = repository_root / "examples" / "recordings" / f"{file}.csv"
    compare_recording(generated, path, observer_named(name))


@pytest.mark.long
@pytest.mark.measured
@pytest.mark.parametrize("name", ["ekf declared aligning", "mhe declared aligning"])
@pytest.mark.parametrize("file", cases("fem1", PUBLISHED))
def test_measured_recordings(generated: Generate, measured_dir: Path, name: str, file: str) -> None:
    compare_recording(generated, measured_dir / f"{file}.mat", observer_named(name))


def compare_recording(generated: Generate, path: Path, observer: Any) -> None:
    """Compare a whole recording in both types; Python's Functions are compiled for this machine."""
    recording = read_recording(path, NOMINAL)
    t, nan = recording.t, np.full(recording.t.size, np.nan)
    step = np.diff(t, prepend=2 * t[0] - t[1])
    rows = np.column_stack([recording.psi, nan, recording.M_z, recording.F_N, step])
    expected = run(observer, recording.t, recording.psi, recording.F_N, recording.M_z)
    double = generated(observer, DOUBLE).run(rows)
    np.testing.assert_allclose(double[:, 0], expected.mu, rtol=0, atol=1e-12)
    np.testing.assert_allclose(double[:, 1], expected.mu_std, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(double[:, -1], expected.status)

    rounded = SINGLE.round(rows)
    single, better = (generated(observer, real).run(rounded)[:, 0] for real in (SINGLE, DOUBLE))
    off = np.abs(single - better)
    tracked = off[100:][(expected.status[100:] & Status.ACQUIRING) == 0]
    print(f"single precision: mu off by {off.max():.1e}, later by {tracked.max(initial=0.0):.1e}")
    # Behind a compliance the turn of a sample is tried on a part of the bristles.
    assert off.max() < (1e-3 if observer.model.effects else 1e-4)
    assert tracked.max(initial=0.0) < (1e-4 if observer.model.effects else 1e-5)


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        pytest.param(Ekf, {}, marks=LONG),
        pytest.param(Mhe, {"window": 2}, marks=LONG),
        pytest.param(Mhe, {"window": 7}, marks=LONG),
        pytest.param(Mhe, {"window": 50}, marks=LONG),
    ],
)
def test_outliers_and_a_new_ground(generated: Generate, kind: Any, settings: dict[str, int]) -> None:
    t, psi, F_N, M_z = change_of_ground()
    rng = np.random.default_rng(3)
    M_z = np.where(rng.random(t.size) < 0.02, 3 * M_z, M_z)
    M_z[rng.random(t.size) < 0.1] = np.nan
    rows = np.column_stack([psi, np.full(t.size, np.nan), M_z, F_N, np.full(t.size, 0.01)])[:1000]
    tuning = Tuning(noise=0.01, error=0.02, gate=4.0, reset_after=3, zero_time=20.0)
    own = {"tuning": tuning, "measurement_model": AligningTorque(stiffness=True), **settings}
    observer = kind(**DECLARED, rig=RIG, **own)
    estimates, expected = (generated(observer, DOUBLE).run(rows), python_estimates(observer, rows))

    np.testing.assert_allclose(estimates, expected, rtol=1e-7, atol=1e-9)
    np.testing.assert_array_equal(estimates[:, [3, 4, -1]], expected[:, [3, 4, -1]])
    flags = [int(status) for status in expected[:, -1]]
    assert sum(status & Status.RESET > 0 for status in flags) > 0, "the ground never changed"
    assert sum(status & Status.REJECTED > 0 for status in flags) > 5, "there were no outliers"


@pytest.mark.long
# The bristles turn with the wheel, or less than it behind a compliance: the code of either is its own.
@pytest.mark.parametrize(
    "name",
    cases(
        "ekf few aligning; ekf relaxing aligning; ekf relaxing aligning,k; mhe relaxing aligning,k",
        "mhe few aligning; mhe relaxing aligning; ekf few aligning,k; mhe few aligning,k",
    ),
)
def test_a_change_of_the_ground_under_bristles(generated: Generate, name: str) -> None:
    t, psi, F_N, M_z = change_of_ground()
    rows = np.column_stack([psi, np.full(t.size, np.nan), M_z, F_N, np.full(t.size, 0.01)])[:1000]
    walks = {"stiffness_std": 0.1, "stiffness_walk": 0.03} if name.endswith("k") else {}
    tuning = Tuning(noise=0.01, error=0.02, gate=4.0, reset_after=3, **walks)
    rig = replace(RIG, tolerances=Tolerances(zero=0.1))
    observer = replace(observer_named(name), tuning=tuning, rig=rig)
    expected = python_estimates(observer, rows)

    np.testing.assert_allclose(generated(observer, DOUBLE).run(rows), expected, rtol=1e-7, atol=1e-9)
    assert sum(int(status) & Status.RESET > 0 for status in expected[:, -1]) > 0


@pytest.mark.parametrize(
    "name", cases("ekf declared aligning; ekf few direction", "mhe declared aligning")
)
def test_a_torque_that_comes_more_slowly_than_the_angle(
    generated: Generate, name: str, recording: RigRecording
) -> None:
    rows = rows_of(recording)[:400]
    rows = np.repeat(rows, 10, axis=0)
    at = np.arange(len(rows))
    rows[:, 0], rows[:, 1] = np.interp(at, at[::10], rows[::10, 0]), np.nan
    rows[at % 10 > 0, 2], rows[:, 4] = np.nan, 0.001
    observer = observer_named(name)
    expected = python_estimates(observer, rows)

    np.testing.assert_allclose(generated(observer, DOUBLE).run(rows), expected, rtol=1e-7, atol=1e-9)


@pytest.mark.long
@pytest.mark.parametrize(
    "name", cases("ekf creep aligning; ekf creep aligning,k", "mhe creep aligning; mhe creep aligning,k")
)
def test_creep_with_a_compliance_in_single_precision(
    generated: Generate, name: str, recording: RigRecording
) -> None:
    # The table of Wright's function and two evaluations of the patch stand for searches to rounding.
    # While friction is acquired, hypotheses with large covariances round.
    observer = observer_named(name)
    rows = SINGLE.round(with_gaps(recording)[: PART[type(observer)]])
    off = np.abs(generated(observer, SINGLE).run(rows) - python_estimates(observer, rows))

    assert off[:, :2].max() < 5e-3
