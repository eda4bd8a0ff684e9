"""Tunings by name, and from the error of the model that was found."""

import numpy as np
import pytest

from observers import PROFILES, Ekf, Status, Tuning, profile, run, tuning_for
from reference_rig import RigRecording, make_recording
from symbolic import FoundModel, InvalidInputError, Model, ModelError
from tests.observers.conftest import RIG, K, make
from tests.observers.factories import columns_of, found_model


def found(error: ModelError | None) -> FoundModel:
    return FoundModel(model=Model(), tyre={"k": 2.4e6}, own={}, error=error)


def test_profiles_by_name() -> None:
    assert profile("real_tyre") == Tuning()
    assert tuple(PROFILES) == ("real_tyre", "clean", "changing_ground")
    with pytest.raises(InvalidInputError, match="allowed: real_tyre, clean, changing_ground"):
        profile("wet")


def test_the_error_of_the_model_goes_before_the_tuning_and_after_what_is_set_by_hand() -> None:
    error = ModelError(spread=0.08, correlation_time=1.5)
    tuning = tuning_for(found(error), Tuning(mu=0.8))

    assert (tuning.mu, tuning.error) == (0.8, pytest.approx(np.hypot(0.08, 0.02)))
    assert tuning.error**2 * tuning.error_travel == pytest.approx(0.08**2 * 0.15 + 0.02**2 * 0.2)
    assert tuning_for(found(error)).error == tuning.error
    tuning = tuning_for(found(error), Tuning(mu=0.8), {"error": 0.05, "gate": 9.0})
    assert (tuning.mu, tuning.error, tuning.gate) == (0.8, 0.05, 9.0)
    assert tuning.noise == pytest.approx(0.008)


def test_an_error_as_short_as_a_sample_is_noise() -> None:
    tuning = tuning_for(found(ModelError(spread=0.011, correlation_time=0.01, relative=0.008)))

    assert tuning.noise == pytest.approx(0.011)
    # The 2 % that were not measured last as the usual error does.
    assert tuning.error**2 == pytest.approx(0.008**2 + 0.02**2)
    assert tuning.error**2 * tuning.error_travel == pytest.approx(0.008**2 * 0.001 + 0.02**2 * 0.2)


@pytest.mark.parametrize("share", [0.008, 0.021, 0.03])
@pytest.mark.parametrize(("seed", "mu"), [(3, 0.4), (4, 0.9), (5, 1.6)])
def test_tolerances_under_a_small_model_error_are_no_ground(seed: int, mu: float, share: float) -> None:
    """A diagnosis fits the lengths of every recording, an observer has those that are declared."""
    planted = {"rate_friction": {"c": 0.04}}
    made = make_recording(seed, planted, mu=mu, k=0.88 * K, a=0.044, bristles=500)
    error = ModelError(spread=1.4 * share, correlation_time=0.01, relative=share)
    observer = Ekf(**found_model({"rate_friction.c": 0.04}), rig=RIG, tuning=tuning_for(found(error)))
    estimates = run(observer, made.t, made.psi, made.F_N, made.M_z)

    assert not (estimates.status & Status.RESET).any()
    assert estimates.usable.any()
    off = np.abs(estimates.mu - mu)[estimates.usable]
    assert (off < 3 * estimates.mu_std[estimates.usable]).all()


@pytest.mark.parametrize(
    "model", [None, found(None), found(ModelError(spread=0.0, correlation_time=1.0))]
)
def test_without_a_known_error_the_tuning_stays(model: FoundModel | None) -> None:
    assert tuning_for(model) == Tuning()
    assert tuning_for(model, PROFILES["clean"]) == PROFILES["clean"]


def test_a_wheel_that_stands_gives_no_further_evidence(recording: RigRecording) -> None:
    columns = columns_of(recording)
    stop = int(np.argmax(np.abs(columns["psi"]) > 0.2))
    held = {name: np.append(c[:stop], np.full(500, c[stop - 1])) for name, c in columns.items()}
    held["t"] = np.arange(stop + 500) * 0.01
    by_turn, by_time = (
        run(make(Ekf, mu_walk=0.0, **tuning), **held).mu_std[[stop + 20, -1]]
        for tuning in ({}, {"noise": 0.5, "error_travel": 0.0})
    )

    assert by_turn[1] > 0.95 * by_turn[0]
    assert by_time[1] < 0.7 * by_time[0]


def test_no_measurement_lowers_the_floor(recording: RigRecording) -> None:
    columns = columns_of(recording)
    with_floor, without = (run(make(Ekf, mu_floor=f), **columns) for f in (0.1, 0.0))

    np.testing.assert_array_equal(with_floor.mu, without.mu)
    relative = [estimates.mu_std / estimates.mu for estimates in (with_floor, without)]
    np.testing.assert_allclose(relative[0][1:], np.hypot(relative[1][1:], 0.1), rtol=1e-9)
