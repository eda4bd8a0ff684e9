"""Any encoding of the terminal, a full disk, a closed pipe."""

import io
import os
import sys
from pathlib import Path

import pytest

from brushgrip.outputs.console import say
from brushgrip.outputs.terminal import fault_of_output, spell_what_is_lacking

OURS = "μ = 1.20 ± 0.05 → 3·10⁻² N/m², “höhe” – ϑ … 重"


@pytest.mark.parametrize(
    ("encoding", "shown"),
    [
        ("ascii", 'mu = 1.20 +/- 0.05 -> 3*10^-2 N/m^2, "hohe" - theta ... \\u91cd'),
        ("cp1252", "mu = 1.20 ± 0.05 -> 3·10^-² N/m², “höhe” – theta … \\u91cd"),
        ("utf-8", OURS),
    ],
)
def test_a_sign_that_an_encoding_lacks_is_spelt(
    encoding: str, shown: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    stream = io.TextIOWrapper(io.BytesIO(), encoding=encoding)
    monkeypatch.setattr(sys, "stdout", stream)
    spell_what_is_lacking()
    print(OURS, end="", flush=True)

    assert stream.buffer.getvalue().decode(encoding) == shown  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["two\nlines", "\x1b[2J", "\udcff", "\u202eturned"])
def test_what_is_said_stays_on_its_line(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    say(f"wrote {name}.csv")
    out = capsys.readouterr().out

    assert out.count("\n") == 1
    assert out.removesuffix("\n").isprintable()


def test_a_full_disk_is_told_from_a_closed_pipe(monkeypatch: pytest.MonkeyPatch) -> None:
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        monkeypatch.setattr(sys, "stdout", full)
        print("result")
        assert fault_of_output() == "No space left on device"
    reading, writing = os.pipe()
    os.close(reading)
    with os.fdopen(writing, "w", encoding="utf-8") as closed:
        monkeypatch.setattr(sys, "stdout", closed)
        print("result")
        assert fault_of_output() == ""
    monkeypatch.undo()

    assert fault_of_output() is None
