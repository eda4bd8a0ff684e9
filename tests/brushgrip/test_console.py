import re

import pytest

from brushgrip.outputs import console
from brushgrip.outputs.console import progress


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
    assert captured.err == (
        "trying: 2 of 5, 10 s so far, about 14 s left in this step\n"
        "trying: 4 of 5, 21 s so far, about 5 s left in this step\n"
    )


def test_bar_and_count_stay_at_80_columns(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "80")
    with progress() as report:
        report("trying [1] on top of frictional_creep, carcass_torsion, asymmetric_friction", 7, 11)

    captured = capsys.readouterr()
    assert captured.out == ""
    shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", captured.err)
    line = next(line for line in re.split(r"[\r\n]", shown) if "7/11" in line)
    assert "━━━" in line
    assert line.startswith("trying [1] on top of")
    assert len(line) <= 80
