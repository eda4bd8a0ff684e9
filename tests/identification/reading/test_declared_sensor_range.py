"""A torque sensor that ends does not pass for low friction where its range is declared."""

from dataclasses import replace

import numpy as np
import pytest

from identification import Recording, diagnose, fit
from identification.diagnosis.from_search import note_slide_beyond_sensor
from identification.fits.values_by_ground_and_recording import Values, complete_values
from identification.reading.declared_sensor_range import (
    drop_torques_beyond_range,
    torque_beyond_range_note,
)
from reference_rig import make_recording
from symbolic import Model, effects_named
from tests.identification.factories import as_read, recording, with_torque
from tests.refusal import refused

pytestmark = pytest.mark.usefixtures("interpreted")


def clipped(range_over_end: float | None, share: float = 0.6) -> list[Recording]:
    """Recordings of one sensor that ends at a share of the greatest torque, before its noise."""
    made = [
        make_recording(seed, mu=mu, duration=8.0, bristles=500, name=f"{seed}")
        for seed, mu in ((590_011, 0.7), (590_012, 0.8))
    ]
    end = share * max(float(np.abs(one.M_z_true).max()) for one in made)
    rng = np.random.default_rng(1)
    read = []
    for one in made:
        plain = as_read(one, one.tyre)
        M_z = np.clip(one.M_z_true, -end, end) + 0.01 * end * rng.standard_normal(one.t.size)
        reach = None if range_over_end is None else range_over_end * end
        read.append(ranged(with_torque(plain, M_z), reach))
    return read


def ranged(plain: Recording, reach: float | None) -> Recording:
    return replace(plain, rig=replace(plain.rig, range=reach))


def touching_range(ample: Recording) -> Recording:
    """One sample at the range of the sensor."""
    return with_torque(ample, np.where(np.arange(ample.t.size) == 30, ample.rig.range, ample.M_z))


def test_torques_beyond_the_range_are_left_out_and_the_angle_stays() -> None:
    plain = with_torque(recording(), [9.4, 9.6, -9.4, -9.6, np.nan] * 10)
    ended = ranged(replace(plain, M=plain.M_z), 10.0)
    used = drop_torques_beyond_range(ended)

    assert drop_torques_beyond_range(plain) is plain
    for torque in (used.M_z, used.M):
        assert np.isfinite(torque).tolist() == [True, False, True, False, False] * 10
    assert np.array_equal(used.psi, plain.psi)


def test_a_fit_leaves_them_out() -> None:
    silent, declared = (fit(Model(), clipped(reach)).values for reach in (None, 1.0))

    for name, mu in (("590011", 0.7), ("590012", 0.8)):
        assert declared.own[name]["mu"] == pytest.approx(mu, rel=0.04)
        assert silent.own[name]["mu"] < 0.85 * mu
    assert declared.tyre["k"] == pytest.approx(2.4e6, rel=0.05)


def test_a_fit_does_not_settle_at_next_to_no_friction_below_a_low_range() -> None:
    one, _ = clipped(1.0, share=0.15)
    values = fit(Model(), [replace(one, tyre=replace(one.tyre, k=1e7))]).values

    assert values.own[one.name]["mu"] == pytest.approx(0.7, rel=0.02)


@pytest.mark.long
def test_a_diagnosis_leaves_them_out_and_says_what_is_not_known_then() -> None:
    candidates = ("frictional_creep", "carcass_torsion", "asymmetric_friction")
    silent, declared = (diagnose(clipped(reach), candidates=candidates, jobs=1) for reach in (None, 1.0))
    ample = diagnose(clipped(2.0), candidates=candidates, jobs=1)
    count = int(np.isnan(declared.series[0].measured).sum())
    load = float(np.median(declared.series[0].F_N))
    least = 0.95 * (clipped(1.0)[0].rig.range or 0) / (load * 0.375 * 0.045)

    assert silent.effects or silent.unexplained.present
    assert not declared.effects
    assert not declared.unexplained.present
    assert f"left out: 590011 {count} of 801 samples, 590012 " in " ".join(declared.notes)
    (sure,) = (note for note in declared.notes if "full slide is beyond the range" in note)
    told = float(sure.partition("only 590011 ")[2].partition(" or more")[0])
    assert 0.9 * least < told <= least
    assert not any("range" in note for note in ample.notes)


def test_no_lower_bound_is_told_of_a_torque_that_never_came_near_the_range() -> None:
    ample, model = ranged(recording(), 10.0), Model()
    values = complete_values(model, Values(tyre={"k": 2e6}, own={"one": {"mu": 3.0}}), [ample])

    assert note_slide_beyond_sensor(model, values, [ample]) == ()
    (note,) = note_slide_beyond_sensor(model, values, [touching_range(ample)])
    assert "measured is only one 1." in note


@pytest.mark.parametrize(("gain", "beyond"), [(0.0, False), (1.0, True)])
def test_friction_that_grows_reaches_beyond_the_range_at_the_end(gain: float, beyond: bool) -> None:
    ample = ranged(recording(), 10.0)
    slide = 10.0 / (0.375 * float(np.median(ample.F_N)) * ample.rig.a)
    model = Model(effects=effects_named(["friction_drift"]))
    drift = {"friction_drift.gain": gain, "friction_drift.scale": 0.05}
    own = {"one": {"mu": 0.75 * slide}}
    values = complete_values(model, Values(tyre={"k": 2e6, **drift}, own=own), [ample])

    assert bool(note_slide_beyond_sensor(model, values, [touching_range(ample)])) == beyond


def test_torques_left_out_are_counted_among_those_there_are() -> None:
    torque = np.where(np.arange(50) % 10 == 0, 1.0, np.nan)
    torque[:20:10] = 10.0
    ended = with_torque(ranged(recording(), 10.0), torque)

    assert torque_beyond_range_note([ended]).endswith("one 2 of 5 samples")


def test_a_torque_that_is_nowhere_within_the_range_is_refused() -> None:
    low = ranged(recording(), 1e-9)

    assert "constant within the range of its sensor" in refused(diagnose, [low], jobs=1)
