import numpy as np
import pytest

from brushgrip.formatting import estimates_summary
from observers import Estimates, Status


def made(*status: Status, std: float = 0.02) -> Estimates:
    size = len(status)
    return Estimates(
        t=np.arange(size) * 0.01,
        mu=np.linspace(1.0, 1.25, size),
        mu_std=np.full(size, std),
        M_z_predicted=np.zeros(size),
        informed=np.arange(size) >= size / 2,
        status=np.array(status, dtype=np.int64),
    )


def test_nothing_to_complain_about() -> None:
    line = estimates_summary(made(*[Status.USED] * 4))

    assert line == "mu = 1.250 ± 0.020 at the end, informed in 50 % of 4 samples"


def test_without_standard_deviation() -> None:
    assert estimates_summary(made(*[Status.USED] * 4, std=np.nan)).startswith("mu = 1.250 at the end, ")


@pytest.mark.parametrize(
    ("status", "words"),
    [
        ([Status.MISSING], "1 sample: no measurement"),
        ([Status.MISSING | Status.HELD, Status.HELD], "2 samples: angle, load or steering torque"),
        ([Status.REJECTED] * 2 + [Status.MISSING] * 3, "2 samples rejected; 3 samples: no measurement"),
        ([Status.RESET], "1 change of the ground; 1 sample: the ground has changed"),
        (
            [Status.RESET] * 2 + [Status.REJECTED],
            "1 sample rejected, 2 changes of the ground; 2 samples",
        ),
    ],
)
def test_faults_are_counted_and_the_most_frequent_gets_its_remedy(
    status: list[Status], words: str
) -> None:
    line = estimates_summary(made(*status, *[Status.USED] * 4))

    assert words in line
    assert "\n" not in line
