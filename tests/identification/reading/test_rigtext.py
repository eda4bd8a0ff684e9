from pathlib import Path

import pytest

from identification import read_rig
from identification.reading.rigtext import rig_text
from symbolic import Rig, Tolerances, Tyre


@pytest.mark.parametrize(
    ("rig", "tyre"),
    [
        (Rig(a=0.045, e=0.009), Tyre(k=2.4e6)),
        (
            Rig(
                a=0.1 / 3,
                e=-0.01,
                J_A=0.14,
                b_t=1.5,
                tolerances=Tolerances(a=0.002, e=1e-3, load=0.02, zero=0.1),
            ),
            Tyre(k=2.4e6 / 7, mu=1.2),
        ),
    ],
)
def test_what_is_written_is_read_again(tmp_path: Path, rig: Rig, tyre: Tyre) -> None:
    path = tmp_path / "rig.toml"
    path.write_text(rig_text(rig, tyre))

    assert read_rig(path) == (rig, tyre)
