from dataclasses import replace
from typing import Any

import pytest

from observers import Ekf, Estimate, Status, SteeringLimits
from observers.planning.advice_and_stop_reasons import (
    irreducible_reason_text,
    time_limit_reason_text,
    unreached_friction_text,
)
from observers.planning.forecast import percent_text_beside_target
from tests.observers.planning.conftest import LOAD

LIMITS = SteeringLimits(angle=0.2, time=6.0)


class Planned:
    """A plan as far as its reasons go."""

    target, mus, reached = 0.08, (0.1, 0.4, 0.8, 1.2), (30, None, 50, None)
    reasons = ("mu = 0.4: twice the angle", "mu = 1.2: twice the time")


class AllReached(Planned):
    """A plan that reaches all."""

    reached, reasons = (30, 40, 50, 60), ()


def at(mu: float, deviation: float, status: Status = Status.USED) -> Estimate:
    """An estimate that is informed."""
    return Estimate(mu=mu, mu_std=deviation * mu, M_z_predicted=0.0, informed=True, status=status)


@pytest.mark.parametrize(
    ("mu", "deviation", "reason"),
    [
        (0.4, 0.02, "as planned for mu = 0.4: twice the angle"),
        (0.5, 0.02, "as planned for mu = 0.4: twice the angle"),
        (0.9, 0.02, "as planned for mu = 1.2: twice the time"),
        (1.8, 2.0, "as planned for mu = 1.2: twice the time"),
        (0.06, 0.02, ""),
        (0.06, 1.0, "as planned for mu = 0.4: twice the angle"),
        (0.8, 0.02, ""),
        # Nothing at all is known, as of a torque sensor that is dead.
        (0.02, 400.0, "as planned for mu = 0.4: twice the angle"),
    ],
)
def test_the_plan_speaks_for_the_frictions_beside_the_estimate(
    mu: float, deviation: float, reason: str
) -> None:
    assert unreached_friction_text(Planned(), at(mu, deviation)) == reason  # type: ignore[arg-type]
    assert unreached_friction_text(AllReached(), at(mu, deviation)) == ""  # type: ignore[arg-type]


def test_an_effective_friction_is_what_a_plan_is_for() -> None:
    estimate = replace(at(0.1, 0.02), mu_eff=0.4)

    assert unreached_friction_text(Planned(), estimate).endswith("twice the angle")  # type: ignore[arg-type]


MORE_TIME = "; no limit but the time was met: more time or a wider target may do"


@pytest.mark.parametrize(
    ("plan", "estimate", "farthest", "held", "words"),
    [
        (
            Planned,
            at(0.4, 0.06, Status.ACQUIRING),
            0.2,
            "",
            "6.0%, within 8.0% but not usable; as planned for mu = 0.4: twice the angle",
        ),
        (Planned, at(0.4, 0.09), 0.2, "held", "9.0%; held; as planned for mu = 0.4: twice the angle"),
        (AllReached, at(0.4, 0.0801), 0.1, "", f"8.01%{MORE_TIME}"),
        (
            AllReached,
            at(0.4, 0.07),
            0.1,
            "",
            f"7.0%, within 8.0% but moved by more than that lately{MORE_TIME}",
        ),
        (
            AllReached,
            at(0.4, 0.09),
            0.195,
            "",
            "9.0%; the wheel came to the limit of angle, 0.2 rad: a wider one, more time or a wider"
            " target may do",
        ),
        (AllReached, at(0.4, 0.09, Status.ACQUIRING | Status.BOUND), 0.1, "", f"9.0%{MORE_TIME}"),
        (
            AllReached,
            at(0.4, 0.09, Status.SUSPECT),
            0.1,
            "",
            f"9.0%; {Status.SUSPECT.remedy}",
        ),
    ],
)
def test_the_end_of_the_time_says_what_binds(
    plan: Any, estimate: Estimate, farthest: float, held: str, words: str
) -> None:
    told = time_limit_reason_text(plan(), estimate, LIMITS, farthest, held)

    assert told == f"the time of 6 s is over at {words}"


def test_what_remains_is_told_of_the_ground_or_of_the_run(acquiring: Ekf) -> None:
    def reason(target: float, mu: float, excess: float, load: float = LOAD) -> str:
        return irreducible_reason_text(acquiring, target, at(mu, 0.05), load, 1.2, excess)

    assert reason(0.035, 0.8, 0.0) == ""
    assert "3.5% of mu cannot be reached by any steering on mu = 0.05: 3.7% remains" in reason(
        0.035, 0.05, 0.0
    )
    assert "4.0% of mu cannot be reached in this run: by its estimate" in reason(0.04, 0.05, 0.03)
    assert reason(0.035, 0.05, 0.0, 0.0) == reason(0.035, 0.05, 0.0, float("nan")) == ""


@pytest.mark.parametrize(
    ("value", "target", "text"),
    [
        (0.044, 0.05, "4.4%"),
        (0.0504, 0.05, "5.04%"),
        (0.0496, 0.05, "4.96%"),
        (0.05002, 0.05, "5.002%"),
        (0.05, 0.05, "5.0%"),
    ],
)
def test_a_share_beside_a_target_has_the_digits_that_tell_them_apart(
    value: float, target: float, text: str
) -> None:
    assert percent_text_beside_target(value, target) == text
