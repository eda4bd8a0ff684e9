"""Friction from the force on a car's rack, against bristles and dry friction of their own."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from observers import (
    CLEAN,
    Ekf,
    Estimates,
    Mhe,
    RackForce,
    Sample,
    Status,
    build_clean,
    car_observer,
    run,
)
from observers import run_standstills as over_standstills
from observers.quality.acquisition import OWN
from observers.udu import covariance_of
from symbolic import Vehicle
from symbolic.vehicle.mean_wheel import aligning_torque_with_friction, equivalent_contact_angle
from symbolic.vehicle.steering import mean_wheel_angle
from tests.simulated_car import SimulatedCar, declared_vehicle, steering

CAR = declared_vehicle()


def driven(car: SimulatedCar, vehicle: Vehicle = CAR) -> tuple[Any, ...]:
    """Time, angle, load and torque of the mean wheel."""
    t, rack = steering()
    psi = equivalent_contact_angle(vehicle, mean_wheel_angle(vehicle, rack), brakes=True)
    M_z = aligning_torque_with_friction(vehicle, rack, car.force(rack), brakes=True)
    return t, psi, np.full(t.size, vehicle.wheel_load), M_z


def estimates(car: SimulatedCar, vehicle: Vehicle = CAR, kind: Any = Ekf) -> Estimates:
    return run(car_observer(kind, vehicle), *driven(car, vehicle))


def final(car: SimulatedCar, **options: Any) -> tuple[float, float]:
    found = estimates(car, **options)
    known = np.flatnonzero(found.usable)
    assert known.size > 0
    return float(found.mu[known[-1]]), float(found.mu_std[known[-1]])


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
@pytest.mark.parametrize("mu", [0.15, 0.4, 1.0])
def test_friction_of_a_car(mu: float, kind: Any) -> None:
    found, std = final(SimulatedCar(mu=(mu, mu)), kind=kind)

    assert found == pytest.approx(mu, rel=0.06)
    assert 0.03 < std / found < 0.15


@pytest.mark.parametrize("gear", [100.0, 300.0])
@pytest.mark.parametrize("mu", [0.2, 0.6])
def test_gear_friction_is_learnt(mu: float, gear: float) -> None:
    found, std = final(SimulatedCar(mu=(mu, mu), gear=gear))

    # Where it is not learnt, 100 N more or less at the rack look like a mu of 0.03.
    assert abs(found - mu) < max(0.025, 0.06 * mu)
    assert abs(found - mu) < 1.5 * std


@pytest.mark.parametrize("gear", [130.0, 270.0])
def test_ice_under_a_heavy_gear(gear: float) -> None:
    # The tyres' own force is 230 N.
    found, std = final(SimulatedCar(mu=(0.06, 0.06), gear=gear))

    assert abs(found - 0.06) < 0.015
    assert abs(found - 0.06) < 2 * std < 0.03


@pytest.mark.parametrize(
    "wrong", [{"gear_friction": 800.0}, pytest.param({"half_length": 0.03}, marks=pytest.mark.long)]
)
def test_what_is_declared_wrong_is_not_usable_and_wrong(wrong: dict[str, float]) -> None:
    vehicle = declared_vehicle(**wrong)
    found = estimates(SimulatedCar(mu=(0.3, 0.3)), vehicle)
    away = np.abs(found.mu - 0.3) / found.mu_std

    assert not (found.usable & (away > 3)).any()


@pytest.mark.parametrize(("side", "stds"), [(-1, 1.96), (1, 2.8)])
def test_all_declared_values_off_at_once(side: int, stds: float) -> None:
    vehicle = declared_vehicle(
        front_axle_load=8000 * (1 + 0.1 * side), half_length=0.055 * (1 + 0.15 * side),
        contact_width=0.16 * (1 + 0.03 * side), steering_arm=0.125 * (1 - 0.03 * side),
        gear_friction=200 * (1 + 0.5 * side),
    )  # fmt: skip
    found, std = final(SimulatedCar(mu=(0.8, 0.8)), vehicle=vehicle)

    assert 0.14 < abs(found - 0.8) < stds * std


def test_the_error_of_the_return_torque_has_that_of_the_load_in_it() -> None:
    leaning = declared_vehicle(inclination=0.2)
    known = replace(leaning, tolerances=replace(leaning.tolerances, load=0.0))
    wide, narrow = (RackForce.of(each).jacking for each in (leaning, known))

    # Angles within 1 deg make 8 %, a load within 10 % has 5.8 %.
    assert wide / narrow == pytest.approx(np.hypot(0.08, 0.1 / 3**0.5) / 0.08)


def test_other_friction_left_and_right_is_their_mean() -> None:
    assert estimates(SimulatedCar(mu=(0.3, 0.6))).mu[-1] == pytest.approx(0.45, rel=0.1)


def test_the_gear_turns_over_at_once_ignores_noise_and_may_be_anything_at_rest() -> None:
    clean = build_clean(RackForce.of(CAR))
    now: Any = np.zeros(len(CLEAN))

    def after(psi: float) -> dict[str, float]:
        nonlocal now
        sample = [psi, 0.0, 4000.0, 0.01, 1.0, np.nan]
        now, _ = clean(sample, now)
        return dict(zip(CLEAN, np.array(now).ravel().tolist(), strict=True))

    forth = [after(psi) for psi in (0.0, 0.01, 0.02)][-1]
    still = [after(0.02 + noise) for noise in (1e-4, -1e-4, 5e-5)][-1]
    back = after(0.017)

    # Half the lever, 0.125 m, times 200 N, and 2 % of the torque.
    assert forth["dry"] == pytest.approx(-12.52, rel=1e-3)
    assert still["dry"] == pytest.approx(forth["dry"], rel=1e-3)
    assert back["dry"] == pytest.approx(12.4, rel=0.02)
    first: Any = np.zeros(len(CLEAN))
    seen = [np.array(clean([psi, 0.0, 4000.0, 0.01, 1.0, np.nan], first)[0]) for psi in (0.0, 0.02)]
    resting, turning = (dict(zip(CLEAN, each.ravel().tolist(), strict=True)) for each in seen)
    # 12.5 N m of gear friction, evenly between both signs.
    assert resting["dry_std"] > 12.5 / 3**0.5 > 2 * turning["dry_std"]


def test_held_while_the_car_rolls() -> None:
    columns, observer = driven(SimulatedCar()), car_observer(Ekf, CAR)
    stretch = np.zeros(columns[0].size, dtype=int)
    stretch[600:700], stretch[700:] = -1, 1
    found = over_standstills([observer, observer], stretch, *columns)
    alone = run(observer, *(column[:600] for column in columns))

    np.testing.assert_array_equal(found.mu[:600], alone.mu)
    np.testing.assert_array_equal(found.mu[600:700], alone.mu[-1])
    assert (found.status[600:700] == Status.HELD).all()
    assert not found.usable[600:700].any()
    assert found.status[700] & Status.ACQUIRING


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
def test_what_is_known_of_tyre_and_gear_together_is_handed_over(kind: Any) -> None:
    _, psi, _, M_z = driven(SimulatedCar(mu=(0.08, 0.08)))
    observer = car_observer(kind, CAR)
    assert isinstance(observer, Ekf | Mhe)
    samples = [
        Sample(psi=a, psi_dot=np.nan, F_N=CAR.wheel_load, dt=0.01, M_z=m)
        for a, m in zip(psi, M_z, strict=True)
    ]
    state = observer.init(samples[0])
    for sample in samples:
        state = observer.step(state, sample)
        if not state["own"][OWN.index("acquiring")]:
            break
    P = covariance_of(state["factor"])
    mu, gear = observer.states.index("log_mu"), observer.states.index("gear")

    # Full slide tells their sum: what one of them is too large, the other one is too small.
    assert not state["own"][OWN.index("acquiring")]
    assert P[mu, gear] < -0.2 * np.sqrt(P[mu, mu] * P[gear, gear])
    if kind is Mhe:
        assert state["P_newest"] == pytest.approx(P, rel=1e-9, abs=1e-12)
