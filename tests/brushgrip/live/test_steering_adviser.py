from dataclasses import replace
from threading import Event
from typing import Any, cast

import pytest

from brushgrip.live.steering_adviser import PLANNING, SteeringAdviser, advice_text
from observers import (
    Advice,
    Ekf,
    Estimate,
    Loop,
    Observer,
    Probe,
    RootObserver,
    Sample,
    Status,
    SteeringLimits,
    SteeringTorque,
)
from symbolic import Model, Rig
from tests.processes import wait_for

RIG = Rig(a=0.045, e=0.009)
OBSERVER = Ekf(model=Model(), values={"k": 2.4e6}, rig=RIG)
ADVICE = Advice(
    psi=0.0, psi_dot=0.1, toward=0.2, finished=False, stopped=False, reason="", travel=0.0, left=0.3,
    estimate=OBSERVER.prior,
)  # fmt: skip
SAMPLE = Sample(psi=0.0, psi_dot=0.0, F_N=560.0, dt=0.01, M_z=0.0)


@pytest.mark.parametrize(
    ("changes", "psi", "text"),
    [
        ({}, 0.2 - 0.1396, "turn 8° more to the left"),
        ({"toward": -0.1}, 0.0, "turn 6° more to the right"),
        ({"toward": 0.0063}, 0.0, "turn 0.4° more to the left"),
        ({}, 0.2, ""),
        ({"finished": True}, 0.2, "friction is known to 5.0%, stop turning"),
        ({"stopped": True, "reason": "too far"}, 0.2, "stop turning: too far"),
    ],
)
def test_an_advice_says_how_far_and_which_way(changes: dict[str, Any], psi: float, text: str) -> None:
    assert advice_text(replace(ADVICE, **changes), psi, 0.05) == text


@pytest.mark.long
def test_it_advises_without_keeping_samples_waiting(monkeypatch: pytest.MonkeyPatch) -> None:
    # Compiled and planned beforehand, however long that takes.
    probe = Probe(OBSERVER, 0.05, SteeringLimits(angle=0.3))
    probe.prepare(SAMPLE.F_N)
    monkeypatch.setattr("brushgrip.live.steering_adviser.Probe", lambda *_: probe)
    adviser, loop = SteeringAdviser(0.05, SteeringLimits(angle=0.3)), Loop(OBSERVER)
    adviser.begin(OBSERVER)
    for _ in range(30):
        loop(SAMPLE)
        adviser(SAMPLE, loop.state, OBSERVER.prior)
    wait_for(lambda: adviser.text.startswith("turn "))
    adviser.begin(OBSERVER)
    assert adviser.text == PLANNING


@pytest.mark.parametrize(
    ("observer", "reason"),
    [
        (RootObserver(rig=RIG, k=2.4e6), "--target is for ekf and mhe"),
        (
            replace(
                OBSERVER, rig=Rig(a=0.045, e=0.009, J_A=0.1, b_t=1.0), measurement_model=SteeringTorque()
            ),
            "a Probe needs an observer of M_z",
        ),
    ],
)
def test_without_a_forecast_it_says_why_there_is_no_advice(observer: Observer, reason: str) -> None:
    adviser = SteeringAdviser(0.05, SteeringLimits())
    adviser.begin(observer)

    wait_for(lambda: adviser.text != PLANNING)
    assert adviser.text.startswith(f"no advice: {reason}")


def test_friction_that_is_known_no_more_is_sought_again(monkeypatch: pytest.MonkeyPatch) -> None:
    known = replace(OBSERVER.prior, informed=True)

    class Stated(Ekf):
        """Whose state is its estimate."""

        def estimate(self, state: Any) -> Estimate:
            return cast(Estimate, state)

    class Once:
        """Has reached its target until it is reset."""

        def __init__(self, *_: object) -> None:
            self.finished = True

        def restart_advice(self) -> None:
            self.finished = False

        def __call__(self, *_: object) -> Advice:
            return replace(ADVICE, finished=self.finished)

    monkeypatch.setattr("brushgrip.live.steering_adviser.Probe", Once)
    adviser = SteeringAdviser(0.05, SteeringLimits())
    adviser.begin(Stated(model=Model(), values={"k": 2.4e6}, rig=RIG))
    for status, text in (
        (Status.USED, "friction is known to 5.0%, stop turning"),
        (Status.MISSING, "friction is known to 5.0%, stop turning"),
        (Status.REJECTED, "friction is known to 5.0%, stop turning"),
        (Status.MISSING | Status.HELD, "friction is known to 5.0%, stop turning"),
        (Status.ACQUIRING, "turn 11° more to the left"),
    ):
        adviser._text = ""
        adviser(SAMPLE, replace(known, status=status), known)
        wait_for(lambda: adviser.text)
        assert adviser.text == text
    adviser._generation += 1


def test_an_adviser_behind_says_where_to_turn_from_where_the_wheel_is_now(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    all_there, end = Event(), Event()

    class Slow:
        """Plans once, for the second sample not before the end."""

        def __init__(self, *_: object) -> None:
            self._gates = iter((all_there, end))

        def __call__(self, *_: object) -> Advice:
            next(self._gates).wait()
            return ADVICE

    monkeypatch.setattr("brushgrip.live.steering_adviser.Probe", Slow)
    adviser = SteeringAdviser(0.05, SteeringLimits())
    adviser.begin(OBSERVER)
    for psi in (0.0, 0.05, 0.2 - 0.1396):
        adviser(replace(SAMPLE, psi=psi), None, OBSERVER.prior)
    assert adviser.text == PLANNING
    all_there.set()
    wait_for(lambda: adviser.text != PLANNING)
    assert adviser.text == "turn 8° more to the left"
    adviser._generation += 1
    end.set()


def test_friction_that_is_known_before_the_plan_needs_none(monkeypatch: pytest.MonkeyPatch) -> None:
    end, known = Event(), replace(OBSERVER.prior, informed=True, mu=0.8, mu_std=0.03, status=Status.USED)

    class Compiling:
        """Whose first plan takes longer than all samples."""

        def __init__(self, *_: object) -> None:
            end.wait()

        def __call__(self, *_: object) -> Advice:
            return ADVICE

    monkeypatch.setattr("brushgrip.live.steering_adviser.Probe", Compiling)
    adviser = SteeringAdviser(0.05, SteeringLimits())
    adviser.begin(OBSERVER)
    for estimate, text in (
        (replace(known, mu_std=0.05), PLANNING),
        (known, "friction is known to 5.0%, stop turning"),
        (replace(known, status=Status.MISSING), "friction is known to 5.0%, stop turning"),
        (replace(known, mu_std=0.05), "friction is known to 5.0%, stop turning"),
        (replace(known, status=Status.ACQUIRING), PLANNING),
    ):
        for _ in range(2):
            adviser(SAMPLE, None, estimate)
        assert adviser.text == text
    # A plan that knows of it says what is to be done, whatever that one sample says.
    adviser(SAMPLE, None, known)
    end.set()
    wait_for(lambda: adviser.text.startswith("turn "))
    adviser._generation += 1
