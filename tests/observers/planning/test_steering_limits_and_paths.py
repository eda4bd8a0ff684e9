import numpy as np
import pytest

from observers import SteeringLimits
from observers.planning.steering_limits_and_paths import fastest_path
from symbolic import InvalidInputError


def test_a_path_turns_within_rate_and_acceleration_and_reaches_its_points() -> None:
    path = fastest_path([0.1, 0.3, 0.297, -0.1], 0.4, 5.0, 0.001, 10.0)
    rate = np.diff(path.psi, prepend=0.1) / 0.001

    assert np.abs(path.psi_dot).max() == pytest.approx(0.4)
    assert np.abs(np.diff(rate)).max() <= 5.0 * 0.001 * (1 + 1e-6)
    # The rate is the derivative of the angle.
    assert rate == pytest.approx(path.psi_dot, abs=0.51 * 5.0 * 0.001)
    assert [path.psi.max(), path.psi[-1]] == pytest.approx([0.3, -0.1], abs=1e-4)
    assert path.travel[-1] == pytest.approx(0.2 + 0.003 + 0.397, abs=1e-4)
    # A leg of length L takes L / v + v / acceleration; a short one 2 (L / acceleration)^(1/2).
    assert path.t[-1] == pytest.approx(
        0.2 / 0.4 + 0.397 / 0.4 + 2 * 0.08 + 2 * (0.003 / 5) ** 0.5, abs=2e-3
    )


def test_a_path_is_continued_from_its_middle() -> None:
    whole = fastest_path([0.0, 0.2, -0.1], 0.4, 5.0, 0.01, 10.0)
    at = 30
    rest = fastest_path([whole.psi[at], 0.2, -0.1], 0.4, 5.0, 0.01, 10.0, speed=whole.psi_dot[at])

    assert rest.psi == pytest.approx(whole.psi[at + 1 :])
    assert rest.psi_dot == pytest.approx(whole.psi_dot[at + 1 :])


def test_a_path_may_rest_before_it_turns_and_ends_with_the_time() -> None:
    at_once, rested = (
        fastest_path([0.0, 0.2, -0.1], 0.4, 5.0, 0.01, 10.0, rest=rest) for rest in (0.0, 0.5)
    )

    assert not rested.psi[:50].any()
    assert rested.psi[50:] == pytest.approx(at_once.psi)
    assert not fastest_path([0.0, 0.2], 0.4, 5.0, 0.01, 0.3, rest=0.5).travel.any()
    assert fastest_path([0.0, 0.2, -0.1], 0.4, 5.0, 0.01, 0.5).t[-1] == pytest.approx(0.5)


@pytest.mark.parametrize("name", ["angle", "rate", "torque", "time", "acceleration", "slowest"])
@pytest.mark.parametrize("value", [0.0, -1.0, float("nan")])
def test_limits_are_positive(name: str, value: float) -> None:
    with pytest.raises(InvalidInputError, match=f"limit {name} must be"):
        SteeringLimits(**{name: value})


def test_limits_are_bounded_and_the_rate_is_at_least_the_slowest_one() -> None:
    with pytest.raises(InvalidInputError, match="limit angle must be greater than 0 and at most 20"):
        SteeringLimits(angle=1e9)
    with pytest.raises(InvalidInputError, match="at least the slowest one"):
        SteeringLimits(rate=0.01)
