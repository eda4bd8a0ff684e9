"""Generated C estimates what Python does: bit for bit in double, to rounding in single precision."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from identification import read_recording
from observers import AligningTorque, Ekf, Mhe, Status, SteeringTorque, Tuning, run
from observers.embedded import DOUBLE, SINGLE
from observers.embedded.compact import compact_patch
from reference_rig import RigRecording, SteeringRecording
from symbolic import Tyre, compiler
from tests.observers.conftest import RIG, K
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import (
    CREEP,
    DECLARED,
    EFFECTS,
    FEW_BRISTLES,
    NO_COMPILER,
    InterpretedObserver,
    observer_of,
    python_estimates,
)
from tests.observers.factories import change_of_ground, columns_of, samples_of

pytestmark = pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
Array = NDArray[np.float64]
LONG = pytest.mark.long
MODELS = [
    pytest.param(DECLARED, id="declared"),
    pytest.param(FEW_BRISTLES, id="effects-few", marks=LONG),
    pytest.param(EFFECTS, id="effects", marks=LONG),
]
KINDS = [pytest.param(Ekf, id="ekf"), pytest.param(Mhe, id="mhe")]
COMPARED = [
    # The compact patch, the compact window and casadi's own code, each once in the quick tier.
    pytest.param(Ekf, DECLARED, SteeringTorque(), id="ekf-declared-steering"),
    pytest.param(Ekf, FEW_BRISTLES, AligningTorque(), id="ekf-effects-few-aligning"),
    pytest.param(Mhe, DECLARED, AligningTorque(), id="mhe-declared-aligning"),
    pytest.param(Mhe, FEW_BRISTLES, SteeringTorque(), id="mhe-effects-few-steering"),
    pytest.param(Ekf, DECLARED, AligningTorque(), id="ekf-declared-aligning", marks=LONG),
    pytest.param(Ekf, FEW_BRISTLES, SteeringTorque(), id="ekf-effects-few-steering", marks=LONG),
    pytest.param(Mhe, DECLARED, SteeringTorque(), id="mhe-declared-steering", marks=LONG),
    pytest.param(Mhe, FEW_BRISTLES, AligningTorque(), id="mhe-effects-few-aligning", marks=LONG),
    *(
        pytest.param(kind, EFFECTS, measured, marks=LONG)
        for kind in (Ekf, Mhe)
        for measured in (AligningTorque(), SteeringTorque())
    ),
]
NOMINAL = (RIG, Tyre(k=K, mu=1.2))
PUBLISHED = ["fem1", "fem3", "fem4_ident", "fem5", "piros1", "piros2_ident", "piros4", "piros7"]
PART = {Ekf: 800, Mhe: 250}
"""Samples compared bit for bit, where casadi's own arithmetic takes its time."""


def rows_of(recording: RigRecording | SteeringRecording) -> Array:
    """Samples (n, 5); every ninth without a torque, the last two thirds without a rate."""
    turns = isinstance(recording, SteeringRecording)
    rows = np.array(
        [
            (s.psi, s.psi_dot, s.M if turns else s.M_z, s.F_N, s.dt)
            for s in samples_of(columns_of(recording))
        ]
    )
    rows[8::9, 2] = np.nan
    rows[len(rows) // 3 :, 1] = np.nan
    rows[40:44, 0], rows[60:63, 3] = np.nan, -1.0
    return rows


@pytest.fixture
def rows(measurement_model: Any, recording: RigRecording, steered: SteeringRecording) -> Array:
    return rows_of(steered if "M" in measurement_model.channels else recording)


@pytest.mark.parametrize(("kind", "model", "measurement_model"), COMPARED)
def test_double_is_the_same(
    generated: Generate, kind: Any, model: Any, measurement_model: Any, rows: Array
) -> None:
    observer = observer_of(kind, model, measurement_model, acquire=False)
    part = rows[: PART[kind]]
    expected = python_estimates(InterpretedObserver(observer), part)
    estimates = generated(observer, DOUBLE).run(part)

    if compact_patch(observer, DOUBLE) is not None:
        # The compact patch takes other operations.
        np.testing.assert_allclose(estimates[:, :2], expected[:, :2], rtol=0, atol=1e-12)
        np.testing.assert_allclose(estimates[:, 2], expected[:, 2], rtol=0, atol=1e-10)
        np.testing.assert_allclose(estimates[:, 5:9], expected[:, 5:9], rtol=1e-9, atol=1e-10)
        np.testing.assert_array_equal(estimates[:, [3, 4, -1]], expected[:, [3, 4, -1]])
    else:
        np.testing.assert_array_equal(estimates, expected)
    assert np.ptp(estimates[:, 0]) > 0.005, "no measurement corrected mu"


@pytest.mark.parametrize(
    ("kind", "model", "measurement_model"),
    [
        pytest.param(Ekf, DECLARED, SteeringTorque(), id="ekf-declared-steering"),
        pytest.param(Mhe, DECLARED, AligningTorque(), id="mhe-declared-aligning"),
        pytest.param(Ekf, DECLARED, AligningTorque(), id="ekf-declared-aligning", marks=LONG),
        pytest.param(Mhe, DECLARED, SteeringTorque(), id="mhe-declared-steering", marks=LONG),
        *(
            pytest.param(kind, EFFECTS, measured, marks=LONG)
            for kind in (Ekf, Mhe)
            for measured in (AligningTorque(), SteeringTorque())
        ),
    ],
)
def test_single_precision_rounds(
    generated: Generate, kind: Any, model: Any, measurement_model: Any, rows: Array
) -> None:
    observer = observer_of(kind, model, measurement_model)
    rounded = SINGLE.round(rows)
    expected = python_estimates(observer, rounded)
    estimates = generated(observer, SINGLE).run(rounded)
    off = np.abs(estimates - expected)[:, 0]
    second = np.cumsum(rows[:, 4]) > 1
    print(f"mu off by {off.max():.1e}, after 1 s by {off[second].max():.1e}")

    assert off.max() < 5e-5
    # Bristles that follow an angle estimated in single precision keep its rounding.
    assert off[second].max() < (2e-5 if model is EFFECTS and "M" in measurement_model.channels else 5e-6)
    np.testing.assert_allclose(estimates[:, 1], expected[:, 1], rtol=1e-4)
    np.testing.assert_array_equal(estimates[:, -1], expected[:, -1])


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "name", ["train_a", *(pytest.param(n, marks=LONG) for n in ("train_b", "holdout_c", "holdout_d"))]
)
def test_embedded_recordings(
    generated: Generate, repository_root: Path, kind: Any, model: Any, name: str
) -> None:
    path = repository_root / "examples" / "recordings" / f"{name}.csv"
    compare_recording(generated, path, observer_of(kind, model, AligningTorque()))


@pytest.mark.measured
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["fem1", *(pytest.param(name, marks=LONG) for name in PUBLISHED[1:])])
def test_measured_recordings(generated: Generate, measured_dir: Path, kind: Any, name: str) -> None:
    path = measured_dir / f"{name}.mat"
    compare_recording(generated, path, observer_of(kind, DECLARED, AligningTorque()))


def compare_recording(generated: Generate, path: Path, observer: Any) -> None:
    """Compare a whole recording in both types; Python's Functions are compiled for this machine."""
    recording = read_recording(path, NOMINAL)
    t, nan = recording.t, np.full(recording.t.size, np.nan)
    step = np.diff(t, prepend=2 * t[0] - t[1])
    rows = np.column_stack([recording.psi, nan, recording.M_z, recording.F_N, step])
    expected = run(observer, recording.t, recording.psi, recording.F_N, recording.M_z)
    double = generated(observer, DOUBLE).run(rows)
    np.testing.assert_allclose(double[:, 0], expected.mu, rtol=0, atol=1e-12)
    np.testing.assert_allclose(double[:, 1], expected.mu_std, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(double[:, -1], expected.status)

    rounded = SINGLE.round(rows)
    off = np.abs(generated(observer, SINGLE).run(rounded) - generated(observer, DOUBLE).run(rounded))[
        :, 0
    ]
    print(f"single precision: mu off by {off.max():.1e}, after 1 s by {off[100:].max():.1e}")
    assert off.max() < 5e-5
    assert off[100:].max() < 5e-6


@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        (Ekf, {}),
        pytest.param(Mhe, {"window": 2}, marks=LONG),
        pytest.param(Mhe, {"window": 7}, marks=LONG),
        pytest.param(Mhe, {"window": 50}, marks=LONG),
    ],
)
def test_outliers_and_changes_of_the_ground(
    generated: Generate, kind: Any, settings: dict[str, int]
) -> None:
    t, psi, F_N, M_z = change_of_ground()
    rng = np.random.default_rng(3)
    M_z = np.where(rng.random(t.size) < 0.02, 3 * M_z, M_z)
    M_z[rng.random(t.size) < 0.1] = np.nan
    rows = np.column_stack([psi, np.full(t.size, np.nan), M_z, F_N, np.full(t.size, 0.01)])[:1000]
    tuning = Tuning(noise=0.01, error=0.02, gate=4.0, reset_after=3, zero_time=20.0)
    observer = kind(
        **DECLARED, rig=RIG, tuning=tuning, measurement_model=AligningTorque(stiffness=True), **settings
    )
    estimates, expected = (
        generated(observer, DOUBLE).run(rows),
        python_estimates(observer, rows),
    )

    np.testing.assert_allclose(estimates[:, :2], expected[:, :2], rtol=0, atol=1e-9)
    np.testing.assert_allclose(estimates[:, 5:9], expected[:, 5:9], rtol=1e-7, atol=1e-9)
    np.testing.assert_array_equal(estimates[:, [3, 4, -1]], expected[:, [3, 4, -1]])
    flags = [int(status) for status in expected[:, -1]]
    assert sum(status & Status.RESET > 0 for status in flags) > 0, "the ground never changed"
    assert sum(status & Status.REJECTED > 0 for status in flags) > 5, "there were no outliers"


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=LONG)])
def test_a_change_of_the_ground_under_bristles(generated: Generate, kind: Any) -> None:
    t, psi, F_N, M_z = change_of_ground()
    rows = np.column_stack([psi, np.full(t.size, np.nan), M_z, F_N, np.full(t.size, 0.01)])[:1000]
    tuning = Tuning(noise=0.01, error=0.02, gate=4.0, reset_after=3)
    observer = kind(**FEW_BRISTLES, rig=RIG, tuning=tuning)
    expected = python_estimates(observer, rows)

    np.testing.assert_allclose(generated(observer, DOUBLE).run(rows), expected, rtol=1e-7, atol=1e-9)
    assert sum(int(status) & Status.RESET > 0 for status in expected[:, -1]) > 0


@pytest.mark.parametrize("kind", [pytest.param(Ekf, marks=LONG), Mhe])
def test_creep_with_a_compliance_in_single_precision(
    generated: Generate, kind: Any, recording: RigRecording
) -> None:
    # The table of Wright's function and two evaluations of the patch stand for searches to rounding.
    rows = SINGLE.round(rows_of(recording)[: PART[kind]])
    observer = observer_of(kind, CREEP, AligningTorque())
    off = np.abs(generated(observer, SINGLE).run(rows) - python_estimates(observer, rows))

    assert off[:, 0].max() < 1e-3
    assert off[:, 1].max() < 1e-3


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("kind", KINDS)
def test_loads_of_nothing_count_for_nothing(
    generated: Generate, kind: Any, model: Any, recording: RigRecording
) -> None:
    observer = observer_of(kind, model, AligningTorque())
    part = rows_of(recording)[: PART[kind]]
    light = slice(len(part) // 2, len(part) // 2 + 9)
    without = part.copy()
    without[light, 2] = without[light, 3] = np.nan
    code = generated(observer, SINGLE)
    expected = code.run(without)
    assert np.ptp(expected[:, 0]) > 0.005
    for load in (1e-40, 0.02, 19.0, 0.0, -3.0):
        part[light, 3] = load
        np.testing.assert_array_equal(code.run(part), expected)
