"""The examples that reproduce the source, held against what the source says of itself."""

import re
from pathlib import Path

import pytest

from tests.examples.test_examples import NUMBER, printed_by

PUBLISHED = {"0.5": 0.009, "1.8": 0.077}
"""RMSE of the author's estimate on his simulations, from 0.5 s on."""
NOWHERE = ("--data", "nowhere")


def numbers(text: str, pattern: str) -> list[float]:
    return [float(found) for found in re.findall(pattern, text, flags=re.MULTILINE)]


def rows(text: str, cell: str) -> dict[str, list[float]]:
    """Numbers of a table's rows by their first cell."""
    found = re.findall(r"^\| ([\d.]+) \|(.*)\|$", text, flags=re.MULTILINE)
    return {mu: [float(value) for value in re.findall(cell, row)] for mu, row in found}


def test_source_profile(tmp_path: Path) -> None:
    text = printed_by("source_profile.py", tmp_path)
    peaks = re.findall(rf"mu = 1: angle to {NUMBER} rad, torque to {NUMBER} N m", text)
    (ours, theirs) = [tuple(map(float, peak)) for peak in peaks]

    assert ours == pytest.approx(theirs, rel=5e-4)
    assert text.count("at most 5 zones") == text.count("at most 11 zones") == 3


def test_source_profile_is_the_published_one(tmp_path: Path, simulation_dir: Path) -> None:
    text = printed_by("source_profile.py", tmp_path, str(simulation_dir))
    off = numbers(text, rf"angle within {NUMBER}% of the published range$")

    assert len(off) == 2
    assert max(off) < 1


def test_source_analytic(tmp_path: Path) -> None:
    text = printed_by("source_analytic.py", tmp_path, "pictures", leaves="pictures")
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


def test_source_table_beyond_five_zones(tmp_path: Path) -> None:
    text = printed_by("source_table.py", tmp_path, *NOWHERE, "nested.png", leaves="nested.png")
    table = rows(text, rf"{NUMBER}%")

    assert "no published simulations" in text
    assert set(table) == {"0.5", "1", "1.8"}
    for worst_root, rms_root, worst_ekf, _, worst_mhe, _ in table.values():
        assert min(worst_root, rms_root) > 10
        assert max(worst_ekf, worst_mhe) <= 1
    assert (tmp_path / "nested.png").read_bytes().startswith(b"\x89PNG")


def test_source_table_on_the_published_simulations(tmp_path: Path, simulation_dir: Path) -> None:
    text = printed_by("source_table.py", tmp_path, "--data", str(simulation_dir))
    table = rows(text.split("more than five zones")[0], NUMBER)

    assert set(table) == set(PUBLISHED)
    for mu, (author, late, in_time, *filters) in table.items():
        assert author == pytest.approx(PUBLISHED[mu], rel=0.06)
        assert in_time < 1.5 * author < late
        assert max(filters) <= 0.002
