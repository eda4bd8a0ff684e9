from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from identification import Fit, Huber, Recording, fit
from identification.diagnosis.unrefitted_prediction import simulated_minus_measured
from identification.fits.autocorrelation import effective_samples
from identification.fits.least_squares_problem import torque_range
from identification.fits.loss import LEAST_SQUARES, rmse_of
from identification.fits.values_by_ground_and_recording import Values, initial_guess
from identification.selection.criteria import (
    DEFAULT_CRITERIA,
    cross_term_standard_error,
    delta_bic,
    error_reduction,
)
from identification.selection.leave_one_out_linearised import leave_one_out
from identification.selection.trial import (
    RANKING,
    RANKING_STEP,
    ROUGH,
    ROUGH_STEP,
    Judgement,
    Precision,
    Trial,
    TrialTask,
    fit_recording_parameters,
    judge,
    model_of,
    run_trial,
    thin_for_ranking,
    with_prior_weights,
)
from identification.selection.trial_runner import TrialRunner, run_in_this_process, start_values
from symbolic import Model, Tolerances, effects_named
from tests.identification.factories import left_out_exactly, read_campaign, with_torque

BLOCK = DEFAULT_CRITERIA.block


def test_missing_samples_do_not_count() -> None:
    noise, other = (np.random.default_rng(1).standard_normal(n) for n in (4000, 500))
    noise[::4] = np.nan

    assert effective_samples({"a": noise, "b": other}) == pytest.approx(3500, rel=0.1)
    assert rmse_of(np.array([3.0, np.nan, -3.0])) == 3


@pytest.fixture(scope="module")
def three() -> list[Recording]:
    # The declared model has no damping: its residuals are structured.
    return read_campaign("contact_damping", 5, recordings=3)[1]


def first_order_error(fitted: Fit, recordings: list[Recording]) -> dict[str, float]:
    """Error of leaving each out to first order, over what an exact refit of the others changes."""
    predicted, exact = leave_one_out(fitted, recordings), left_out_exactly(fitted, recordings)
    return {
        r.name: rmse_of(predicted[r.name] - exact[r.name])
        / rmse_of(exact[r.name] - fitted.residuals[r.name])
        for r in recordings
    }


def test_leaving_out_to_first_order_is_like_refitting(three: list[Recording]) -> None:
    assert max(first_order_error(fit(Model(corners=16), three), three).values()) < 0.15


def test_the_ground_of_a_recording_left_out_takes_the_mean_of_the_others(three: list[Recording]) -> None:
    """As exact refits have it: the other grounds' mean where nobody else stands on its ground."""
    grounds = ("steel", "steel", "emery")
    stood = [replace(r, ground=ground) for r, ground in zip(three, grounds, strict=True)]
    fitted = fit(model_of(effects_named(["contact_damping", "stiffness_by_ground"])), stood)

    assert fitted.values.grounds.keys() == {"steel", "emery"}
    assert max(first_order_error(fitted, stood).values()) < 0.2


@pytest.mark.long
def test_leaving_out_counts_what_was_declared_with_a_tolerance(three: list[Recording]) -> None:
    within = Tolerances(a=0.002)
    tolerated = [replace(r, rig=replace(r.rig, tolerances=within)) for r in three]
    fitted = fit(Model(corners=16), tolerated)
    predicted, exact = leave_one_out(fitted, tolerated), left_out_exactly(fitted, tolerated)

    for name, residual in exact.items():
        assert rmse_of(predicted[name]) == pytest.approx(rmse_of(residual), rel=0.01)


def test_leaving_out_keeps_to_the_ranges_of_the_parameters() -> None:
    """Contact damping cannot be negative, however much the torque asks for it."""
    undamped = read_campaign(None, 2, recordings=3)[1]
    inwards = [
        with_torque(r, r.M_z + gain * r.psi_dot)
        for r, gain in zip(undamped, (0.2, 0.5, 1.0), strict=True)
    ]
    fitted = fit(model_of(effects_named(["contact_damping"]), RANKING), inwards)
    column = fitted.labels.index((None, "contact_damping.c"))
    assert fitted.bound_distances[0, column] == pytest.approx(0, abs=1e-2)

    unbounded = replace(fitted, bound_distances=np.sign(fitted.bound_distances) * np.inf)
    near, far = leave_one_out(fitted, inwards), leave_one_out(unbounded, inwards)
    for name, exact in left_out_exactly(fitted, inwards).items():
        assert rmse_of(near[name] - exact) < 0.3 * rmse_of(far[name] - exact)


def test_leaving_out_with_missing_samples(three: list[Recording]) -> None:
    gone = np.arange(three[0].t.size) % 3 == 0
    holed = [with_torque(three[0], np.where(gone, np.nan, three[0].M_z)), *three[1:]]
    left, whole = (leave_one_out(fit(model_of(()), r), r)[three[0].name] for r in (holed, three))

    np.testing.assert_array_equal(np.isnan(left), gone)
    assert rmse_of(left) == pytest.approx(rmse_of(whole), rel=0.05)


def test_leaving_out_with_outliers(three: list[Recording]) -> None:
    """An outlier pulls on the shared parameters as little as it does in a fit."""
    spiked = three[0].M_z.copy()
    spiked[100:140] += np.ptp(spiked)
    wrong = [with_torque(three[0], spiked), *three[1:]]
    task = TrialTask((), wrong, loss=Huber(threshold=0.03))
    fitted = run_trial(task).fitted
    predicted = leave_one_out(fitted, wrong)
    for left_out in three[1:]:
        others = [recording for recording in wrong if recording is not left_out]
        refitted = run_trial(replace(task, training=others, start=fitted.values)).fitted
        exact = fit_recording_parameters(refitted, [left_out]).residuals[left_out.name]
        change = rmse_of(exact - fitted.residuals[left_out.name])
        assert rmse_of(predicted[left_out.name] - exact) < 0.5 * change


def test_a_single_recording_keeps_its_residuals(three: list[Recording]) -> None:
    fitted = run_trial(TrialTask((), three[:1], ())).fitted

    assert leave_one_out(fitted, three[:1]) == dict(fitted.residuals)


def test_information_criterion_of_white_residuals(three: list[Recording]) -> None:
    fitted = run_trial(TrialTask((), three, ())).fitted
    rng = np.random.default_rng(2)
    white = {r.name: rng.standard_normal(r.t.size) for r in three}
    poorer = replace(fitted, residuals={name: 2 * residual for name, residual in white.items()})
    richer = replace(fitted, residuals=white, labels=(*fitted.labels, (None, "more")))
    n = effective_samples(white)

    assert delta_bic(richer, poorer, three) == pytest.approx(-2 * n * np.log(2) + np.log(n))
    assert n == pytest.approx(sum(r.t.size for r in three), rel=0.1)


def judged(residual: np.ndarray, span: float = 1.0) -> Judgement:
    """One recording at 100 Hz with this residual."""
    t = np.arange(residual.size) / 100
    return Judgement(residuals={"a": residual}, ranges={"a": span}, times={"a": t})


def test_advantage_is_paired_over_seconds() -> None:
    better, worse = judged(np.ones(400), 2.0), judged(np.repeat([1.0, 2.0, 3.0, 4.0], 100), 2.0)
    squares = (np.array([1.0, 4.0, 9.0, 16.0]) - 1) / 4

    np.testing.assert_allclose(worse.block_errors(BLOCK), (squares * 4 + 1) / 4)
    mean, error = error_reduction(better, worse, BLOCK)
    assert mean == pytest.approx(squares.mean())
    assert error == pytest.approx(squares.std(ddof=1) / 2)
    assert error_reduction(worse, better, BLOCK) == (pytest.approx(-mean), pytest.approx(error))
    assert error_reduction(better, better, BLOCK) == (0, 0)
    # A single block tells nothing.
    assert error_reduction(judged(np.ones(140)), judged(np.full(140, 2.0)), BLOCK) == (3, np.inf)


def test_blocks_of_a_second() -> None:
    # 14.01 s are fourteen seconds, however large the error at the very end.
    residual = np.ones(1402)
    residual[-1] = 10.0
    squares = judged(residual).block_errors(BLOCK)
    assert squares.size == 14
    np.testing.assert_allclose(squares[:-1], 1)
    assert squares[-1] == pytest.approx(1 + 99 / 101, rel=0.01)
    # A second without a torque is left out, and one of which little is there.
    t = np.arange(401) / 100
    holed = judged(np.where((t >= 1) & (t < 2), np.nan, 2.0))
    np.testing.assert_array_equal(holed.block_errors(BLOCK), [4, 4, 4])
    np.testing.assert_array_equal(holed.block_errors(60.0), [4])
    residual = np.where(np.arange(1401) / 100 > 13.02, np.nan, 1.0)
    residual[-1] = 10.0
    np.testing.assert_array_equal(judged(residual).block_errors(BLOCK), np.ones(13))


def test_judged_error_is_averaged_over_recordings(three: list[Recording]) -> None:
    residuals = {r.name: np.full(r.t.size, size) for r, size in zip(three, (0.1, 0.2, 0.3), strict=True)}
    spans = [np.ptp(r.M_z) for r in three]

    expected = np.mean(np.array([0.1, 0.2, 0.3]) / np.array(spans))
    assert judge(residuals, three).nrmse == pytest.approx(expected)


def test_threads_change_no_digit(three: list[Recording]) -> None:
    alone, together = (run_trial(TrialTask((), three[:2], three[2:]), threads=n) for n in (1, 2))

    assert alone.held_out
    assert together.held_out
    assert alone.held_out.values == together.held_out.values
    np.testing.assert_array_equal(alone.fitted.jacobian, together.fitted.jacobian)


@pytest.mark.parametrize(("precision", "step"), [(RANKING, RANKING_STEP), (ROUGH, ROUGH_STEP)])
def test_large_errors_are_ranked_on_fewer_samples(
    three: list[Recording], precision: Precision, step: float
) -> None:
    runner = TrialRunner(training=three, holdout=(), loss=LEAST_SQUARES, submit=run_in_this_process)
    coarse = runner.run_on_thinned_recordings((), None, precision)

    for times in coarse.judgement.times.values():
        assert np.diff(times).max() == pytest.approx(step)


def test_declared_values_of_rivals_weigh_as_in_the_present_model(three: list[Recording]) -> None:
    """Each recording's by its own residual."""
    read = [replace(r, rig=replace(r.rig, tolerances=Tolerances(a=0.002))) for r in three]
    present = run_trial(TrialTask((), read[:2], read[2:], precision=RANKING))
    given = with_prior_weights(RANKING, present).options.prior_weights

    assert given is not None
    assert set(given) == {r.name for r in read}
    assert len(set(given.values())) == len(read)
    again = run_trial(
        TrialTask((), read[:2], read[2:], present.values, with_prior_weights(RANKING, present))
    )
    for fitted in again.fits:
        assert all(given[name] == w for name, w in fitted.prior_weights_of_recordings.items())


@pytest.mark.parametrize("name", ["carcass_torsion", "backlash"])
def test_two_steps_balance_what_is_in_series(three: list[Recording], name: str) -> None:
    effects, thinned = effects_named([name]), thin_for_ranking(three[0])
    values = initial_guess(model_of(effects), [thinned]).of(thinned)

    two, many = (
        simulated_minus_measured(model_of(effects, precision), thinned, values)
        for precision in (RANKING, replace(RANKING, newton_steps=8))
    )

    assert rmse_of(two - many) < 1e-9 * torque_range(thinned)


@pytest.mark.parametrize(
    ("present", "wanted", "kept"),
    [((), ("contact_length",), False), (("contact_length",), (), False), ((), ("patch_width",), True),
     (("contact_length",), ("contact_length", "patch_width"), True)],
)  # fmt: skip
def test_lengths_begin_anew_where_they_get_another_meaning(
    present: tuple[str, ...], wanted: tuple[str, ...], kept: bool
) -> None:
    values = Values(tyre={"k": 2e6}, own={"one": {"mu": 1.0}}, rig={"one": {"a": 0.044}})
    model = Model(effects=effects_named(present))
    trial = cast(Trial, SimpleNamespace(values=values, fitted=SimpleNamespace(model=model)))

    assert start_values(trial, effects_named(wanted)).rig == (values.rig if kept else {})


def test_an_effect_of_one_block_falls_by_more_than_chance() -> None:
    """A pretwist is gone after the first slide; blocks of which most show nothing are no doubt of it."""
    noise = np.random.default_rng(0).normal(0.0, 0.1, (12, 100))
    taken = np.zeros((12, 100))
    taken[0] = 1.0
    better, worse = judged(noise.ravel(), 2.0), judged((noise + taken).ravel(), 2.0)
    by_hand = 2 * noise[0].mean() / 4 / 12

    mean, error = error_reduction(better, worse, BLOCK)
    assert mean == pytest.approx(1 / 48 + by_hand)
    assert mean < 1.2 * error
    assert cross_term_standard_error(better, worse, BLOCK) == pytest.approx(abs(by_hand))
    # Of an effect that only follows the noise half the fall is chance, and a single block tells nothing.
    luck = judged(2 * noise.ravel(), 2.0)
    half = pytest.approx(np.linalg.norm(2 * (noise**2).mean(axis=1)) / 4 / 12)
    assert cross_term_standard_error(better, luck, BLOCK) == half
    assert cross_term_standard_error(judged(np.ones(140)), judged(np.full(140, 2.0)), BLOCK) == np.inf
