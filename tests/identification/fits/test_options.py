import pytest

from identification import FitOptions
from symbolic import InvalidInputError


@pytest.mark.parametrize(
    ("wrong", "fault"),
    [
        ({"tolerance": 0.0}, "tolerance must be greater than 0, got 0.0"),
        ({"tolerance": float("nan")}, "tolerance must be greater than 0, got nan"),
        ({"max_evaluations": 0}, "max_evaluations must be at least 1, got 0"),
    ],
)
def test_faults(wrong: dict[str, float], fault: str) -> None:
    with pytest.raises(InvalidInputError, match=fault):
        FitOptions(**wrong)  # type: ignore[arg-type]


def test_is_a_value() -> None:
    assert FitOptions(tolerance=1e-3) == FitOptions(tolerance=1e-3)
    assert FitOptions() != FitOptions(free_shared=False)
