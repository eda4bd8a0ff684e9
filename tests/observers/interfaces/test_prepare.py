"""What a control loop must not wait for is done beforehand."""

import math
from importlib import import_module

import pytest

import observers.compiled_step
import observers.estimators.casadi_observer
from observers import Ekf, Mhe, Sample, SteeringTorque
from symbolic import Model, Rig, compiled, compiler

RIG = Rig(a=0.045, e=0.009, J_A=0.14, b_t=1.5)


@pytest.mark.parametrize("kind", [Ekf, Mhe])
@pytest.mark.parametrize("steering", [False, True])
@pytest.mark.usefixtures("interpreted")
def test_the_first_sample_compiles_nothing(
    monkeypatch: pytest.MonkeyPatch, kind: type[Ekf] | type[Mhe], steering: bool
) -> None:
    observers.estimators.casadi_observer.compiled_step.cache_clear()
    begun = []
    monkeypatch.setattr(observers.compiled_step, "compiled", lambda f, **_: begun.append(f) or f)
    model = SteeringTorque() if steering else None
    more = {} if model is None else {"measurement_model": model}
    observer = kind(model=Model(), values={"k": 2.4e6}, rig=RIG, **more)
    observer.prepare()
    count = len(begun)
    first = Sample(psi=0.1, psi_dot=0.0, F_N=400.0, dt=0.01, M_z=0.3, M=0.3)
    estimate = observer.estimate(observer.step(observer.init(first), first))

    assert count == len(begun) == 1
    assert math.isfinite(estimate.mu)


def test_that_nothing_compiles_is_said(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    module = import_module("symbolic.compilation.compiled_function_cache")

    function = Model().step
    monkeypatch.setenv("CC", "no-such-compiler")
    for asked in ("1", ""):
        monkeypatch.setenv("BRUSHGRIP_INTERPRET", asked)
        compiler.cache_clear()
        module._WARNED.clear()
        assert compiled(function) is function
        assert ("no C compiler is found" in caplog.text) == (not asked)
    compiler.cache_clear()
