import numpy as np
import pytest

from observers import Ekf, Plan, SteeringLimits, plan
from symbolic import InvalidInputError
from tests.observers.planning.conftest import LOAD, observe_on_rig

LIMITS = SteeringLimits(angle=0.3, rate=0.4, time=6.0)
FEW = ((0.15, 0.1, 1.5), (1.0, 1.0, 1.0))
"""A small slow swing that grows, and a turn to the limit."""


@pytest.fixture(scope="module")
def planned(acquiring: Ekf) -> Plan:
    return plan(acquiring, 0.05, LIMITS, LOAD, mus=(0.1, 0.8), starts=FEW, refinements=8)


def test_a_plan_stays_within_the_limits(planned: Plan) -> None:
    path = planned.path

    assert np.abs(path.psi).max() <= LIMITS.angle
    assert LIMITS.slowest <= np.abs(path.psi_dot).max() <= LIMITS.rate
    assert path.t[-1] <= LIMITS.time
    assert planned.reasons == ()
    assert planned.turns[-1] == path.psi[-1]
    # It ends where the last ground is known.
    assert path.travel[-1] == planned.travels.max()


def test_on_the_rig_the_target_is_reached_where_planned(acquiring: Ekf, planned: Plan) -> None:
    for mu, travel in zip(planned.mus, planned.travels, strict=True):
        estimates, _ = observe_on_rig(acquiring, planned.path, mu)
        good = [one.usable and one.mu_std <= 0.0505 * one.mu for one in estimates]

        assert planned.path.travel[good.index(True)] == pytest.approx(travel, abs=0.01)
        assert (
            max(abs(one.mu / mu - 1) for one, known in zip(estimates, good, strict=True) if known) < 0.05
        )


def test_turning_back_tells_ice_sooner_than_turning_on(acquiring: Ekf) -> None:
    on, back = (
        plan(acquiring, 0.05, LIMITS, LOAD, mus=(0.05,), starts=(start,), refinements=0)
        for start in ((0.3, 1.0, 1.0), (0.3, 0.1, 1.5))
    )

    # The zero of the torque looks like friction until the wheel has turned back.
    assert on.reached == (None,)
    assert on.path.travel[-1] > 2 * LIMITS.angle
    assert back.travels[0] < LIMITS.angle


def test_the_search_does_not_make_a_start_worse(acquiring: Ekf, planned: Plan) -> None:
    start = plan(acquiring, 0.05, LIMITS, LOAD, mus=(0.1, 0.8), starts=FEW, refinements=0)

    assert planned.travels.max() <= start.travels.max() + 0.1 * start.travels.mean()


def test_time_and_angle_may_be_least(acquiring: Ekf) -> None:
    given = {"mus": (0.8,), "starts": FEW, "refinements": 0}
    quick = plan(acquiring, 0.05, LIMITS, LOAD, objective="time", **given)
    narrow = plan(acquiring, 0.05, LIMITS, LOAD, objective="angle", over="mean", **given)

    assert quick.path.t[-1] < narrow.path.t[-1]
    assert np.abs(narrow.path.psi).max() < np.abs(quick.path.psi).max()


@pytest.mark.parametrize(
    ("target", "limits", "words"),
    [
        (0.02, {}, "2.0% cannot be reached by any steering: tolerances of half-length and caster alone"),
        (0.05, {"torque": 1.0}, "the torque exceeds its limit of 1 N m before"),
        (0.05, {"time": 0.3}, "after 0.3 s, friction is being acquired"),
    ],
)
def test_what_cannot_be_reached_is_told(
    acquiring: Ekf, target: float, limits: dict[str, float], words: str
) -> None:
    limited = SteeringLimits(**{"angle": 0.3, "rate": 0.4, "time": 3.0} | limits)
    told = plan(acquiring, target, limited, LOAD, mus=(0.8,), starts=FEW, refinements=0)

    assert told.reached == (None,)
    assert np.isnan(told.travels).all()
    assert len(told.reasons) == 1
    assert words in told.reasons[0]


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"target": 0.0}, "target must be a share"),
        ({"target": 1.0}, "target must be a share"),
        ({"mus": ()}, "frictions must be"),
        ({"mus": (0.001,)}, "frictions must be"),
        ({"F_N": float("nan")}, "load must be greater than 0"),
    ],
)
def test_bad_arguments_are_refused(acquiring: Ekf, given: dict[str, object], words: str) -> None:
    usual = {"target": 0.05, "limits": LIMITS, "F_N": LOAD}
    with pytest.raises(InvalidInputError, match=words):
        plan(acquiring, **usual | given)
