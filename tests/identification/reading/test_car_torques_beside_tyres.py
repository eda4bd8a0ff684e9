"""What a vehicle declares beside the tyres' torque: taken off, and known to its tolerance in a fit."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from identification import Recording, fit, read_recording
from identification.fits.least_squares_problem import LeastSquaresProblem
from identification.fits.options import FitOptions
from identification.fits.values_by_ground_and_recording import initial_guess
from identification.reading.car_torques_beside_tyres import (
    declared_vehicle_torques,
    widest_standstill_less_gear,
)
from identification.reading.trimming_and_thinning import trimmed
from symbolic import Model
from tests.columns import write_columns
from tests.simulated_car import SimulatedCar, declared_vehicle, steering

pytestmark = pytest.mark.usefixtures("interpreted")


def recorded(path: Path, *, rolls: bool = False, **declared: object) -> Recording:
    """The car of the tests, its gear of 200 N; with `rolls` it drives a while after 2 s."""
    vehicle = declared_vehicle(**declared)
    t, rack = steering(seconds=6.0)
    speed = np.where(rolls & (t > 2.0) & (t < 2.5), 1.0, 0.0)
    write_columns(path, {"t": t, "rack": rack, "F_rack": SimulatedCar().force(rack), "speed": speed})
    return read_recording(path, vehicle=vehicle)


def test_the_declared_gear_is_taken_off(tmp_path: Path) -> None:
    whole = recorded(tmp_path / "car.csv", gear_load_share=0.0)
    alone, note = widest_standstill_less_gear(whole)
    turning = np.flatnonzero(np.abs(whole.psi_dot) > 0.1)[1:]

    assert note == ""
    taken, side = (alone.M_z - whole.M_z)[turning], np.sign(whole.psi_dot[turning])
    np.testing.assert_allclose(taken, 12.5 * side, rtol=0.02)


def test_a_gear_declared_wrongly_is_found_within_its_tolerance(tmp_path: Path) -> None:
    whole = recorded(tmp_path / "car.csv", gear_friction=250.0, gear_load_share=0.0)
    alone, _ = widest_standstill_less_gear(whole)
    fitted = fit(Model(corners=16), [alone])

    assert set(declared_vehicle_torques(alone)) == {"gear_share"}
    assert fitted.values.rig["car"]["gear_share"] == pytest.approx(200 / 250, abs=0.06)
    assert fitted.values.own["car"]["mu"] == pytest.approx(0.5, rel=0.06)


def test_derivatives_by_the_shares(tmp_path: Path) -> None:
    declared = {"inclination": 0.2, "caster": 0.05, "damping": 20.0}
    alone, _ = widest_standstill_less_gear(recorded(tmp_path / "car.csv", **declared))
    model = Model(corners=16)
    problem = LeastSquaresProblem(model, [alone], initial_guess(model, [alone]), FitOptions())
    x = problem.start_coordinates()
    shares = [i for i, (_, name) in enumerate(problem.labels) if name.endswith("_share")]

    assert len(shares) == 4
    for i in shares:
        step = 1e-3 * np.eye(x.size)[i]
        slope = (problem.residuals(x + step) - problem.residuals(x - step)) / 2e-3
        np.testing.assert_allclose(problem.jacobian(x)[:, i], slope, atol=1e-9)


def test_the_standstill_with_most_steering_is_kept(tmp_path: Path) -> None:
    whole = recorded(tmp_path / "car.csv", rolls=True)
    alone, note = widest_standstill_less_gear(trimmed(whole, 1.0, 5.5))

    assert (alone.t[0], alone.t[-1]) == (2.5, 5.5)
    assert "of 2 standstills that from 2.5 to 5.5 s" in note
    assert np.isfinite(alone.M_z).all()


def test_a_wheel_on_a_rig_stays_as_it_is(tmp_path: Path) -> None:
    wheel = replace(recorded(tmp_path / "car.csv"), standstills=None)

    assert widest_standstill_less_gear(wheel) == (wheel, "")
    assert declared_vehicle_torques(wheel) == {}
