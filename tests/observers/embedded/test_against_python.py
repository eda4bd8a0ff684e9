"""Generated C says what Python says: bit for bit in double, to rounding in single precision."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from identification import read_recording
from observers import AligningTorque, Ekf, Mhe, Status, SteeringTorque, Tuning, run
from observers.embedded import DOUBLE, SINGLE
from observers.embedded.compact_ekf import is_compact
from observers.embedded.compact_mhe import is_compact_window
from reference_rig.record import RigRecording
from reference_rig.steering import SteeringRecording
from symbolic import Tyre
from symbolic.compiled import compiler
from tests.observers.conftest import RIG, K
from tests.observers.embedded.building import (
    DECLARED,
    FOUND,
    NO_COMPILER,
    Interpreted,
    observer_of,
    said_by,
)
from tests.observers.embedded.conftest import Build
from tests.observers.factories import change_of_ground, columns_of, samples_of

pytestmark = pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
Array = NDArray[np.float64]
MODELS = [pytest.param(DECLARED, id="declared"), pytest.param(FOUND, id="effects")]
KINDS = [pytest.param(Ekf, id="ekf"), pytest.param(Mhe, id="mhe")]
SENSINGS = [
    pytest.param(AligningTorque(), id="aligning"),
    pytest.param(SteeringTorque(), id="steering"),
]
NOMINAL = (RIG, Tyre(k=K, mu=1.2))
PUBLISHED = ["fem1", "fem3", "fem4_ident", "fem5", "piros1", "piros2_ident", "piros4", "piros7"]
PART = {Ekf: 800, Mhe: 250}
"""Samples compared bit for bit, where casadi's own arithmetic takes its time."""


def rows_of(made: RigRecording | SteeringRecording) -> Array:
    """Samples (n, 5); every ninth is without a torque, and the rate is now given, now not."""
    turns = isinstance(made, SteeringRecording)
    rows = np.array(
        [(s.psi, s.psi_dot, s.M if turns else s.M_z, s.F_N, s.dt) for s in samples_of(columns_of(made))]
    )
    rows[8::9, 2] = np.nan
    rows[len(rows) // 3 :, 1] = np.nan
    rows[40:44, 0], rows[60:63, 3] = np.nan, -1.0
    return rows


@pytest.fixture
def rows(sensing: Any, recording: RigRecording, steered: SteeringRecording) -> Array:
    return rows_of(steered if "M" in sensing.channels else recording)


@pytest.mark.parametrize("sensing", SENSINGS)
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("kind", KINDS)
def test_double_is_the_same(built: Build, kind: Any, model: Any, sensing: Any, rows: Array) -> None:
    observer = observer_of(kind, model, sensing)
    part = rows[: PART[kind]]
    expected = said_by(Interpreted(observer), part, "M" in sensing.channels)
    said = built(observer, DOUBLE).follow(part)

    if is_compact(observer) or is_compact_window(observer):
        # Not the same operations: the patch is another one.
        np.testing.assert_allclose(said[:, :2], expected[:, :2], rtol=0, atol=1e-12)
        np.testing.assert_allclose(said[:, 2], expected[:, 2], rtol=0, atol=1e-10)
        np.testing.assert_array_equal(said[:, 3:], expected[:, 3:])
    else:
        np.testing.assert_array_equal(said, expected)
    assert np.ptp(said[:, 0]) > 0.005, "the comparison saw no correction"


@pytest.mark.parametrize("sensing", SENSINGS)
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("kind", KINDS)
def test_single_is_as_close_as_it_can_be(
    built: Build, kind: Any, model: Any, sensing: Any, rows: Array
) -> None:
    observer = observer_of(kind, model, sensing)
    rounded = SINGLE.round(rows)
    expected = said_by(observer, rounded, "M" in sensing.channels)
    said = built(observer, SINGLE).follow(rounded)
    off = np.abs(said - expected)[:, 0]
    second = np.cumsum(rows[:, 4]) > 1
    print(f"mu off by {off.max():.1e}, after 1 s by {off[second].max():.1e}")

    assert off.max() < 5e-5
    # Bristles that follow an angle estimated in single precision keep its rounding.
    assert off[second].max() < (2e-5 if model is FOUND and "M" in sensing.channels else 5e-6)
    np.testing.assert_allclose(said[:, 1], expected[:, 1], rtol=1e-4)
    np.testing.assert_array_equal(said[:, 4], expected[:, 4])


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["train_a", "train_b", "holdout_c", "holdout_d"])
def test_embedded_recordings(
    built: Build, repository_root: Path, kind: Any, model: Any, name: str
) -> None:
    path = repository_root / "examples" / "recordings" / f"{name}.csv"
    compare_recording(built, path, observer_of(kind, model, AligningTorque()))


@pytest.mark.measured
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", PUBLISHED)
def test_measured_recordings(built: Build, measured_dir: Path, kind: Any, name: str) -> None:
    path = measured_dir / f"{name}.mat"
    compare_recording(built, path, observer_of(kind, DECLARED, AligningTorque()))


def compare_recording(built: Build, path: Path, observer: Any) -> None:
    """A whole recording, in both types, with the rig's usual tyre; Python compiled for this machine."""
    made = read_recording(path, NOMINAL)
    step = np.diff(made.t, prepend=2 * made.t[0] - made.t[1])
    rows = np.column_stack([made.psi, np.full(made.t.size, np.nan), made.M_z, made.F_N, step])
    expected = run(observer, made.t, made.psi, made.F_N, made.M_z)
    double = built(observer, DOUBLE).follow(rows)
    np.testing.assert_allclose(double[:, 0], expected.mu, rtol=0, atol=1e-12)
    np.testing.assert_allclose(double[:, 1], expected.mu_std, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(double[:, 4], expected.status)

    rounded = SINGLE.round(rows)
    off = np.abs(built(observer, SINGLE).follow(rounded) - built(observer, DOUBLE).follow(rounded))[:, 0]
    print(f"single precision: mu off by {off.max():.1e}, after 1 s by {off[100:].max():.1e}")
    assert off.max() < 5e-5
    assert off[100:].max() < 5e-6


@pytest.mark.parametrize("window", [2, 7, 50])
@pytest.mark.parametrize("kind", KINDS)
def test_outliers_and_changes_of_the_ground(built: Build, kind: Any, window: int) -> None:
    t, psi, F_N, M_z = change_of_ground()
    rng = np.random.default_rng(3)
    M_z = np.where(rng.random(t.size) < 0.02, 3 * M_z, M_z)
    M_z[rng.random(t.size) < 0.1] = np.nan
    rows = np.column_stack([psi, np.full(t.size, np.nan), M_z, F_N, np.full(t.size, 0.01)])[:1000]
    tuning = Tuning(noise=0.01, error=0.02, gate=4.0, reset_after=3, zero_time=20.0)
    settings = {"window": window} if kind is Mhe else {}
    observer = kind(
        **DECLARED, rig=RIG, tuning=tuning, measurement_model=AligningTorque(stiffness=True), **settings
    )
    said, expected = built(observer, DOUBLE).follow(rows), said_by(observer, rows, turns=False)

    np.testing.assert_allclose(said[:, :2], expected[:, :2], rtol=0, atol=1e-9)
    np.testing.assert_array_equal(said[:, 3:], expected[:, 3:])
    seen = [int(status) for status in expected[:, 4]]
    assert sum(status & Status.RESET > 0 for status in seen) > 0, "the ground never changed"
    assert sum(status & Status.REJECTED > 0 for status in seen) > 5, "there were no outliers"
