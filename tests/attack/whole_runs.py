"""Whole runs on small recordings, each in a sandbox of its own: a search, or a batch of estimates.

A search is of three candidates, interpreted, with two processes. What a fault left is tested by the same
command given again: it ends with the result of a run without fault, to the last digit; nobody is left.
"""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SMALL_RUN = Path(__file__).with_name("small_run.py")
EVERY = 5
"""Of so many samples of the embedded recordings one is used."""
SEARCH = ("diagnose", "train_a.csv", "--holdout", "holdout_c.csv", "--rig", "rig.toml")
LONGEST = 600.0
"""No run takes longer [s]."""
FILES = ("diagnosis.json", "model.json")
"""Files that hold the result; pictures bear the time."""
MARK = "BRUSHGRIP_ATTACK"
"""Variable by which the processes of a run are found."""


@dataclass(frozen=True)
class Ended:
    """How a run ended: exit status (negative: signal, 999: it hung) and standard error."""

    status: int
    err: str

    @property
    def lines(self) -> list[str]:
        """Standard error without progress, which is no complaint."""
        progress = ("trying ", "fitting ", "correlating ", "looking ", "leaving ")
        progress += ("exchanging ", "estimating ")
        return [one for one in self.err.splitlines() if one and not one.startswith(progress)]


@dataclass(frozen=True)
class Sandbox:
    """A folder with recordings, in which results, caches and temporary files are written.

    Attributes:
        folder: that one.
        quick: one candidate and no report.
    """

    folder: Path
    quick: bool = False

    def __post_init__(self) -> None:
        """Write the recordings."""
        for name in ("work", "tmp", "home"):
            (self.folder / name).mkdir(parents=True, exist_ok=True)
        embedded = ROOT / "examples" / "recordings"
        for name in ("train_a", "holdout_c"):
            head, *rows = (embedded / f"{name}.csv").read_text().splitlines()
            every = rows[: 80 * EVERY : EVERY] if self.quick else rows[::EVERY]
            (self.folder / "work" / f"{name}.csv").write_text("\n".join([head, *every, ""]))
        (self.folder / "work" / "rig.toml").write_text((embedded / "rig.toml").read_text())

    @property
    def out(self) -> Path:
        """Where the results are."""
        return self.folder / "work" / "out"

    @property
    def words(self) -> tuple[str, ...]:
        """The command line but for --out and --jobs."""
        return SEARCH

    def start(
        self,
        environment: Mapping[str, str] | None = None,
        before: Callable[[], None] | None = None,
        out: str = "out",
        further: Sequence[str] = ("--jobs", "2"),
    ) -> subprocess.Popen[str]:
        """A run that has just begun, in a group of its own."""
        with (self.folder / "err").open("w") as log:
            command = [sys.executable, str(SMALL_RUN), *self.words, "--out", out, *further]
            place = {"cwd": self.folder / "work", "env": self._environment() | dict(environment or {})}
            streams = {"stdout": subprocess.DEVNULL, "stderr": log, "text": True}
            own = {"start_new_session": True, "preexec_fn": before}
            return subprocess.Popen(command, **place, **streams, **own)

    def listens(self, run: subprocess.Popen[str], seconds: float = 20.0) -> None:
        """Waits until the run catches SIGTERM, which Python itself does not, or has ended."""
        end = time.monotonic() + seconds
        while run.poll() is None and time.monotonic() < end:
            status = Path(f"/proc/{run.pid}/status").read_text()
            caught = int(status.partition("SigCgt:")[2].split()[0], 16)
            if caught >> (signal.SIGTERM - 1) & 1:
                return
            time.sleep(0.002)

    def finish(self, run: subprocess.Popen[str], seconds: float = LONGEST) -> Ended:
        """Waits for the end of a run; one that does not end is killed and has the status 999."""
        try:
            status = run.wait(seconds)
        except subprocess.TimeoutExpired:
            os.killpg(run.pid, signal.SIGKILL)
            run.wait()
            status = 999
        return Ended(status, (self.folder / "err").read_text(errors="replace"))

    def run(
        self, environment: Mapping[str, str] | None = None, before: Callable[[], None] | None = None
    ) -> Ended:
        """A whole run."""
        return self.finish(self.start(environment, before))

    def result(self, out: str = "out") -> bytes:
        """What was written, b"" where nothing was."""
        paths = [self.folder / "work" / out / name for name in FILES]
        return b"".join(_without_provenance(path) for path in paths if path.is_file())

    def processes(self) -> list[int]:
        """Processes of the runs in this sandbox that are alive."""
        own = f"{MARK}={self.folder}\0".encode()
        alive = []
        for place in Path("/proc").iterdir():
            try:
                if place.name.isdigit() and own in (place / "environ").read_bytes() + b"\0":
                    alive.append(int(place.name))
            except OSError:
                continue
        return alive

    def left(self) -> list[str]:
        """What should not be there when a run has ended and the next one was successful."""
        allowed = {"out", "rig.toml", "train_a.csv", "holdout_c.csv"}
        work = [path.name for path in (self.folder / "work").iterdir() if path.name not in allowed]
        hidden = [path.name for path in self.out.glob(".*")]
        temporary = [path.name for path in (self.folder / "tmp").iterdir()]
        return sorted(work + hidden + temporary)

    def nothing_left(self) -> str | None:
        """A line where something is."""
        return f"left {names}" if (names := self.left()) else None

    def nobody_left(self, seconds: float = 15.0) -> str | None:
        """Waits for the processes to be gone; a line where they stay."""
        end = time.monotonic() + seconds
        while alive := self.processes():
            if time.monotonic() > end:
                return f"{len(alive)} processes still alive after {seconds:g} s"
            time.sleep(0.1)
        return None

    def _environment(self) -> dict[str, str]:
        return {
            **os.environ,
            "BRUSHGRIP_INTERPRET": "1",
            "BRUSHGRIP_CACHE": str(self.folder / "home" / "cache"),
            "HOME": str(self.folder / "home"),
            "TMPDIR": str(self.folder / "tmp"),
            "MPLCONFIGDIR": str(self.folder / "home" / "matplotlib"),
            "BRUSHGRIP_SMALL_QUICK": "1" if self.quick else "",
            "MPLBACKEND": "Agg",
            MARK: str(self.folder),
        }


def _without_provenance(path: Path) -> bytes:
    """The content of a JSON file but for when, where and by what command it was made."""
    content = json.loads(path.read_bytes())
    content.pop("provenance", None)
    return json.dumps(content).encode()
