"""Observers on recordings: which signals they are given, on which model, and the track of friction."""

from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from brushgrip.estimation.observe_recording import (
    Aligning,
    aligning_torque_is_measured,
    angle_nan_where_imputed,
    friction_track,
    model_observer,
    observe,
    run_arguments,
)
from brushgrip.estimation.recording_warnings import (
    differing_sample_rates_note,
    direction_deficit_and_note,
    inconsistency_remedy,
)
from brushgrip.inputs.option_choices import ObserverName
from identification import FoundModel, Recording, read_recording
from observers import DirectionalFriction, Ekf, Estimates, Sample, Status, run
from symbolic import InvalidInputError, Model, Rig, Tyre
from symbolic.float_array_type import Array
from tests.brushgrip.factories import make_estimates
from tests.brushgrip.helpers import Write
from tests.observers.factories import SampleRecorder

NOMINAL = Rig(a=0.045, e=0.009), Tyre(k=2.4e6, mu=1.2)


@pytest.fixture
def recording(write_csv: Write) -> Recording:
    return read_recording(write_csv(), NOMINAL)


def samples_of(recording: Recording) -> list[Sample]:
    recorder = SampleRecorder()
    run(recorder, **run_arguments(recording))
    return recorder.samples


def test_noise_and_rate_of_the_torque_channel(recording: Recording) -> None:
    t = np.arange(0.0, 8.0, 1e-3)
    psi = 0.3 * np.sin(1.2 * t)
    drawn = np.random.default_rng(3).standard_normal(t.size)
    noisy = replace(
        recording, t=t, psi=psi, psi_dot=np.gradient(psi, t), F_N=np.full(t.size, 400.0),
        M_z=-6 * np.tanh(psi / 0.05) + 0.9 * drawn, psi_recorded=None, M=None,
    )  # fmt: skip
    slower = replace(noisy, M_z=np.where(np.arange(t.size) % 2, np.nan, noisy.M_z))
    declared = replace(noisy, rig=replace(noisy.rig, noise=0.3))

    def remedy(
        one: Recording, residual: Array, *, of_found: bool = False, aligning: Aligning | None = None
    ) -> str:
        status = np.full(t.size, int(Status.INCONSISTENT))
        seen = SimpleNamespace(status=status, M_z_predicted=one.M_z - residual)
        observer, estimates = model_observer(Ekf, one, aligning=aligning), cast(Estimates, seen)
        return inconsistency_remedy(observer, one, estimates, of_found=of_found)

    # Of 10 ms: ten samples of 0.9 N m, or five.
    for one, std in ((noisy, 0.28), (slower, 0.4)):
        told = remedy(one, 0.9 * drawn)
        seen = f"torque noise seen {std:g} N m, none declared: declare [sensor] noise = {std:g} "
        assert told.startswith(seen)
    assert remedy(declared, 0.9 * drawn) == ""
    # What lasts is no noise, whatever noise is beside it or declared.
    for one in (noisy, declared):
        lasting = 0.9 * drawn + 3 * np.sin(t)
        assert remedy(one, lasting).startswith("find what the model lacks")
        # With a model that was found it is no use to ask for one.
        assert remedy(one, lasting, of_found=True).startswith("find what --model lacks")
        told = remedy(one, lasting, of_found=True, aligning=DirectionalFriction())
        assert told.startswith("leave --by-direction out, or find what --model lacks")
    assert differing_sample_rates_note(slower) == "torque at 500 Hz, angle at 1000 Hz: normal"
    assert differing_sample_rates_note(noisy) == ""


def test_the_weaker_direction_of_a_found_model_is_told() -> None:
    ratio = "asymmetric_friction.ratio"
    told = {r: direction_deficit_and_note({"k": 2e6, ratio: r}) for r in (0.85, 1.2, 1.01)}

    assert told[0.85] == (pytest.approx(0.15 / 1.85), told[0.85][1])
    assert told[0.85][1].startswith("8 % less than mu_eff turning to positive psi: ")
    assert told[1.2][1].startswith("9 % less than mu_eff turning to negative psi: ")
    assert told[1.01][1] == ""
    assert direction_deficit_and_note({"k": 2e6}) == (0.0, "")
    # 0.76 (1 - 0.0811) - 0.08 with the digits of the band; no friction is below nothing.
    for mu_eff, low in ((0.76, "0.62"), (0.05, "0.00")):
        line = direction_deficit_and_note({"asymmetric_friction.ratio": 0.85}, mu_eff, 0.04)[1]
        assert line.startswith(f"8 % less than mu_eff turning to positive psi, down to {low}: ")


def test_an_observer_of_the_users_own_estimates(recording: Recording) -> None:
    estimates = observe(lambda *_: SampleRecorder(), recording)

    np.testing.assert_array_equal(estimates.mu, np.arange(1, recording.t.size + 1))


def test_errors_of_an_observer_name_the_recording(recording: Recording) -> None:
    def refuse(*_: object) -> SampleRecorder:
        raise InvalidInputError("no such wheel")

    with pytest.raises(InvalidInputError, match=r"^run: no such wheel$"):
        observe(refuse, recording)


def test_a_recorded_rate_is_used_and_a_derived_one_is_not(write_csv: Write) -> None:
    # A derived rate is smoothed over later samples; a causal observer takes its own from the past.
    rate = np.linspace(-3.0, 3.0, 60)
    recorded = read_recording(write_csv(columns={"psi_dot": rate}), NOMINAL)
    derived = read_recording(write_csv("derived.csv"), NOMINAL)

    assert [sample.psi_dot for sample in samples_of(recorded)] == pytest.approx(rate)
    rates = [sample.psi_dot for sample in samples_of(derived)]
    assert rates[10:] != pytest.approx(derived.psi_dot[10:], rel=1e-3)


def test_an_imputed_angle_reaches_the_observer_as_missing(recording: Recording) -> None:
    measured = np.ones(recording.t.size, dtype=bool)
    measured[20:23] = False
    gaps = replace(recording, psi_recorded=measured)

    np.testing.assert_array_equal(np.isnan(angle_nan_where_imputed(gaps)), ~measured)
    np.testing.assert_array_equal([np.isnan(s.psi) for s in samples_of(gaps)], ~measured)
    np.testing.assert_array_equal(angle_nan_where_imputed(recording), recording.psi)


def test_an_aligning_torque_with_gaps_is_still_preferred(recording: Recording) -> None:
    M_z = recording.M_z.copy()
    M_z[5] = np.nan
    gaps = replace(recording, M_z=M_z, M=np.full(M_z.size, 5.0))
    missing = replace(gaps, M_z=np.full(M_z.size, np.nan))

    assert aligning_torque_is_measured(gaps)
    assert not aligning_torque_is_measured(missing)
    assert all(np.isnan(sample.M) for sample in samples_of(gaps))
    np.testing.assert_array_equal([sample.M_z for sample in samples_of(gaps)], M_z)


def test_stiffness_comes_from_the_found_model_or_else_from_the_recording(recording: Recording) -> None:
    found = FoundModel(model=Model(), tyre={"k": 2.0e6}, own={})

    assert model_observer(Ekf, recording).values["k"] == 2.4e6
    assert model_observer(Ekf, recording, found).values["k"] == 2.0e6
    with pytest.raises(InvalidInputError, match="k"):
        model_observer(Ekf, recording, replace(found, tyre={}))
    with pytest.raises(InvalidInputError, match=r"13 times the declared one"):
        model_observer(Ekf, recording, replace(found, tyre={"k": 13 * 2.4e6}))


def test_a_track_has_the_declared_friction_and_the_changes_of_the_ground(recording: Recording) -> None:
    n = recording.t.size
    status = np.zeros(n, dtype=np.int64)
    status[[12, 40]] = Status.RESET | Status.REJECTED
    status[13] = Status.REJECTED
    mu_eff = np.where(np.arange(n) > 0, 0.9, np.nan)
    seen = {"usable": status == 0, "mu_eff": mu_eff, "mu_eff_std": np.full(n, 0.3)}
    estimates = make_estimates(status, t=recording.t, **seen)
    track = friction_track(ObserverName.EKF, recording, estimates, "assumed model")

    np.testing.assert_array_equal(track.changes, recording.t[[12, 40]])
    assert (track.name, track.label, track.reference) == ("run", "EKF, assumed model", 1.2)
    assert track.reference_label == "declared μ"
    # Between torques that come more slowly than angles a usable value is kept for half a second.
    rare = np.full(n, int(Status.MISSING))
    rare[::50] = 0
    kept = make_estimates(rare, t=0.02 * np.arange(n), usable=rare == 0)
    usable = friction_track(ObserverName.EKF, recording, kept, "assumed model").usable
    np.testing.assert_array_equal(usable, np.arange(n) % 50 <= 25)
    # What an observer does not state is its mu.
    assert (track.mu[0], track.mu[1], track.mu_std[1]) == (1.0, 0.9, 0.3)
