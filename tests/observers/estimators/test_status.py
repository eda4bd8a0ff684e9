"""What an observer says of a sample, and what comes of samples that lack something."""

from dataclasses import replace
from itertools import chain, combinations
from math import inf, nan
from typing import Any

import numpy as np
import pytest

from observers import AligningTorque, Ekf, Mhe, Sample, Status, SteeringTorque
from reference_rig import RigRecording, SteeringRecording
from tests.observers.conftest import make
from tests.observers.factories import (
    CLEAN_RIG,
    columns_of,
    estimates_of,
    full_slide,
    kinds,
    samples_of,
    states_of,
)

pytestmark = pytest.mark.usefixtures("interpreted")

KINDS = kinds()
FLAGS = [flag for flag in Status if flag]


def test_every_flag_has_its_own_remedy_and_together_they_say_all_there_is_to_say() -> None:
    remedies = [flag.remedy for flag in FLAGS]

    assert len(FLAGS) == 11
    assert all(remedies)
    assert len(set(remedies)) == len(remedies)
    assert not any(";" in text or "\n" in text for text in remedies)
    for few in chain(combinations(FLAGS, 2), combinations(FLAGS, 3)):
        together = Status(sum(few))
        # While friction is acquired a bound says nothing yet.
        told = [flag for flag in few if flag is not Status.BOUND or Status.ACQUIRING not in few]
        assert together.remedy == "; ".join(flag.remedy for flag in told)
    assert Status.USED.remedy == ""
    assert Status(0) == Status.USED


@pytest.fixture
def samples(recording: RigRecording, steered: SteeringRecording) -> dict[type, list[Sample]]:
    return {
        AligningTorque: samples_of(columns_of(recording, slice(0, 300))),
        SteeringTorque: samples_of(columns_of(steered, slice(0, 900))),
    }


@pytest.mark.parametrize(("kind", "settings"), KINDS)
@pytest.mark.parametrize("nothing", [nan, inf, -inf])
def test_nothing_at_any_input_at_any_time_spoils_no_estimate(
    kind: Any, settings: Any, nothing: float, samples: Any
) -> None:
    observer = make(kind, **settings)
    mine = samples[type(observer.measurement_model)]
    rng = np.random.default_rng(6)
    names = ("psi", "psi_dot", "F_N", "M_z", "M")
    faulty = []
    for i, sample in enumerate(mine):
        # Alone, in bouts, and all at once.
        share = 1.0 if i % 50 > 44 else 0.3 if i % 3 == 0 else 0.0
        gone = {name: nothing for name in names if rng.random() < share}
        faulty.append(sample if i == 0 else replace(sample, **gone))
    states = list(states_of(observer, faulty))
    said = [observer.estimate(state) for state in states]

    numbers = np.array([[e.mu, e.mu_std, e.M_z_predicted] for e in said])
    assert np.isfinite(numbers).all()
    assert (numbers[:, 1] > 0).all()
    for state in states:
        assert np.isfinite(state["x"]).all()
        assert np.isfinite(state["factor"]).all()
        assert (np.diag(state["factor"]) > 0).all()


@pytest.mark.parametrize(("kind", "settings"), KINDS)
@pytest.mark.parametrize("name", ["psi", "psi_dot", "F_N", "M_z", "M"])
def test_one_sensor_lost_for_good_at_the_first_sample(
    kind: Any, settings: Any, name: str, samples: Any
) -> None:
    observer = make(kind, **settings)
    mine = samples[type(observer.measurement_model)][:60]
    first = observer.init(mine[0])
    state = first
    for sample in mine:
        state = observer.step(state, replace(sample, **{name: nan}))
        now = observer.estimate(state)
        assert np.isfinite([now.mu, now.mu_std, now.M_z_predicted]).all()
    needed = ("psi", "F_N", "M") if "psi" in observer.states else ("psi", "F_N", "M_z")
    assert bool(now.status & (Status.MISSING | Status.HELD)) is (name in needed)


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_without_a_measurement_there_is_only_the_walk(kind: Any, settings: Any, samples: Any) -> None:
    observer = make(kind, mu_walk=0.3, **settings)
    mine = samples[type(observer.measurement_model)]
    lacking = {"psi": nan} if "psi" in observer.states else {"M_z": nan}
    states = list(states_of(observer, [replace(s, **lacking) if i else s for i, s in enumerate(mine)]))
    said = [observer.estimate(state) for state in states]

    assert all(Status.MISSING in e.status for e in said[1:])
    np.testing.assert_allclose([e.mu for e in said], said[0].mu, rtol=0, atol=1e-10)
    elapsed = np.cumsum([s.dt for s in mine])
    relative = np.array([e.mu_std / e.mu for e in said]) ** 2
    expected = relative[0] + 0.09 * (elapsed - elapsed[0])
    np.testing.assert_allclose(relative, expected, rtol=1e-9)
    assert not any(e.informed for e in said)


@pytest.mark.parametrize(("kind", "settings"), KINDS)
def test_the_zero_of_the_angle_does_not_matter(kind: Any, settings: Any, samples: Any) -> None:
    observer = make(kind, **settings)
    mine = samples[type(observer.measurement_model)][:120]
    turned = [replace(sample, psi=sample.psi + 0.3) for sample in mine]
    one, other = estimates_of(observer, mine), estimates_of(observer, turned)

    np.testing.assert_allclose([e.mu for e in other], [e.mu for e in one], rtol=1e-8)
    np.testing.assert_allclose([e.mu_std for e in other], [e.mu_std for e in one], rtol=1e-8)


@pytest.mark.parametrize("kind", [Ekf, Mhe])
@pytest.mark.parametrize(("factor", "bound"), [(30.0, 4.0), (-5.0, 0.02)])
def test_on_a_bound(kind: Any, factor: float, bound: float, samples: Any) -> None:
    observer = make(kind, **{**CLEAN_RIG, "zero_std": 1e-3})
    faulty = [replace(s, M_z=factor * s.M_z) for s in samples[AligningTorque]]
    said = estimates_of(observer, faulty)
    mu = np.array([e.mu for e in said])

    assert 0.02 - 1e-12 <= mu.min() <= mu.max() <= 4.0 + 1e-12
    on_bound = np.array([Status.BOUND in e.status for e in said])
    assert on_bound.any()
    bounds = [np.isclose(mu, bound, rtol=1e-12) for bound in (0.02, 4.0)]
    np.testing.assert_array_equal(on_bound, np.logical_or(*bounds))
    assert np.isclose(mu[on_bound], bound).mean() > 0.9


def test_unsettled_where_one_step_does_not_do() -> None:
    settings = {**CLEAN_RIG, "window": 20}
    samples = full_slide(np.full(40, 2.0), every=10_000)
    once, often = (estimates_of(make(Mhe, **settings, iterations=n), samples) for n in (1, 8))

    assert any(Status.UNSETTLED in e.status for e in once)
    assert not any(Status.UNSETTLED in e.status for e in often)
    assert "iterations" in Status.UNSETTLED.remedy
