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
RUN = "from brushgrip.running.interrupts import run_command_and_exit\n"


@pytest.fixture
def ended(repository_root: Path, tmp_path: Path) -> Ended:
    """Runs a program; returns exit status, standard output and standard error."""

    def run(code: str) -> tuple[int, str, str]:
        paths = {"PYTHONPATH": f"{repository_root}:{tmp_path}", "PATH": ""}
        command, told = [sys.executable, "-c", HEARS + code], {"capture_output": True, "text": True}
        process = subprocess.run(command, cwd=tmp_path, env=paths, check=False, timeout=60, **told)
        return process.returncode, process.stdout, process.stderr

    return run


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_an_import_is_finished_first(ended: Ended, name: str) -> None:
    Path("long_one.py").write_text(
        f"import signal\nsignal.raise_signal(signal.{name})\nprint('whole')\n"
    )
    code = RUN + "run_command_and_exit(lambda: __import__('long_one') and __import__('time').sleep(9))"

    assert ended(code) == (130, "whole\n", "")


def test_an_import_that_never_ends_is_broken_off(ended: Ended) -> None:
    Path("endless.py").write_text(
        "import signal, time\nfor _ in range(2): signal.raise_signal(signal.SIGINT)\ntime.sleep(99)\n"
    )
    code = RUN + "run_command_and_exit(lambda: __import__('endless'))"

    assert ended(code) == (130, "", "")


PROGRAMS = {
    "work is cleaned up at once": (
        """
def work():
    try:
        signal.raise_signal(signal.SIGTERM)
        print('never')
    finally:
        print('cleaned')
""",
        (130, "cleaned\n", ""),
    ),
    "in a destructor it is not lost": (
        """
import time
class Gone:
    def __del__(self): signal.raise_signal(signal.SIGINT)
def work():
    Gone()
    time.sleep(9)
""",
        (130, "", ""),
    ),
    "what is over is not interrupted": (
        """
import atexit, time
def end():
    signal.raise_signal(signal.SIGINT)
    time.sleep(0.2)
    print('the end')
atexit.register(end)
def work(): raise SystemExit(7)
""",
        (7, "the end\n", ""),
    ),
    "who is deaf stays deaf": (
        """
for name in (signal.SIGINT, signal.SIGHUP): signal.signal(name, signal.SIG_IGN)
def work():
    for name in (signal.SIGINT, signal.SIGHUP): signal.raise_signal(name)
    print('done')
""",
        (0, "done\n", ""),
    ),
}


@pytest.mark.parametrize("what", PROGRAMS)
def test_a_signal_while_it_works(ended: Ended, what: str) -> None:
    code, result = PROGRAMS[what]
    assert ended(f"{code}\n{RUN}run_command_and_exit(lambda: work)") == result


INSTANTS = (7, 10, 30, 100, 200, 300, 500, 800, 1000, 1200)
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


def test_the_clock_stops_with_the_command(ended: Ended) -> None:
    Path("one.py").write_text("signal = __import__('signal')\nsignal.raise_signal(signal.SIGINT)\n")
    code = (
        "import atexit, time\n"
        "atexit.register(lambda: (signal.signal(signal.SIGALRM, signal.SIG_DFL), time.sleep(0.2)))\n"
        "def load():\n"
        "    def work():\n"
        "        import one\n"
        "        raise SystemExit(7)\n"
        "    return work\n"
    )

    assert ended(code + RUN + "run_command_and_exit(load)")[0] == 7


def test_nothing_is_collected_at_the_end(ended: Ended) -> None:
    code = "import atexit, gc\natexit.register(lambda: print(gc.get_freeze_count() > 0))\n"

    assert ended(code + RUN + "run_command_and_exit(lambda: lambda: None)") == (0, "True\n", "")
