from dataclasses import replace
from math import inf, nan
from typing import Any

import numpy as np
import pytest

from observers import Advice, Ekf, Loop, Probe, Sample, Status, SteeringLimits, SteeringTorque
from observers.quality.acquisition import OVER, OWN
from reference_rig import RigTyre, SteeredWheel
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from tests.observers.planning.conftest import LOAD, RIG, K

pytestmark = pytest.mark.usefixtures("optimised")
LIMITS = SteeringLimits(angle=0.3, rate=0.4, time=6.0)


def wheel_on(mu: float) -> SteeredWheel:
    """The independent rig's wheel on a friction."""
    return SteeredWheel(RigTyre(a=RIG.a, e=RIG.e, k=K, mu=mu), load=LOAD)


def follow(
    observer: Any, mu: float, target: float = 0.05, limits: SteeringLimits = LIMITS
) -> list[tuple[float, Advice]]:
    """Angles and advice until it ends; the wheel follows at once."""
    loop, probe, wheel = Loop(observer), Probe(observer, target, limits), wheel_on(mu)
    psi = rate = 0.0
    steered: list[tuple[float, Advice]] = []
    while len(steered) < 1000:
        sample = Sample(psi=psi, psi_dot=rate, F_N=LOAD, dt=0.01, M_z=wheel.turn(psi))
        loop(sample)
        steered.append((psi, probe(sample, loop.state)))
        if (advice := steered[-1][1]).finished or advice.stopped:
            break
        psi, rate = advice.psi, (advice.psi - psi) / 0.01
    return steered


@pytest.mark.parametrize(
    ("mu", "most"),
    [
        (0.3, 0.1),
        pytest.param(0.05, 0.25, marks=pytest.mark.long),
        pytest.param(0.9, 0.16, marks=pytest.mark.long),
    ],
)
def test_it_steers_until_friction_is_known(acquiring: Ekf, mu: float, most: float) -> None:
    steered = follow(acquiring, mu)
    psi, last = np.array([angle for angle, _ in steered]), steered[-1][1]

    assert last.finished
    assert not last.stopped
    assert last.estimate.usable
    assert last.estimate.mu_std <= 0.05 * last.estimate.mu
    assert last.estimate.mu == pytest.approx(mu, rel=0.05)
    assert last.travel == pytest.approx(np.abs(np.diff(psi)).sum(), abs=1e-3)
    assert last.travel < most
    assert last.psi == psi[-1]
    rates = np.diff(psi) / 0.01
    assert np.abs(rates).max() <= LIMITS.rate * (1 + 1e-6)
    # What a step of the rate may be in two samples, as a plan begins between them.
    assert np.abs(np.diff(rates)).max() <= 2 * LIMITS.acceleration * 0.01
    assert np.abs(psi).max() <= LIMITS.angle


@pytest.mark.long
def test_a_wheel_that_does_not_follow_gets_the_advice_from_where_it_stands(acquiring: Ekf) -> None:
    loop, probe = Loop(acquiring), Probe(acquiring, 0.05, LIMITS)
    for _ in range(300):
        sample = Sample(psi=0.0, psi_dot=0.0, F_N=LOAD, dt=0.01, M_z=0.0)
        loop(sample)
        advice = probe(sample, loop.state)

        assert {advice.finished, advice.stopped} == {False}
        assert abs(advice.psi) < 0.2
    assert advice.travel == 0
    assert abs(advice.toward) > 0


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ({"time": 0.2}, "the time of 0.2 s is over at"),
        pytest.param({"angle": 0.015, "time": 2.0}, "; as planned for mu = 0.8: never usable on the best"
         " path; twice the limit of angle would do", marks=pytest.mark.long),
        pytest.param({"torque": 0.4}, "limit of 0.4 N m keeps the wheel", marks=pytest.mark.long),
    ],
)  # fmt: skip
def test_it_stops_and_says_why(acquiring: Ekf, limits: dict[str, float], words: str) -> None:
    last = follow(acquiring, 0.8, 0.05, replace(LIMITS, **limits))[-1][1]

    assert last.stopped
    assert not last.finished
    assert words in last.reason


@pytest.mark.long
def test_resumed_it_keeps_its_limits(acquiring: Ekf) -> None:
    loop, probe = Loop(acquiring), Probe(acquiring, 0.1, SteeringLimits(angle=0.3, rate=0.4))

    def bounds(psi: float) -> tuple[float, float]:
        loop(sample := Sample(psi=psi, psi_dot=0.0, F_N=LOAD, dt=0.01, M_z=0.0))
        probe(sample, loop.state)
        return probe._bounds

    for _ in range(60):
        first = bounds(0.1)
    assert first == pytest.approx((-0.2, 0.4))
    probe.restart_advice()
    assert bounds(0.16) == first
    probe.reset()
    assert np.isnan(probe._bounds).all()


@pytest.mark.long
def test_the_torque_limit_is_kept(acquiring: Ekf) -> None:
    steered = follow(acquiring, 0.8, 0.05, replace(LIMITS, torque=2.0, time=2.0))
    wheel = wheel_on(0.8)

    # A sample late at most.
    assert max(abs(wheel.turn(psi)) for psi, _ in steered) < 2.0 + 1.0


@pytest.mark.long
def test_where_the_torque_is_met_the_rate_is_kept(acquiring: Ekf) -> None:
    steered = follow(acquiring, 1.1, 0.05, replace(LIMITS, torque=3.0, time=1.2))
    psi = np.array([angle for angle, _ in steered])
    wheel = wheel_on(1.1)

    assert max(abs(wheel.turn(angle)) for angle in psi) > 3.0
    assert np.abs(np.diff(psi)).max() <= LIMITS.rate * 0.01 * (1 + 1e-6)


def tracked(**own: float) -> dict[str, Array]:
    """A state after the handover, as far as a Probe looks at it."""
    return {"own": np.array([own.get(name, 0.0) for name in OWN])}


def test_an_estimate_that_moved_by_more_than_its_deviation_is_believed_half_as_much_later(
    acquiring: Ekf,
) -> None:
    probe, known = Probe(acquiring, 0.05, LIMITS), replace(acquiring.prior, informed=True)
    first = replace(known, mu=0.69, mu_std=0.02 * 0.69, status=Status.ACQUIRING)
    later = replace(known, mu=0.75, mu_std=0.012 * 0.75, status=Status.USED)
    probe._travel = 0.1

    assert not probe._is_target_reached(first, tracked())
    assert not probe._is_target_reached(later, tracked())
    probe._travel = 0.149
    assert not probe._is_target_reached(later, tracked())
    probe._travel = 0.151
    assert probe._is_target_reached(later, tracked())
    probe.reset()
    # While friction is acquired it may move, and 2 % within 3 times 2 % is no movement.
    assert not probe._is_target_reached(first, tracked(acquiring=1.0))
    assert probe._is_target_reached(later, tracked())
    probe.reset()
    assert not probe._is_target_reached(replace(first, mu=0.735, mu_std=0.02 * 0.735), tracked())
    assert probe._is_target_reached(later, tracked())


def test_what_the_stiffness_adds_no_steering_of_this_run_lowers(acquiring: Ekf) -> None:
    probe, sample = Probe(acquiring, 0.05, LIMITS), Sample(psi=0.0, psi_dot=0.0, F_N=LOAD, dt=0.01)

    assert (
        probe._irreducible_reason_text(sample, acquiring.prior, tracked(excess=0.03, phase=OVER)) == ""
    )
    assert (
        "5.0% of mu cannot be reached in this run: by its estimate 6.8% remains, most of it by a"
        " stiffness that is not the declared one, or not known better; begin anew"
        in probe._irreducible_reason_text(sample, acquiring.prior, tracked(excess=0.06, phase=OVER))
    )
    # While the search for the torque's scale goes on, it may still fall.
    assert probe._irreducible_reason_text(sample, acquiring.prior, tracked(excess=0.06)) == ""


@pytest.mark.parametrize(
    ("target", "limits", "words"),
    [
        (0.02, {}, "mu = 1.2: 2.0% cannot be reached by any steering: tolerances of half-length"),
        (nan, {}, "target must be a share"),
        (0.05, {"time": 0.05}, "limit time must be at least 0.1 s"),
        (0.05, {"rate": 0.06}, "limit rate must be at least 0.1 rad/s"),
    ],
)
def test_what_no_load_allows_is_refused_at_once(
    acquiring: Ekf, target: float, limits: dict[str, float], words: str
) -> None:
    with pytest.raises(InvalidInputError, match=words):
        Probe(acquiring, target, replace(LIMITS, **limits))


def test_what_this_load_keeps_out_of_reach_stops_the_first_sample(acquiring: Ekf) -> None:
    stiff = replace(acquiring, rig=replace(acquiring.rig, dry_friction=2.0))
    loop, probe = Loop(stiff), Probe(stiff, 0.1, LIMITS)
    with pytest.raises(InvalidInputError, match=r"steering: dry friction alone leaves 24\.7%"):
        probe.prepare(LOAD)
    sample = Sample(psi=0.0, psi_dot=0.0, F_N=LOAD, dt=0.01, M_z=0.0)
    loop(sample)
    without_load = replace(sample, F_N=0.0)
    assert not probe(without_load, loop.state).stopped
    advice = probe(sample, loop.state)

    assert advice.stopped
    assert not advice.finished
    assert advice.psi == sample.psi
    assert "by any steering: 24.9% remains, most of it by dry friction" in advice.reason
    # An estimate beyond the prior may do with what no friction of the prior allows.
    assert "by any steering: dry friction alone leaves 24.7%" in probe._update_progress(sample)


def test_it_waits_for_the_observer(acquiring: Ekf) -> None:
    probe = Probe(acquiring, 0.05, LIMITS)
    advice = probe(Sample(psi=nan, psi_dot=0.0, F_N=LOAD, dt=0.01), None)

    assert {advice.finished, advice.stopped} == {False}
    assert advice.estimate.mu == acquiring.tuning.mu


def test_the_steering_torque_is_refused(acquiring: Ekf) -> None:
    rig = replace(acquiring.rig, J_A=0.15, b_t=1.0)
    observer = replace(acquiring, rig=rig, measurement_model=SteeringTorque())
    with pytest.raises(InvalidInputError, match="needs an observer of M_z or of the rack"):
        Probe(observer, 0.05, LIMITS)
    assert LIMITS.torque == inf
