"""Generated C run on this machine says what Python says."""

import numpy as np
import pytest

from observers import Ekf, Mhe, SteeringTorque, run
from observers.embedded import DOUBLE, SINGLE, native
from reference_rig.record import RigRecording
from reference_rig.steering import SteeringRecording
from symbolic import InvalidInputError
from symbolic.compiled import compiler
from tests.observers.conftest import RIG
from tests.observers.embedded.building import DECLARED, NO_COMPILER, observer_of

needs_compiler = pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)


@needs_compiler
@pytest.mark.parametrize(("real", "within"), [(DOUBLE, 1e-9), (SINGLE, 2e-5)])
@pytest.mark.parametrize("kind", [Ekf, Mhe])
def test_it_says_what_python_says(
    kind: type[Ekf] | type[Mhe], real: native.Real, within: float, recording: RigRecording
) -> None:
    observer = kind(**DECLARED, rig=RIG)
    M_z = recording.M_z.copy()
    M_z[50:60] = np.nan
    code = native.compile_native(observer, real).run(recording.t, recording.psi, recording.F_N, M_z)
    python = run(observer, recording.t, recording.psi, recording.F_N, M_z)

    np.testing.assert_allclose(code.mu, python.mu, rtol=within)
    np.testing.assert_allclose(code.mu_std, python.mu_std, rtol=20 * within)
    np.testing.assert_array_equal(code.informed, python.informed)
    np.testing.assert_array_equal(code.status, python.status)


@needs_compiler
def test_it_begins_anew_with_every_recording(recording: RigRecording) -> None:
    code = native.compile_native(Ekf(**DECLARED, rig=RIG))
    channels = recording.t, recording.psi, recording.F_N, recording.M_z

    np.testing.assert_array_equal(code.run(*channels).mu, code.run(*channels).mu)


@needs_compiler
def test_the_steering_torque_too(steered: SteeringRecording) -> None:
    observer = observer_of(Ekf, DECLARED, SteeringTorque())
    code = native.compile_native(observer, DOUBLE).run(steered.t, steered.psi, steered.F_N, steered.M)
    python = run(observer, steered.t, steered.psi, steered.F_N, M=steered.M)

    np.testing.assert_allclose(code.mu, python.mu, rtol=1e-9)


@needs_compiler
def test_shapes_are_checked() -> None:
    code, t = native.compile_native(Ekf(**DECLARED, rig=RIG)), np.arange(5.0)

    with pytest.raises(InvalidInputError, match="shape of t"):
        code.run(t, t, t, t[:-1])


def test_without_a_compiler_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native, "compiler", lambda: None)

    with pytest.raises(InvalidInputError, match="no C compiler"):
        native.compile_native(Ekf(**DECLARED, rig=RIG))


@needs_compiler
def test_what_the_compiler_refuses_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native, "FLAGS", ("-no-such-flag",))

    with pytest.raises(InvalidInputError, match="was not compiled"):
        native.compile_native(Ekf(**DECLARED, rig=RIG))
