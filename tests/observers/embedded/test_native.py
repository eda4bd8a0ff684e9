"""Generated C on this machine estimates what Python estimates."""

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pytest

from observers import Ekf, Mhe, run
from observers.embedded import DOUBLE, SINGLE, native
from reference_rig import RigRecording
from tests.observers.conftest import RIG
from tests.observers.embedded.generated_code import DECLARED, needs_compiler
from tests.refusal import refused

Native = Callable[[Any, native.Real], native.NativeObserver]


@pytest.fixture(scope="module")
def compiled_native() -> Native:
    """Compiles the kind of observer on the declared model, each once."""
    return cache(lambda kind, real: native.compile_native(kind(**DECLARED, rig=RIG), real))


@needs_compiler
@pytest.mark.parametrize(("real", "within"), [(DOUBLE, 1e-9), (SINGLE, 5e-5)])
@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
def test_estimates_are_those_of_python(
    compiled_native: Native,
    kind: type[Ekf] | type[Mhe],
    real: native.Real,
    within: float,
    recording: RigRecording,
) -> None:
    observer = kind(**DECLARED, rig=RIG)
    M_z = recording.M_z.copy()
    M_z[50:60] = np.nan
    code = compiled_native(kind, real).run(recording.t, recording.psi, recording.F_N, M_z)
    python = run(observer, recording.t, recording.psi, recording.F_N, M_z)

    np.testing.assert_allclose(code.mu, python.mu, rtol=within)
    np.testing.assert_allclose(code.mu_std, python.mu_std, rtol=20 * within)
    np.testing.assert_array_equal(code.informed, python.informed)
    np.testing.assert_array_equal(code.status, python.status)


@needs_compiler
def test_every_recording_starts_from_the_prior(compiled_native: Native, recording: RigRecording) -> None:
    code = compiled_native(Ekf, SINGLE)
    channels = recording.t, recording.psi, recording.F_N, recording.M_z

    np.testing.assert_array_equal(code.run(*channels).mu, code.run(*channels).mu)


@needs_compiler
def test_shapes_are_checked(compiled_native: Native) -> None:
    code, t = compiled_native(Ekf, SINGLE), np.arange(5.0)

    assert "shape of t" in refused(code.run, t, t, t, t[:-1])


def test_without_a_compiler_there_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native, "compiler", lambda: None)

    assert "no C compiler" in refused(native.compile_native, Ekf(**DECLARED, rig=RIG))


@needs_compiler
def test_a_failing_compiler_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(native, "COMPILER_FLAGS", ("-no-such-flag",))

    assert "was not compiled" in refused(native.compile_native, Ekf(**DECLARED, rig=RIG))
