"""Subclasses of a user's own of an observer or a measurement model run in generated C as in Python."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import pytest

from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import DOUBLE
from observers.embedded.compact_codegen import compact_patch
from observers.estimators.casadi_observer import CasadiObserver
from reference_rig import RigRecording
from symbolic import Model
from tests.contributing import example
from tests.observers.conftest import make
from tests.observers.embedded.generated_code import (
    assert_same,
    generate_code,
    needs_compiler,
    rows_of,
)

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


NAMES: dict[str, Any] = {}
exec(example("new sensing"), NAMES)
ViscousTorque = NAMES["ViscousTorque"]


@dataclass(frozen=True, kw_only=True)
class ScaledAngle(AligningTorque):
    """A sample whose angle is scaled before anything sees it."""

    def clean(self, sample: Any, last: Any) -> Any:
        return super().clean({**sample, "psi": 1.1 * sample["psi"]}, last)


@dataclass(frozen=True, kw_only=True)
class GearedTorque(SteeringTorque):
    """A torque that is measured before a gear, and a sensor that hangs on a spring with the wheel."""

    def motion(self, x: Any, M_z: Any, last: Any, now: Any, rig: Any, tuning: Any) -> Any:
        geared = {**last, "M": 1.2 * last["M"] - 0.5 * x["psi"]}
        return super().motion(x, M_z, geared, now, rig, tuning)


CASES = {
    "step-ekf": (HalfEkf, {}),
    "step-mhe": (HalfMhe, {"window": 3}),
    "measurement-ekf": (Ekf, {"measurement_model": ViscousTorque()}),
    "measurement-mhe": (Mhe, {"measurement_model": ViscousTorque(), "window": 3}),
    "motion-ekf": (Ekf, {"measurement_model": GearedTorque()}),
    "motion-mhe": (Mhe, {"measurement_model": GearedTorque(), "window": 3}),
    "clean-ekf": (Ekf, {"measurement_model": ScaledAngle()}),
    "clean-mhe": (Mhe, {"measurement_model": ScaledAngle(), "window": 3}),
}
QUICK = ("step-ekf", "measurement-ekf", "clean-mhe")


@needs_compiler
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

    # A subclass of an observer may compute anything; a measurement model is used by its expressions.
    assert (compact_patch(observer, DOUBLE) is not None) is (type(observer) in (Ekf, Mhe))
    # A steering torque that balances the aligning one.
    rows = rows_of(recording)[:SAMPLES] * [1, 1, 1 if observer.channel == "M_z" else -1, 1, 1]
    assert_same(generate_code(observer, DOUBLE, tmp_path), rows)
