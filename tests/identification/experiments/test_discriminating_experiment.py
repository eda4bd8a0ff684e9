"""Proposals, and whether the independent rig bears them out."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from identification import Fit, Recording, Values, fit, smoothed_rate
from identification.experiments.discriminating_experiment import propose
from identification.experiments.manoeuvre_in_recorded_range import SAMPLE_PERIOD, SampledManoeuvre
from identification.experiments.model_separation import (
    Proposal,
    _difference_in_standard_errors,
    _RecordedModelDifference,
    fitted_sample_period,
)
from identification.fits.autocorrelation import autocorrelation_time
from identification.fits.least_squares_problem import torque_range
from identification.fits.options import COARSE_FIT
from identification.selection.criteria import DEFAULT_CRITERIA, error_reduction
from identification.selection.trial import Judgement, judge, leave_one_out, thin_for_ranking
from reference_rig import SUBSTEPS, Campaign, RigDrive, build_effects, simulate_bristles
from symbolic import Model, effects_named
from tests.identification.factories import read_campaign

NOISE = 0.004
CLEAR, BLOCK = DEFAULT_CRITERIA.clear, DEFAULT_CRITERIA.block


def fitted(effect: str, recordings: list[Recording], start: Values | None = None) -> Fit:
    model = Model(effects=effects_named([effect]), corners=16, discretised=True)
    return fit(model, recordings, start, COARSE_FIT)


def steered(manoeuvre: SampledManoeuvre, made: Campaign, like: Recording) -> Recording:
    """The manoeuvre on the rig, with the tyre, the effect and the noise of the campaign."""
    truth = made.recordings[0]
    t = np.arange(round(manoeuvre.seconds * 100 * SUBSTEPS) + 1) / (100 * SUBSTEPS)
    # Between the manoeuvre's points the wheel turns smoothly.
    psi = np.pad(np.interp(t, manoeuvre.t, manoeuvre.psi), 10, mode="edge")
    psi, F_N = np.convolve(psi, np.full(21, 1 / 21), "valid"), np.interp(t, manoeuvre.t, manoeuvre.F_N)
    drive = RigDrive(t=t, psi=psi, psi_dot=np.gradient(psi, t), F_N=F_N, psi_virgin=float(psi[0]))
    made = simulate_bristles(drive, truth.tyre, build_effects(truth.effects), bristles=400)
    t, psi, F_N, torque = (values[::SUBSTEPS] for values in (t, psi, F_N, made.M_z))
    noise = np.random.default_rng(7).standard_normal(torque.size) * NOISE * torque_range(like)
    seen = {"t": t, "psi": psi, "psi_dot": smoothed_rate(t, psi), "M_z": torque + noise, "F_N": F_N}
    return replace(like, name="experiment", psi_recorded=None, **seen)


def judgement(found: Fit, recordings: list[Recording]) -> Judgement:
    return judge(leave_one_out(found, recordings), recordings)


def standard_errors(better: Fit, worse: Fit, recordings: list[Recording]) -> float:
    mean, error = error_reduction(judgement(better, recordings), judgement(worse, recordings), BLOCK)
    return mean / error


@dataclass(frozen=True)
class Ambiguous:
    made: Campaign
    recordings: list[Recording]
    true: Fit
    rival: Fit


@pytest.fixture(scope="module")
def ambiguous() -> Ambiguous:
    made, whole = read_campaign("stribeck", 2, duration=6.0)
    recordings = [thin_for_ranking(recording) for recording in whole]
    true, rival = (fitted(name, recordings) for name in ("stribeck", "rate_friction"))
    return Ambiguous(made=made, recordings=recordings, true=true, rival=rival)


@pytest.fixture(scope="module")
def proposed(ambiguous: Ambiguous) -> Proposal:
    return propose(ambiguous.true, ambiguous.rival, ambiguous.recordings)


def with_experiment(pair: Ambiguous, proposal: Proposal) -> tuple[list[Recording], Fit, Fit]:
    new = thin_for_ranking(steered(proposal.manoeuvre, pair.made, pair.recordings[0]))
    recordings = [*pair.recordings, new]
    again = []
    for before in (pair.true, pair.rival):
        own = before.values.own[pair.recordings[0].name]
        start = Values(tyre=before.values.tyre, own={**before.values.own, new.name: own})
        again.append(fitted(before.model.effects[0].name, recordings, start))
    return recordings, again[0], again[1]


def test_the_experiment_tells_apart_what_the_recordings_cannot(
    ambiguous: Ambiguous, proposed: Proposal
) -> None:
    before = standard_errors(ambiguous.true, ambiguous.rival, ambiguous.recordings)
    recordings, true, rival = with_experiment(ambiguous, proposed)
    after = standard_errors(true, rival, recordings)

    assert before < CLEAR < after
    assert after == pytest.approx(proposed.standard_errors, rel=0.3)
    gain = judgement(rival, recordings).nrmse / judgement(true, recordings).nrmse - 1
    assert gain > 0.05


def test_says_what_to_do(proposed: Proposal) -> None:
    assert (proposed.found, proposed.rival, proposed.times) == ("stribeck", "rate_friction", 1)
    assert proposed.now < proposed.separation
    assert proposed.sentence.startswith(proposed.manoeuvre.instruction)
    assert "stribeck and rate friction then differ by" in proposed.sentence
    assert f"{proposed.separation:.2%} of range, with all recordings" in proposed.sentence


def test_the_rival_is_refitted_to_everything(ambiguous: Ambiguous, proposed: Proposal) -> None:
    # The recordings as the rival has them, so that what it gives up counts from there, and the
    # experiment as the true model has it: the proposal refits to that, to first order in the recordings.
    seen = [replace(r, M_z=r.M_z + ambiguous.rival.residuals[r.name]) for r in ambiguous.recordings]
    m = proposed.manoeuvre
    new = replace(
        seen[0], name="new", t=m.t, psi=m.psi, psi_dot=m.psi_dot, psi_recorded=None, F_N=m.F_N,
        M_z=proposed.torque,
    )  # fmt: skip
    values = ambiguous.rival.values
    start = Values(tyre=values.tyre, own={**values.own, "new": values.own[seen[0].name]})
    refitted = fit(ambiguous.rival.model, [*seen, new], start)
    difference = refitted.residuals["new"]

    told, size = proposed.rival_torque - proposed.torque, np.abs(difference).max()
    np.testing.assert_allclose(difference, told, atol=0.15 * size)


def test_seconds_that_a_residual_remembers_are_the_same_where_torques_are_missing(
    ambiguous: Ambiguous,
) -> None:
    recording = ambiguous.recordings[0]
    noise = np.random.default_rng(1).standard_normal(recording.t.size)
    residual = np.convolve(noise, np.ones(20), "same")
    full = replace(ambiguous.true, residuals={recording.name: residual})
    gaps = np.where(np.arange(residual.size) % 2, np.nan, residual)
    half = replace(full, residuals={recording.name: gaps})

    seconds, with_gaps = (
        autocorrelation_time(found.residuals[recording.name]) * fitted_sample_period(found, recording)
        for found in (full, half)
    )
    assert with_gaps == pytest.approx(seconds, rel=0.15)


def test_a_model_cannot_be_told_from_itself(ambiguous: Ambiguous) -> None:
    proposal = propose(ambiguous.true, ambiguous.true, ambiguous.recordings)

    assert proposal.times is None
    assert proposal.separation < 1e-6
    assert "cannot be distinguished by standard steering on this rig" in proposal.sentence


@pytest.mark.parametrize("times", [1, 3])
@pytest.mark.parametrize("size", [0.001, 0.01])
def test_foretells_the_paired_test(size: float, times: int) -> None:
    rng = np.random.default_rng(5)
    t = np.arange(2000) * SAMPLE_PERIOD
    difference = size * (1 + np.sin(0.7 * t)) * np.sin(9 * t)
    old, now, memory = 1000, 0.5 * size, 5
    lasts = {"seconds": old * SAMPLE_PERIOD, "memory": memory * SAMPLE_PERIOD}
    present = _RecordedModelDifference(count=2, now=now, noise=NOISE, **lasts)
    whole = np.concatenate([np.full(old, now), *times * [difference]])
    clock = np.arange(whole.size) * SAMPLE_PERIOD
    found = []
    for _ in range(200):
        noise = NOISE * np.repeat(rng.standard_normal(whole.size // memory), memory)
        pair = [
            Judgement(residuals={"r": left}, ranges={"r": 1.0}, times={"r": clock})
            for left in (noise, noise + whole)
        ]
        found.append(np.divide(*error_reduction(*pair, BLOCK)))

    expected = pytest.approx(np.median(found), rel=0.15)
    assert _difference_in_standard_errors(difference, present, times, BLOCK) == expected
