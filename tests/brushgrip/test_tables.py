import json
import math

import numpy as np
import pytest

from brushgrip import console
from brushgrip.console import progress
from brushgrip.formatting import csv_text, json_text


def test_floats_round_trip() -> None:
    values = np.random.default_rng(1).normal(size=100)
    text = csv_text({"t": np.arange(100), "M_z": values})
    header, *rows = text.splitlines()

    assert header == "t,M_z"
    assert [float(row.split(",")[1]) for row in rows] == values.tolist()


def test_truth_values_are_digits() -> None:
    assert csv_text({"informed": np.array([True, False])}) == "informed\n1\n0\n"


def test_missing_values_in_csv() -> None:
    assert csv_text({"mu": np.array([np.nan, 1.0])}) == "mu\n\n1.0\n"


def test_json_is_strict() -> None:
    content = {"a": [math.nan, 1.5, {"b": math.inf}], "c": "μ", "d": (True, None, 3)}

    assert json.loads(json_text(content)) == {
        "a": [None, 1.5, {"b": None}],
        "c": "μ",
        "d": [True, None, 3],
    }


def test_progress_elsewhere_than_on_a_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    seconds = iter([0.0, 1.0, 9.9, 10.0, 12.0, 21.0])
    monkeypatch.setattr(console.time, "monotonic", lambda: next(seconds))
    with progress() as report:
        for done in range(5):
            report("trying", done, 5)

    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err == "trying: 2 of 5\ntrying: 4 of 5\n"


def test_progress_on_a_terminal(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setenv("TERM", "xterm")
    with progress() as report:
        report("trying [1]", 1, 2)

    captured = capsys.readouterr()
    assert captured.out == ""
    assert "trying [1]" in captured.err
