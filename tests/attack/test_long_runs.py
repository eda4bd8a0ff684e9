"""The short form of the long runs."""

import math

import pytest

from tests.attack import names
from tests.attack.attack_class import Effort, undertake
from tests.attack.long_runs import Stream, attack_observers, observers


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n == "ekf" else pytest.mark.long) for n in observers()]
)
def test_a_block_of_odd_samples(name: str) -> None:
    assert Stream(name, 0).go_on() is None


@pytest.mark.usefixtures("interpreted")
def test_an_estimate_that_is_none_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = Stream("root", 0)
    monkeypatch.setattr(stream, "loop", lambda _: stream_estimate)
    stream_estimate = type("Broken", (), {"mu": math.nan})

    assert "mu is nan" in (stream.go_on() or "")


@pytest.mark.long
def test_threads_and_a_child_go_on_together() -> None:
    outcome = undertake(attack_observers, Effort(seconds=5, inputs=20_000))

    assert outcome.inputs >= 20_000 or not outcome.failures
    assert outcome.failures == ()


@pytest.mark.long
@pytest.mark.parametrize("number", [0, 9])
def test_odd_names(number: int) -> None:
    assert names.attempt(number) is None
