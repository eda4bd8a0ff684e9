"""A torque is learned where something is to be learned, and only there."""

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from identification import (
    Fit,
    Learned,
    Recording,
    Values,
    fit,
    initial_guess,
    model_text,
    read_model,
    signals_of,
)
from identification.learned.learning import learn
from identification.learned.network import NetworkFit, TrainingData
from symbolic import Model, effects_named, full_slide_torque, simulate
from symbolic.effects.learned import INPUTS, weights_needed
from tests.identification.factories import read_campaign, with_torque

Fits = tuple[Fit, Fit]


def fits(effects: Sequence[str], recordings: Sequence[Recording]) -> Fits:
    """A model fitted to the first two recordings, and on the others with its shared parameters."""
    model = Model(effects=effects_named(effects), corners=16)
    training, holdout = recordings[:2], recordings[2:]
    fitted = fit(model, training, initial_guess(model, training))
    start = Values(shared=fitted.values.shared, own=initial_guess(model, holdout).own)
    return fitted, fit(model, holdout, start, free_shared=False)


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """One network instead of the choice of several."""
    monkeypatch.setattr("identification.learned.learning.UNITS", (4,))
    monkeypatch.setattr("identification.learned.learning.DECAYS", (1e-2,))


def nrmse(learned: Learned) -> tuple[float, float]:
    """Held-out errors before and after."""
    key = "holdout_torque_nrmse"
    before, after = learned.before.summary()[key], learned.after.summary()[key]
    assert before is not None
    assert after is not None
    return before, after


def planted(share: float = 0.05) -> list[Recording]:
    """Recordings with a smooth torque, in shares of full slide, that nothing in the library makes."""
    recordings = read_campaign(None, 5, 4)[1]
    return [
        with_torque(r, r.M_z + share * full_slide_torque(r.F_N, r.rig.a) * np.cos(3 * r.psi))
        for r in recordings
    ]


@pytest.fixture(scope="module")
def recordings() -> list[Recording]:
    first, second, third, fourth = planted()
    # Those that turn furthest teach.
    return [third, fourth, first, second]


@pytest.fixture(scope="module")
def late(recordings: list[Recording]) -> Fits:
    return fits(["sensor_delay"], recordings)


@pytest.fixture(scope="module")
def learned(recordings: list[Recording], late: Fits) -> Learned:
    return learn(*late, recordings[:2], recordings[2:])


def test_a_planted_torque_is_learned(learned: Learned) -> None:
    before, after = nrmse(learned)

    print(f"held-out error {before:.2%} before, {after:.2%} after, of it 0.40 % are noise")
    assert before > 3 * after
    assert learned.kept
    assert learned.left_out[1] < 0.6 * learned.left_out[0]
    assert "learned, not physics" in learned.note
    assert learned.to_dict()["physics"] is False


def test_the_physics_is_left_alone(learned: Learned, late: Fits) -> None:
    assert learned.model.effects == (*late[0].model.effects, learned.effect)
    assert learned.model.parameters == late[0].model.parameters
    assert learned.model.corners == late[0].model.corners


def test_the_free_run_has_the_error_that_is_said(
    learned: Learned, late: Fits, recordings: list[Recording]
) -> None:
    # A late torque channel: what the network sees has to be late as well.
    for fitted, recording in zip(late, (recordings[0], recordings[2]), strict=True):
        theta = np.asarray(learned.model.theta(fitted.values.of(recording.name))).ravel()
        geometry = np.array([recording.rig.a, recording.rig.e])
        run = simulate(learned.model, signals_of(recording), theta, geometry)
        said = learned.residuals[recording.name] + recording.M_z
        np.testing.assert_allclose(run.M_z, said, rtol=0, atol=1e-9)
    rmse = np.sqrt(np.mean((run.M_z - recording.M_z) ** 2))
    assert rmse == pytest.approx(learned.after.rmse[recording.name])


def test_its_model_file_reads_back(learned: Learned, late: Fits, tmp_path: Path) -> None:
    values = Values(shared=late[0].values.shared, own=late[0].values.own)
    path = tmp_path / "model.json"
    diagnosis = SimpleNamespace(model=learned.model, values=values)
    path.write_text(model_text(diagnosis), encoding="utf-8")  # type: ignore[arg-type]
    found = read_model(path)

    assert found.model.effects == learned.model.effects
    assert (found.shared, found.own) == (values.shared, values.own)


@pytest.mark.usefixtures("quick")
def test_the_same_recordings_teach_the_same(recordings: list[Recording], late: Fits) -> None:
    twice = [learn(late[0], None, recordings[:2]) for _ in range(2)]

    assert twice[0].effect == twice[1].effect
    # Nothing held out: training recordings left out in turn are the judges.
    assert twice[0].kept
    assert twice[0].note.count("left-out error") == 1
    assert twice[0].after.summary()["holdout_torque_nrmse"] is None


@pytest.mark.usefixtures("quick")
def test_play_in_the_sensor_is_learned_too() -> None:
    recordings = read_campaign("backlash", 2, 4, duration=10.0)[1]
    fitted, held_out = fits([], recordings)
    learned = learn(fitted, held_out, recordings[:2], recordings[2:])

    before, after = nrmse(learned)
    assert learned.kept
    assert before > 2 * after


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("name", [None, "gust", "slide_oscillation"])
def test_what_does_not_repeat_is_not_kept(name: str | None) -> None:
    recordings = read_campaign(name, 2, 4, duration=10.0)[1]
    fitted, held_out = fits([], recordings)
    learned = learn(fitted, held_out, recordings[:2], recordings[2:])

    assert not learned.kept
    assert learned.model == fitted.model
    assert "not kept" in learned.note


@pytest.mark.usefixtures("quick")
def test_one_recording_alone_judges_nothing(recordings: list[Recording]) -> None:
    alone = recordings[:1]
    learned = learn(fit(Model(), alone, initial_guess(Model(), alone)), None, alone)

    assert not learned.kept
    assert "a single recording alone cannot judge it" in learned.note


@pytest.mark.usefixtures("quick")
def test_missing_torques_teach_nothing(recordings: list[Recording]) -> None:
    first = recordings[0]
    gone = np.arange(first.t.size) % 5 == 0
    holed = [with_torque(first, np.where(gone, np.nan, first.M_z))]
    learned = learn(fit(Model(), holed, initial_guess(Model(), holed)), None, holed)

    assert np.isfinite(learned.effect.weights).all()
    assert np.array_equal(np.isnan(learned.residuals[first.name]), gone)


def test_jacobian_is_the_slope() -> None:
    rng = np.random.default_rng(3)
    material = TrainingData(
        name="any",
        inputs=rng.standard_normal((INPUTS, 40)),
        slide=rng.uniform(5, 9, 40),
        target=rng.standard_normal(40),
        span=12.0,
    )
    lesson = NetworkFit([material], 3, 0.2)
    weights, h = rng.standard_normal(weights_needed(3)), 1e-6
    steps = h * np.eye(weights.size)
    slopes = [(lesson.residuals(weights + s) - lesson.residuals(weights - s)) / (2 * h) for s in steps]

    np.testing.assert_allclose(lesson.jacobian(weights), np.array(slopes).T, rtol=0, atol=1e-8)
    assert np.sum(lesson.residuals(np.zeros(weights.size)) ** 2) == pytest.approx(1)
