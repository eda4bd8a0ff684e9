"""The observer of a car in C: equal to Python, its sensors too, within its budget on a Cortex-M4F."""

import ctypes
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.embedded import adversarial
from observers import Ekf, Mhe, car_observer
from observers.embedded import DOUBLE, SINGLE, generate, generate_vehicle
from observers.embedded.estimated_instructions import ERROR, estimated_instructions
from symbolic.vehicle.mean_wheel import (
    aligning_torque_with_friction,
    equivalent_contact_angle,
    wheel_from_rack,
)
from symbolic.vehicle.steering import mean_wheel_angle, pinion_angle, rack_and_gain, rack_force
from tests.compile_once import compile_once
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.cortex.target import M4F, TOOLS, run_on, tools_installed
from tests.observers.embedded.generated_code import python_estimates
from tests.observers.embedded.ordinary_steering import samples_at_the_cap
from tests.simulated_car import SimulatedCar, declared_vehicle, steering

CAR = declared_vehicle(inclination=0.2, caster=0.1, lever_loss=0.2)
MOST_INSTRUCTIONS, MOST_MEMORY = 20_000, 4096
"""Of a step, and of state and stack together [bytes]."""


@pytest.fixture(scope="module")
def rows() -> np.ndarray:
    t, rack = steering(seconds=8.0)
    psi = equivalent_contact_angle(CAR, mean_wheel_angle(CAR, rack), brakes=True)
    M_z = aligning_torque_with_friction(CAR, rack, SimulatedCar(mu=(0.3, 0.3)).force(rack), brakes=True)
    same = np.ones(t.size)
    return SINGLE.round(np.column_stack([psi, np.nan * same, M_z, 4000.0 * same, 0.01 * same]))


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
def test_c_is_python(generated: Generate, rows: np.ndarray, kind: type[Ekf] | type[Mhe]) -> None:
    observer = car_observer(kind, CAR)
    expected = python_estimates(observer, rows)

    np.testing.assert_allclose(generated(observer, DOUBLE).run(rows)[:, :2], expected[:, :2], rtol=1e-9)
    np.testing.assert_allclose(generated(observer, SINGLE).run(rows)[:, :2], expected[:, :2], rtol=2e-3)


@pytest.mark.long
@pytest.mark.skipif(not tools_installed(), reason=TOOLS)
def test_budget_on_the_target(generated: Generate, rows: np.ndarray) -> None:
    code = generated(car_observer(Ekf, CAR), SINGLE)
    at_cap = SINGLE.round(samples_at_the_cap(code.observer))
    costs = [run_on(M4F, code, part) for part in (rows, at_cap, adversarial())]
    most, stack = max(cost.most for cost in costs), max(cost.stack for cost in costs)
    state, mean = costs[0].state, costs[0].instructions
    print(f"a car: {mean:.0f} instructions a step, at most {most}; state {state}, stack {stack} bytes")

    told = estimated_instructions(code.observer)
    assert told.at_most is not None
    assert told.instructions == pytest.approx(mean, rel=ERROR)
    assert most <= told.at_most <= MOST_INSTRUCTIONS
    assert state + stack <= MOST_MEMORY


def test_sensors_of_a_car_in_c(tmp_path: Path) -> None:
    car = replace(CAR, rack_by_handwheel=((1.0, 0.008), (2.0, 0.018), (4.0, 0.042)), motor_ratio=20.0)
    generate(car_observer(Ekf, car), tmp_path, DOUBLE, name="grip")
    generate_vehicle(car, tmp_path, DOUBLE, name="grip")
    (tmp_path / "use.c").write_text(
        '#include "grip_vehicle.h"\n'
        "void use(double s, double F, double *out) {\n"
        "    const grip_sample_t sample = grip_from_rack(s, F, 0.0, 0.0, 0.01);\n"
        "    out[0] = sample.psi; out[1] = sample.M_z; out[2] = sample.F_N;\n}\n"
        "void turn(double handwheel, double T, double *out) {\n"
        "    const grip_sample_t sample = grip_from_handwheel(handwheel, T, T, 0.0, 0.0, 0.01);\n"
        "    out[0] = sample.psi; out[1] = sample.M_z;\n}\n"
    )
    flags = ["-std=c99", "-Wall", "-Wextra", "-Wno-unused-function", "-Werror", "-fPIC", "-shared"]
    compile_once(["cc", *flags, "use.c", "-o", "use.so", "-lm"], tmp_path, "use.so")
    library, out = ctypes.CDLL(str(tmp_path / "use.so")), (ctypes.c_double * 3)()
    library.use(ctypes.c_double(0.04), ctypes.c_double(-900.0), out)
    psi = equivalent_contact_angle(CAR, mean_wheel_angle(CAR, 0.04), brakes=True)

    M_z = aligning_torque_with_friction(CAR, 0.04, -900.0, brakes=True)
    assert list(out) == pytest.approx([psi, M_z, 4000.0])
    for angle in (-6.0, -2.5, 0.3, 3.0):
        library.turn(ctypes.c_double(angle), ctypes.c_double(1.5), out)
        pinion = pinion_angle(car, angle, 1.5)
        moved = (rack_and_gain(car, pinion)[0], rack_force(car, 1.5, 1.5, pinion), 0.0, 0.0)
        assert list(out)[:2] == pytest.approx(wheel_from_rack(car, *moved, brakes=True))
