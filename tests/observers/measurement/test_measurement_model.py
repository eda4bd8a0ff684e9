"""Each way of hearing friction without one of its sensors, before the first sample, without a rig."""

from dataclasses import replace
from math import inf, isnan, nan
from typing import Any

import numpy as np
import pytest

from observers import SAMPLE, AligningTorque, Ekf, MeasurementModel, Mhe, Sample, SteeringTorque
from observers.measurement.measurement_model import CLEAN
from observers.measurement.motion_and_torque_jacobians import build_clean
from symbolic import InvalidInputError, Rig
from tests.observers.conftest import RIG, make
from tests.refusal import refused

GOOD = {"psi": 0.1, "psi_dot": 0.2, "F_N": 410.0, "dt": 0.01, "M_z": -2.0, "M": 3.0}
LAST = {"psi": 0.05, "psi_dot": 0.3, "F_N": 390.0, "dt": 0.02, "M_z": -1.0, "M": 1.5, "M_age": 0.0,
        "F_N_first": 400.0, "interval": 0.02, "travel": 0.5}  # fmt: skip
NOTHING = (nan, inf, -inf)


def cleaned(measurement_model: MeasurementModel, **fault: float) -> tuple[dict[str, float], bool]:
    sample = [(GOOD | fault)[name] for name in SAMPLE]
    now, held = build_clean(measurement_model)(sample, [LAST.get(name, 0.0) for name in CLEAN])
    found = dict(zip(CLEAN, np.asarray(now).ravel().tolist(), strict=True))
    # Without a steering gear nothing of one is kept.
    assert not any(value for name, value in found.items() if name not in LAST)
    return {name: value for name, value in found.items() if name in LAST}, bool(held)


def test_a_good_sample_passes() -> None:
    aligning, held = cleaned(AligningTorque())
    assert aligning == {
        **GOOD, "M": 0.0, "M_age": 0.0, "F_N_first": 400.0, "interval": 0.01, "travel": 0.2 * 0.01
    }  # fmt: skip
    assert not held
    steering, held = cleaned(SteeringTorque())
    assert steering == {
        **GOOD, "psi_dot": 0.0, "M_z": 0.0, "M_age": 0.0, "F_N_first": 400.0, "interval": 0.01,
        "travel": 0.0,
    }  # fmt: skip
    assert not held


@pytest.mark.parametrize("nothing", NOTHING)
def test_torques_without_a_sensor(nothing: float) -> None:
    now, held = cleaned(AligningTorque(), psi=nothing)
    assert (now["psi"], now["psi_dot"], held) == (LAST["psi"], 0.0, True)
    assert isnan(now["M_z"]), "a torque at an unknown angle says nothing"
    now, held = cleaned(AligningTorque(), psi_dot=nothing)
    assert (now["psi"], now["psi_dot"], now["M_z"], held) == (GOOD["psi"], 0.0, GOOD["M_z"], False)
    now, held = cleaned(AligningTorque(), M_z=nothing)
    assert (now["psi"], now["psi_dot"], held) == (GOOD["psi"], GOOD["psi_dot"], False)
    assert not np.isfinite(now["M_z"])
    now, held = cleaned(AligningTorque(), M=nothing)
    assert (now["M"], now["M_age"], held) == (0.0, 0.0, False)
    now, held = cleaned(SteeringTorque(), M=nothing)
    assert (now["M"], now["M_age"], held) == (LAST["M"], GOOD["dt"], True)
    now, held = cleaned(SteeringTorque(), psi=nothing)
    assert (now["M"], now["M_age"], held) == (GOOD["M"], 0.0, False)
    assert not np.isfinite(now["psi"])
    for name in ("psi_dot", "M_z"):
        now, held = cleaned(SteeringTorque(), **{name: nothing})
        assert (now[name], held) == (0.0, False)


@pytest.mark.parametrize("measurement_model", [AligningTorque(), SteeringTorque()], ids=repr)
@pytest.mark.parametrize("nothing", [*NOTHING, 0.0, -400.0, 1e-300, 0.03, 19.99])
def test_without_a_load_the_last_is_held(measurement_model: MeasurementModel, nothing: float) -> None:
    now, held = cleaned(measurement_model, F_N=nothing)
    assert (now["F_N"], held) == (LAST["F_N"], True)


def test_a_torque_stands_for_time_and_turn_since_the_one_before() -> None:
    """A gap is no reason to take the sensor for less noisy than it is in 10 ms."""
    waiting = LAST | {"M_z": nan, "interval": 0.003, "travel": 0.5}
    sample = GOOD | {"dt": 0.001}
    for dt, last, interval, travel in (
        (0.001, waiting, 0.004, 0.5002),
        (0.001, waiting | {"interval": 0.02}, 0.01, 0.5002),
        (0.001, LAST, 0.001, 0.0002),
        (0.02, waiting, 0.02, 0.504),
    ):
        given = [(sample | {"dt": dt})[name] for name in SAMPLE]
        now, _ = build_clean(AligningTorque())(given, [last.get(name, 0.0) for name in CLEAN])
        found = dict(zip(CLEAN, np.asarray(now).ravel().tolist(), strict=True))
        assert (found["interval"], found["travel"]) == pytest.approx((interval, travel))


def test_the_torque_of_a_wheel_that_is_lifted_says_nothing() -> None:
    for F_N in (0.0, -1.0, 0.03, 19.99):
        assert isnan(cleaned(AligningTorque(), F_N=F_N)[0]["M_z"])
    for F_N in (nan, inf, 20.01):
        assert cleaned(AligningTorque(), F_N=F_N)[0]["M_z"] == GOOD["M_z"]
    assert cleaned(AligningTorque(), F_N=20.01)[0]["F_N"] == 20.01


@pytest.mark.parametrize("kind", [Ekf, Mhe])
@pytest.mark.parametrize("fault", [{"psi": nan}, {"psi": inf}, {"F_N": nan}, {"F_N": 0.0}, {"F_N": inf}])
def test_first_sample_says_where_the_patch_stands(kind: Any, fault: dict[str, float]) -> None:
    first = Sample(**{"psi": 0.0, "psi_dot": nan, "F_N": 400.0, "dt": 0.01, **fault})
    assert "first sample must have a finite psi and F_N >= 0.001 N" in refused(make(kind).init, first)


@pytest.mark.parametrize("dt", [0.0, -0.01, nan, inf])
def test_a_sample_needs_its_time(dt: float) -> None:
    with pytest.raises(InvalidInputError, match="dt > 0 s and at most 3600 s"):
        Sample(psi=0.0, psi_dot=0.0, F_N=400.0, dt=dt)


@pytest.mark.parametrize("kind", [Ekf, Mhe])
def test_steering_torque_needs_the_inertia_and_the_damping(kind: Any) -> None:
    for rig, missing in ((Rig(a=0.045, e=0.009), "J_A and b_t"), (replace(RIG, b_t=None), "lacks b_t")):
        with pytest.raises(InvalidInputError, match=missing):
            make(kind, rig=rig, measurement_model=SteeringTorque())
        make(kind, rig=rig, measurement_model=AligningTorque())


@pytest.mark.parametrize("kind", [Ekf, Mhe])
@pytest.mark.parametrize("wrong", [AligningTorque, "M_z"])
def test_anything_but_a_measurement_model_is_refused(kind: Any, wrong: Any) -> None:
    with pytest.raises(InvalidInputError, match=r"another observers\.MeasurementModel, with brackets"):
        make(kind, measurement_model=wrong)
