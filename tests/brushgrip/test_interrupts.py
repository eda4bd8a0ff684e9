"""A process that is told to end, at any instant: one status, no traceback, nothing left."""

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="sends signals")
# As in a terminal: a shell starts what is in the background deaf to Ctrl-C, nohup deaf to SIGHUP.
HEARS = (
    "import signal\n"
    "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
    "signal.signal(signal.SIGHUP, signal.SIG_DFL)\n"
)
Ended = Callable[[str], tuple[int, str, str]]
RUN = "from brushgrip.interrupts import run_process\n"


@pytest.fixture
def ended(repository_root: Path, tmp_path: Path) -> Ended:
    """Runs a program; returns exit status, standard output and standard error."""

    def run(code: str) -> tuple[int, str, str]:
        process = subprocess.run(
            [sys.executable, "-c", HEARS + code],
            cwd=tmp_path,
            env={"PYTHONPATH": f"{repository_root}:{tmp_path}", "PATH": ""},
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )
        return process.returncode, process.stdout, process.stderr

    return run


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_an_import_is_finished_first(ended: Ended, tmp_path: Path, name: str) -> None:
    (tmp_path / "long_one.py").write_text(
        f"import signal\nsignal.raise_signal(signal.{name})\nprint('whole')\n"
    )
    code = RUN + "run_process(lambda: __import__('long_one') and __import__('time').sleep(9))"

    assert ended(code) == (130, "whole\n", "")


def test_an_import_that_never_ends_is_broken_off(ended: Ended, tmp_path: Path) -> None:
    (tmp_path / "endless.py").write_text(
        "import signal, time\nfor _ in range(2): signal.raise_signal(signal.SIGINT)\ntime.sleep(99)\n"
    )
    code = RUN + "run_process(lambda: __import__('endless'))"

    assert ended(code) == (130, "", "")


def test_work_is_cleaned_up_at_once(ended: Ended) -> None:
    code = (
        "def work():\n"
        "    try:\n"
        "        signal.raise_signal(signal.SIGTERM)\n"
        "        print('never')\n"
        "    finally:\n"
        "        print('cleaned')\n"
    )

    assert ended(code + RUN + "run_process(lambda: work)") == (130, "cleaned\n", "")


def test_in_a_destructor_it_is_not_lost(ended: Ended) -> None:
    code = (
        "import time\n"
        "class Gone:\n"
        "    def __del__(self): signal.raise_signal(signal.SIGINT)\n"
        "def work():\n"
        "    Gone()\n"
        "    time.sleep(9)\n"
    )

    assert ended(code + RUN + "run_process(lambda: work)") == (130, "", "")


def test_what_is_over_is_not_interrupted(ended: Ended) -> None:
    code = (
        "import atexit, time\n"
        "def end():\n"
        "    signal.raise_signal(signal.SIGINT)\n"
        "    time.sleep(0.2)\n"
        "    print('the end')\n"
        "atexit.register(end)\n"
        "def work(): raise SystemExit(7)\n"
    )

    assert ended(code + RUN + "run_process(lambda: work)") == (7, "the end\n", "")


def test_who_is_deaf_stays_deaf(ended: Ended) -> None:
    code = (
        "for name in (signal.SIGINT, signal.SIGHUP): signal.signal(name, signal.SIG_IGN)\n"
        "def work():\n"
        "    for name in (signal.SIGINT, signal.SIGHUP): signal.raise_signal(name)\n"
        "    print('done')\n"
    )

    assert ended(code + RUN + "run_process(lambda: work)") == (0, "done\n", "")


INSTANTS = (7, 10, 30, 100, 200, 300, 500, 800, 1200, 1500)
"""Modules that have been imported when the signal comes; before the first few Python itself answers."""
AT_IMPORT = """
import os, sys
left = {count}
def look(event, _):
    global left
    if event == "import":
        left -= 1
        if left == -1:
            os.write(1, b"told")
            os.kill(os.getpid(), signal.SIGINT)
sys.addaudithook(look)
sys.argv = ["brushgrip", "estimate", "train_a.csv", "--rig", "rig.toml", "--observer", "root",
            "--out", "out.csv"]
from brushgrip.__main__ import main
main()
"""


@pytest.mark.parametrize(
    "count", [pytest.param(i, marks=() if i == 100 else pytest.mark.long) for i in INSTANTS]
)
def test_the_command_while_it_imports(
    ended: Ended, repository_root: Path, tmp_path: Path, count: int
) -> None:
    for name in ("train_a.csv", "rig.toml"):
        shutil.copy(repository_root / "examples" / "recordings" / name, tmp_path)
    status, out, err = ended(AT_IMPORT.format(count=count))

    assert (status, out, err) == (130, "told", "")
    assert {path.name for path in tmp_path.iterdir()} == {"rig.toml", "train_a.csv"}


def test_the_clock_stops_with_the_command(ended: Ended, tmp_path: Path) -> None:
    (tmp_path / "one.py").write_text(
        "signal = __import__('signal')\nsignal.raise_signal(signal.SIGINT)\n"
    )
    code = (
        "import atexit, time\n"
        "atexit.register(lambda: (signal.signal(signal.SIGALRM, signal.SIG_DFL), time.sleep(0.2)))\n"
        "def load():\n"
        "    def work():\n"
        "        import one\n"
        "        raise SystemExit(7)\n"
        "    return work\n"
    )

    assert ended(code + RUN + "run_process(load)")[0] == 7
