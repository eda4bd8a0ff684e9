"""Subclasses of a user's own of an observer or a measurement model run in generated C as in Python."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import DOUBLE
from observers.embedded.compact_ekf import is_compact
from observers.embedded.compact_mhe import is_compact_window
from observers.estimators.casadi_observer import CasadiObserver
from reference_rig import RigRecording
from symbolic import Model, compiler
from tests.observers.conftest import make
from tests.observers.embedded.generated_code import (
    NO_COMPILER,
    InterpretedObserver,
    generate_code,
    python_estimates,
)
from tests.observers.factories import columns_of, samples_of

pytestmark = pytest.mark.usefixtures("interpreted")
MODEL = Model(corners=8)
SAMPLES = 150


def halved(observer: CasadiObserver, step: ca.Function) -> ca.Function:
    """The step with half of mu in its output."""
    symbols = [ca.MX.sym(name, *step.size_in(name)) for name in step.name_in()]
    state, output = step(*symbols)
    output = ca.vertcat(output[0] / 2, output[1:])
    parts = {**observer.layout.split(state), "output": output}
    outputs = [observer.layout.join(parts), output]
    return ca.Function("half_step", symbols, outputs, step.name_in(), step.name_out())


@dataclass(frozen=True, kw_only=True)
class HalfEkf(Ekf):
    """A filter with a step of its own."""

    @property
    def step_function(self) -> ca.Function:
        return halved(self, super().step_function)


@dataclass(frozen=True, kw_only=True)
class HalfMhe(Mhe):
    """An estimator with a step of its own."""

    @property
    def step_function(self) -> ca.Function:
        return halved(self, super().step_function)


@dataclass(frozen=True, kw_only=True)
class ViscousTorque(AligningTorque):
    """A measurement that depends on the rate."""

    def measurement(self, x: Any, M_z: Any, now: Any, rig: Any, tuning: Any) -> Any:
        measurement = super().measurement(x, M_z, now, rig, tuning)
        return replace(measurement, expected=measurement.expected - 2.0 * now["psi_dot"])


@dataclass(frozen=True, kw_only=True)
class ScaledAngle(AligningTorque):
    """A sample whose angle is scaled before anything sees it."""

    def clean(self, sample: Any, last: Any) -> Any:
        return super().clean({**sample, "psi": 1.1 * sample["psi"]}, last)


CASES = {
    "step-ekf": (HalfEkf, {}),
    "step-mhe": (HalfMhe, {"window": 3}),
    "measurement-ekf": (Ekf, {"measurement_model": ViscousTorque()}),
    "measurement-mhe": (Mhe, {"measurement_model": ViscousTorque(), "window": 3}),
    "clean-ekf": (Ekf, {"measurement_model": ScaledAngle()}),
    "clean-mhe": (Mhe, {"measurement_model": ScaledAngle(), "window": 3}),
}
QUICK = ("step-ekf", "measurement-ekf", "clean-mhe")


@pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
@pytest.mark.parametrize(
    ("kind", "settings"),
    [
        pytest.param(*case, id=name, marks=[] if name in QUICK else pytest.mark.long)
        for name, case in CASES.items()
    ],
)
def test_c_is_the_same(
    kind: Any, settings: dict[str, Any], recording: RigRecording, tmp_path: Path
) -> None:
    observer = make(kind, model=MODEL, **settings)
    samples = samples_of(columns_of(recording))[:SAMPLES]
    rows = np.array([(s.psi, s.psi_dot, s.M_z, s.F_N, s.dt) for s in samples])

    estimates = generate_code(observer, DOUBLE, tmp_path).run(rows)

    np.testing.assert_array_equal(estimates, python_estimates(InterpretedObserver(observer), rows))
    assert np.ptp(estimates[:, 0]) > 0.005, "no measurement corrected mu"


def test_compact_code_is_for_the_observers_of_the_package_alone() -> None:
    assert is_compact(make(Ekf))
    assert is_compact(make(Ekf, measurement_model=SteeringTorque()))
    assert is_compact_window(make(Mhe))
    assert is_compact_window(make(Mhe, measurement_model=AligningTorque(stiffness=True)))
    assert not is_compact_window(make(Mhe, measurement_model=SteeringTorque()))
    for kind, settings in CASES.values():
        observer = make(kind, **settings)
        assert not is_compact(observer)
        assert not is_compact_window(observer)
