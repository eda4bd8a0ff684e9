"""An observer in python-control says what `run` says, alone and inside an interconnection."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest

from observers import RootObserver, Sample, Status, causal_rate, run
from observers.estimators.model_observer import ModelObserver
from observers.interfaces.control_system import as_system
from observers.protocol import ESTIMATE
from reference_rig import RigRecording
from symbolic.float_array_type import Array
from tests.observers.conftest import RIG, K
from tests.observers.factories import MODEL_OBSERVERS
from tests.refusal import refused

pytestmark = pytest.mark.usefixtures("interpreted")
COUNT = 200
OBSERVERS = MODEL_OBSERVERS


@pytest.fixture(params=OBSERVERS)
def observer(request: pytest.FixtureRequest) -> ModelObserver:
    return OBSERVERS[request.param]()


def columns_of(made: RigRecording) -> dict[str, Array]:
    """What is measured of a recording where it turns; the torque of the hand is made up."""
    chosen = slice(100, 100 + COUNT)
    psi, M_z = made.psi[chosen], made.M_z[chosen]
    t = 0.01 * np.arange(COUNT)
    motion = {"t": t, "psi": psi, "psi_dot": causal_rate(t, psi)}
    return motion | {"F_N": made.F_N[chosen], "M_z": M_z, "M": -M_z}


def first_of(columns: dict[str, Array]) -> Sample:
    return Sample(psi=columns["psi"][0], psi_dot=0.0, F_N=columns["F_N"][0], dt=0.01)


def response(system: control.NonlinearIOSystem, columns: dict[str, Array], *start: Array) -> Array:
    inputs = np.array([columns[name] for name in system.input_labels])
    made = control.input_output_response(system, columns["t"], inputs, *start)
    return np.asarray(made.outputs)


def test_says_what_a_run_says_and_the_predictor_form_a_sample_later(
    observer: ModelObserver, recording: RigRecording
) -> None:
    columns = columns_of(recording)
    made, tuning, close = run(observer, **columns), observer.tuning, {"atol": 1e-9, "rtol": 1e-9}
    said, later = (
        response(as_system(observer, first_of(columns), direct=direct), columns)
        for direct in (True, False)
    )

    np.testing.assert_array_equal(later[:, 0], [tuning.mu, tuning.mu_std, *[0] * 8])
    for now, then, name in zip(said, later, ESTIMATE, strict=True):
        expected = np.nan_to_num(getattr(made, name))
        np.testing.assert_allclose(now, expected, **close, err_msg=name)
        np.testing.assert_allclose(then[1:], expected[:-1], **close, err_msg=name)


def test_nan_is_a_missing_measurement(observer: ModelObserver, recording: RigRecording) -> None:
    first = first_of(columns_of(recording))
    system, start = as_system(observer, first), observer.init(first)
    given = {name: getattr(first, name) for name in system.input_labels}
    given["psi" if "psi" in observer.states else "M_z"] = np.nan
    u = np.array(list(given.values()))
    after = observer.step(start, Sample(**{"psi_dot": np.nan, **given, "dt": 0.01}))

    assert Status(int(system.output(0.0, start.values, u)[-1])) & Status.MISSING
    np.testing.assert_array_equal(system.dynamics(0.0, start.values, u), after.values)


def test_zeros_stand_for_the_start(observer: ModelObserver, recording: RigRecording) -> None:
    columns = columns_of(recording)
    first = first_of(columns)
    system = as_system(observer, first)

    with_state = response(system, columns, observer.init(first).values)
    np.testing.assert_array_equal(response(system, columns), with_state)


def test_its_signals_have_the_names_of_samples(observer: ModelObserver, recording: RigRecording) -> None:
    system = as_system(observer, first_of(columns_of(recording)))
    hand = "M" in observer.channels

    assert system.input_labels == (["psi", "F_N", "M"] if hand else ["psi", "psi_dot", "F_N", "M_z"])
    assert system.output_labels == list(ESTIMATE)
    size = observer.init(first_of(columns_of(recording))).values.size
    assert system.nstates == size == len(set(system.state_labels))
    assert "x[0]" in system.state_labels
    assert (system.dt, system.name) == (0.01, type(observer).__name__.lower())


def closed(
    observer: ModelObserver, first: Sample, torque: str, direct: bool
) -> control.InterconnectedSystem:
    """A loop without delay: the torque depends on mu, and what is said of mu on the torque."""
    named = {"inputs": ["mu"], "outputs": [torque], "name": "hand"}
    hand = control.nlsys(None, lambda _t, _x, u, _p: 2.0 * u[0], dt=0.01, **named)
    system = as_system(observer, first, direct=direct)
    free = [name for name in system.input_labels if name != torque]
    return control.interconnect([system, hand], inputs=free, outputs=["mu", torque], check_unused=False)


def test_a_loop_closed_over_the_predictor_form(recording: RigRecording) -> None:
    observer, columns = OBSERVERS["steering"](), columns_of(recording)
    first = first_of(columns)
    mu, M = response(closed(observer, first, "M", direct=False), columns)

    state, said = observer.init(first), []
    for psi, F_N in zip(columns["psi"], columns["F_N"], strict=True):
        said.append(observer.estimate(state).mu)
        sample = Sample(psi=psi, psi_dot=np.nan, F_N=F_N, dt=0.01, M=2.0 * said[-1])
        state = observer.step(state, sample)
    np.testing.assert_allclose(mu, said, rtol=0, atol=1e-9)
    np.testing.assert_array_equal(M, 2.0 * mu)
    assert np.ptp(mu) > 0


def test_a_loop_closed_over_the_direct_form_is_algebraic(recording: RigRecording) -> None:
    observer, columns = OBSERVERS["ekf"](), columns_of(recording)

    with pytest.raises(RuntimeError, match="algebraic loop"):
        response(closed(observer, first_of(columns), "M_z", direct=True), columns)
    response(closed(observer, first_of(columns), "M_z", direct=False), columns)


def test_needs_a_state_that_is_one_vector(recording: RigRecording) -> None:
    root: Any = RootObserver(rig=RIG, k=K)

    assert "Ekf or Mhe, got RootObserver" in refused(as_system, root, first_of(columns_of(recording)))


def test_observers_do_without_control(repository_root: Path) -> None:
    """Control loads matplotlib and takes a second; those who only observe do not wait for it."""
    code = "import sys, observers; sys.exit('control' in sys.modules or 'matplotlib' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], cwd=repository_root, check=True)
