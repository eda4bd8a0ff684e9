from pathlib import Path

import numpy as np
import pytest

from identification.thesis.published_author_estimate import (
    author_estimate_file,
    begin_of_part,
    read_author_estimate,
)
from tests.refusal import fault_of, refused

HEADER = ",".join(["NaN"] * 12)
ROW = "0.0,0.02,0.0,-2.5,0.009,306,0.04,2438000,1,0,2.1,1.674"
BACK = "0.01,0.01,0.02,-2.4,0.009,306,0.04,2438000,0,1,2.2,1.674"


def write(folder: Path, *lines: str) -> Path:
    path = folder / "author_estimate_run.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_columns(tmp_path: Path) -> None:
    made = read_author_estimate(write(tmp_path, HEADER, ROW, BACK))

    assert made.declared == 1.674
    assert made.t.tolist() == [0.0, 0.01]
    assert made.psi.tolist() == [0.02, 0.01]
    assert made.psi_max.tolist() == [0.0, 0.02]
    assert made.direction.tolist() == [1, -1]
    assert made.zones.tolist() == [3, 5]
    assert made.mu.tolist() == [2.1, 2.2]


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ((HEADER, ROW, BACK[:-6]), "no estimate of the author"),
        ((HEADER, "1,2,3", "1,2,3"), "no estimate of the author"),
        ((HEADER, ROW), "no estimate of the author"),
        ((HEADER, ROW, BACK.replace("2.2", "two")), "no estimate of the author"),
        ((HEADER, ROW, BACK.replace("2.2", "nan")), "row 3: every number must be finite"),
    ],
)
def test_faults_name_the_file(tmp_path: Path, lines: tuple[str, ...], said: str) -> None:
    assert said in fault_of(read_author_estimate, write(tmp_path, *lines))


def test_his_mark_is_not_in_his_names() -> None:
    assert author_estimate_file(Path("x"), "fem4_ident") == Path("x/author_estimate_fem4.csv")
    assert author_estimate_file(Path("x"), "fem1") == Path("x/author_estimate_fem1.csv")


def test_aligned_by_angle() -> None:
    psi = np.sin(np.arange(50) * 0.3)

    assert begin_of_part(psi, psi[17:40]) == 17
    assert "not those of the recording" in refused(begin_of_part, psi, psi[17:40] + 0.1)
    assert "not those of the recording" in refused(begin_of_part, psi[:5], psi)
