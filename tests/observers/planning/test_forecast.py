from dataclasses import replace
from math import hypot

import numpy as np
import pytest

from observers import AligningTorque, DirectionalFriction, Ekf, Mhe, Sample, SteeringTorque, run
from observers.planning.forecast import Forecaster, irreducible_mu_std
from observers.planning.steering_limits_and_paths import SteeringPath, fastest_path
from symbolic import Rig, Tolerances
from tests.observers.factories import found_model
from tests.observers.planning.conftest import LOAD, RIG, observe_on_rig

pytestmark = pytest.mark.usefixtures("optimised")


@pytest.fixture(scope="module")
def path() -> SteeringPath:
    return fastest_path([0.0, 0.06, -0.06, 0.2], 0.3, 10.0, 0.01, 10.0)


@pytest.mark.parametrize("mu", [0.05, 0.4, 1.2])
def test_the_forecast_is_what_the_observer_says_on_the_rig(
    acquiring: Ekf, path: SteeringPath, mu: float
) -> None:
    forecaster = Forecaster(acquiring)
    forecast = forecaster.forecast_whole(path, forecaster.cases_at_rest([mu], 0.0, LOAD, 0.01)[0], LOAD)
    estimates, torque = observe_on_rig(acquiring, path, mu)
    usable = np.array([one.usable for one in estimates])
    both = forecast.usable & usable

    assert forecast.torque == pytest.approx(torque, abs=2e-3 * np.ptp(torque))
    assert np.count_nonzero(forecast.usable != usable) <= 2
    assert both.sum() > 15
    deviation = np.array([one.mu_std / one.mu for one in estimates])
    assert forecast.deviation[both] == pytest.approx(deviation[both], rel=0.02)
    assert forecast.mu[both] == pytest.approx(mu, rel=0.03)


def test_a_forecast_from_the_present_continues_that_from_the_begin(
    acquiring: Ekf, path: SteeringPath
) -> None:
    forecaster = Forecaster(acquiring)
    whole = forecaster.forecast_whole(path, forecaster.cases_at_rest([0.2], 0.0, LOAD, 0.01)[0], LOAD)
    state = acquiring.init(Sample(psi=0.0, psi_dot=0.0, F_N=LOAD, dt=0.01))
    for psi, psi_dot, torque in zip(path.psi[:50], path.psi_dot, whole.torque, strict=False):
        state = acquiring.step(state, Sample(psi=psi, psi_dot=psi_dot, F_N=LOAD, dt=0.01, M_z=torque))
    rest = replace(path, begin=path.psi[49], psi=path.psi[50:], psi_dot=path.psi_dot[50:])
    later = forecaster.forecast_whole(rest, forecaster.cases_at_state([0.2], state)[0], LOAD)

    assert later.torque == pytest.approx(whole.torque[50:], abs=0.02)
    assert later.deviation == pytest.approx(whole.deviation[50:], rel=1e-3)


def test_what_exceeds_the_torque_does_not_count(acquiring: Ekf, path: SteeringPath) -> None:
    forecaster = Forecaster(acquiring)
    forecast = forecaster.forecast_whole(path, forecaster.cases_at_rest([0.8], 0.0, LOAD, 0.01)[0], LOAD)
    at = forecast.first_within(0.05)

    assert at is not None
    assert forecast.usable[at]
    assert forecast.deviation[at] <= 0.05 < forecast.deviation[at - 1] or not forecast.usable[at - 1]
    assert forecast.first_within(0.05, np.abs(forecast.torque[: at + 1]).max()) == at
    assert forecast.first_within(0.05, np.abs(forecast.torque[:at]).max() - 1e-3) is None


@pytest.mark.long
@pytest.mark.parametrize("kind", ["mhe", "steering torque"])
def test_other_observers_are_forecast(acquiring: Ekf, kind: str) -> None:
    rig = replace(acquiring.rig, J_A=0.15, b_t=1.0)
    settings = {"model": acquiring.model, "values": acquiring.values, "rig": rig}
    observer = (
        Mhe(**settings, tuning=acquiring.tuning)
        if kind == "mhe"
        else Ekf(**settings, tuning=acquiring.tuning, measurement_model=SteeringTorque())
    )
    forecaster = Forecaster(observer)
    dt = 0.01 if kind == "mhe" else 0.002
    finer = fastest_path([0.0, 0.1, -0.1, 0.2, -0.2, 0.2], 0.3, 10.0, dt, 10.0)
    forecast = forecaster.forecast_whole(finer, forecaster.cases_at_rest([0.5], 0.0, LOAD, dt)[0], LOAD)

    assert forecast.first_within(0.13) is not None
    assert forecast.mu[-1] == pytest.approx(0.5, rel=0.03)


def test_what_no_steering_lowers(acquiring: Ekf) -> None:
    rig = Rig(a=0.045, e=0.0, dry_friction=0.135, tolerances=Tolerances(a=0.0045, e=0.0, load=0.03))
    causes = irreducible_mu_std(replace(acquiring, rig=rig), 0.5, LOAD)

    # Full slide measures mu times half-length and load; evenly spread, a tolerance counts by 1/sqrt(3).
    assert sorted(causes.values()) == pytest.approx(
        [0.0] * 2 + [0.03 / 3**0.5, 0.04, 0.1 / 3**0.5], abs=1e-4
    )
    directed = replace(acquiring, rig=rig, measurement_model=DirectionalFriction())
    # 0.03 of full slide at mu = 1, of 0.5.
    assert irreducible_mu_std(directed, 0.5, LOAD) == {**causes, "zero of the torque": 0.06}
    floor = replace(acquiring, rig=rig).effective_tuning.mu_floor
    assert hypot(floor, causes["dry friction"]) == pytest.approx(hypot(*causes.values()))


def directed(ratio: float) -> Ekf:
    """A filter of friction that differs by direction, whose compiled step serves any ratio."""
    found = found_model({"asymmetric_friction.ratio": ratio}, bristles=40)
    return Ekf(**found, rig=RIG, measurement_model=AligningTorque(stiffness=True))


@pytest.mark.parametrize("mu", [0.4, 0.8])
def test_friction_that_differs_by_direction_is_forecast_as_estimated_without_a_measured_rate(
    mu: float,
) -> None:
    """The observer's own rate lags behind a turn back, and so does the direction of the friction."""
    observer = directed(0.85)
    quick = fastest_path([0.0, 0.04, -0.09, 0.09, -0.09], 0.5, 2.5, 0.01, 4.0, rest=0.5)
    forecaster = Forecaster(observer)
    forecast = forecaster.forecast_whole(quick, forecaster.cases_at_rest([mu], 0.0, LOAD, 0.01)[0], LOAD)
    estimates = run(observer, quick.t, quick.psi, LOAD, forecast.torque)

    np.testing.assert_allclose(forecast.mu, estimates.mu, rtol=1e-3)
    assert (forecast.usable == estimates.usable).all()
    assert estimates.mu_eff[-1] == pytest.approx(mu, rel=0.05)


def test_mu_of_a_case_is_the_effective_one() -> None:
    forecaster = Forecaster(directed(0.8))
    turned = fastest_path([0.0, 0.6], 0.4, 10.0, 0.01, 3.0)
    ahead, back = (
        np.abs(
            forecaster.forecast_whole(
                one, forecaster.cases_at_rest([0.5], 0.0, LOAD, 0.01)[0], LOAD
            ).torque
        ).max()
        for one in (turned, replace(turned, psi=-turned.psi, psi_dot=-turned.psi_dot))
    )

    # Full slide of parabolic pressure about the kingpin, which is that of the mean of both ways.
    x = np.linspace(-1, 1, 20_001)
    slide = 0.5 * LOAD * np.mean(1.5 * (1 - x**2) * np.abs(RIG.a * x - RIG.e))
    assert min(ahead, back) / max(ahead, back) == pytest.approx(0.8, rel=0.03)
    assert (ahead + back) / 2 == pytest.approx(slide, rel=0.02)
