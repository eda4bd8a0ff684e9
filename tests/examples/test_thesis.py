"""The examples that reproduce [Györök 2022], compared with the figures that the thesis gives."""

import re
from pathlib import Path

import pytest

from tests.examples.running import NUMBER, numbers, printed_by

pytestmark = pytest.mark.long
PUBLISHED = {"0.5": 0.009, "1.8": 0.077}
"""RMSE of the author's estimate on his simulations, from 0.5 s on."""
NOWHERE = ("--data", "nowhere")


def rows(text: str, cell: str) -> dict[str, list[float]]:
    """Numbers of a table's rows by their first cell."""
    found = re.findall(r"^\| ([\d.]+) \|(.*)\|$", text, flags=re.MULTILINE)
    return {mu: [float(value) for value in re.findall(cell, row)] for mu, row in found}


def test_thesis_profile(tmp_path: Path) -> None:
    text = printed_by("thesis_profile.py", tmp_path)
    peaks = numbers(text, rf"mu = 1: angle to {NUMBER} rad, torque to {NUMBER} N m")

    assert peaks[:2] == pytest.approx(peaks[2:], rel=5e-4)
    assert text.count("at most 5 zones") == text.count("at most 11 zones") == 3


def test_thesis_profile_is_the_published_one(tmp_path: Path, simulation_dir: Path) -> None:
    text = printed_by("thesis_profile.py", tmp_path, str(simulation_dir))
    off = numbers(text, rf"angle within {NUMBER}% of the published range$")

    assert len(off) == 2
    assert max(off) < 1


def test_thesis_analytic(tmp_path: Path) -> None:
    text = printed_by("thesis_analytic.py", tmp_path, "pictures", leaves="pictures")
    in_time = numbers(text, rf"torque in time: RMSE {NUMBER}$")
    late = numbers(text, rf"torque late: RMSE {NUMBER}$")
    (raw,) = numbers(text, rf"raw: RMSE {NUMBER}$")
    (printed,) = numbers(text, rf"α = 0.01: RMSE {NUMBER}$")
    (blind,) = numbers(text, rf"hardly tells mu: .* s, {NUMBER} to [\d.]+ s")

    assert max(numbers(text, rf"q within {NUMBER} of")) < 1e-12
    assert max(in_time) < 0.001 < 100 * max(in_time) < min(late)
    assert printed == pytest.approx(raw, rel=0.02)
    assert numbers(text, rf"torque in time: rms error {NUMBER} rad")[0] < 1e-4
    assert 2.2 < blind < 4.3
    pictures = sorted(path.name for path in (tmp_path / "pictures").iterdir())
    assert pictures == [f"figure_{n}.png" for n in ("3_4", "3_6", "3_7", "3_8", "3_9", "5_9")]


def test_thesis_table_beyond_five_zones(tmp_path: Path) -> None:
    text = printed_by("thesis_table.py", tmp_path, *NOWHERE, "nested.png", leaves="nested.png")
    table = rows(text, rf"{NUMBER}%")

    assert "no published simulations" in text
    assert set(table) == {"0.5", "1", "1.8"}
    for worst_root, rms_root, worst_ekf, _, worst_mhe, _ in table.values():
        assert min(worst_root, rms_root) > 10
        assert max(worst_ekf, worst_mhe) <= 1


def test_thesis_table_on_the_published_simulations(tmp_path: Path, simulation_dir: Path) -> None:
    text = printed_by("thesis_table.py", tmp_path, "--data", str(simulation_dir))
    table = rows(text.split("more than five zones")[0], NUMBER)

    assert set(table) == set(PUBLISHED)
    for mu, (author, late, in_time, *filters, default) in table.items():
        assert author == pytest.approx(PUBLISHED[mu], rel=0.06)
        assert in_time < 1.5 * author < late
        assert max(filters) <= 0.002 < default


def test_thesis_networks(tmp_path: Path) -> None:
    pytest.importorskip("sklearn", reason="networks need scikit-learn: pip install -e '.[networks]'")
    text = printed_by("thesis_networks.py", tmp_path, *NOWHERE, "--seeds", "1", "n.png", leaves="n.png")
    in_time, late = text.split("torque late")
    tables = [
        {name: tuple(map(float, cells)) for name, *cells in re.findall(
            rf"^\| ([a-zA-Z ]+) \| {NUMBER} \| {NUMBER} \|$", part, flags=re.MULTILINE
        )}
        for part in (in_time, late)
    ]  # fmt: skip

    for table in tables:
        assert set(table) == {
            "mean of the labels", "neural network", "root and network", "root", "EKF",
        }  # fmt: skip
        assert table["mean of the labels"] == (0.15, 0.15)
        # Two labels do not teach what lies between them: the guess does better.
        assert min(table["neural network"]) > 0.15
        assert table["root"][1] > 0.5
        assert max(table["EKF"]) < 0.001
    # What is right without the network stays so, and what it never saw fail it does not mend.
    assert tables[0]["root and network"][0] < 0.01
    assert tables[0]["root and network"][1] > 0.5
    assert tables[1]["root and network"][1] < 0.5 * tables[1]["root"][1]


@pytest.mark.parametrize("mesh", [8, 24])
def test_thesis_sensitivity(tmp_path: Path, mesh: int) -> None:
    pytest.importorskip("sklearn", reason="networks need scikit-learn: pip install -e '.[networks]'")
    text = printed_by("thesis_sensitivity.py", tmp_path, "--mesh", str(mesh), "s.png", leaves="s.png")
    shares = {
        name.strip(): [float(share) for share in re.findall(rf"{NUMBER}%", row)]
        for name, row in re.findall(r"^\| (.+?) \|(.*%.*)$", text, flags=re.MULTILINE)
    }
    alone = shares["EKF, one sample alone"]

    assert f"psi_max = 0.7128 rad; {mesh} x {mesh} points" in text
    assert shares["root"][1] < 10 < 99 < shares["root"][3]
    # It answers along the line and is right there, and leaves half of the mesh open.
    assert min(alone[2:]) > 85
    assert alone[0] < 60
    for kind in ("EKF", "MHE"):
        assert shares[f"{kind}, one false sample in a stream"] == [100] * 4
