"""Faults that happen to whole runs; after each the same command comes to the same result."""

import os
import random
import signal
import tempfile
import time
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path

from tests.attack.attack_class import one_by_one
from tests.attack.whole_runs import Ended, Sandbox

ENDED_BY_FAULT = (0, 1, 2, 130)
"""Exit status of a run that was interrupted or met a fault and said so."""

DISK_LINES = 3
"""Of a run without room: that trials cannot be kept, where those before are, and the fault."""
SIGNALS = {
    "killed": "SIGKILL",
    "terminated": "SIGTERM",
    "interrupted": "SIGINT",
    "hung_up": "SIGHUP",
    "quit": "SIGQUIT",
}
"""What ends a run, by the name of the class."""


@cache
def undisturbed(quick: bool, kind: type[Sandbox] = Sandbox) -> tuple[bytes, float]:
    """The result of a run without fault, and how long it took [s]."""
    with tempfile.TemporaryDirectory() as folder:
        sandbox = kind(Path(folder), quick)
        start = time.monotonic()
        ended = sandbox.run()
        if ended.status or sandbox.left() or not sandbox.result():
            raise AssertionError(f"a run without fault: {ended}, left {sandbox.left()}")
        return sandbox.result(), time.monotonic() - start


def attempt(
    fault: Callable[[Sandbox, random.Random], str | None],
    number: int,
    quick: bool = False,
    kind: type[Sandbox] = Sandbox,
) -> str | None:
    """One fault and the same command again; a line on what went wrong."""
    expected, _ = undisturbed(quick, kind)
    with tempfile.TemporaryDirectory() as folder:
        sandbox = kind(Path(folder), quick)
        wrong = fault(sandbox, random.Random(number)) or sandbox.nobody_left()
        if wrong is None:
            again = sandbox.run()
            if again.status:
                wrong = f"the same command ended with {again.status}: {again.lines}"
            elif sandbox.result() != expected:
                wrong = "the same command has another result"
            else:
                wrong = sandbox.nobody_left() or (f"left {names}" if (names := sandbox.left()) else None)
        return f"{number}: {wrong}" if wrong else None


def ended_well(ended: Ended, statuses: tuple[int, ...] = ENDED_BY_FAULT, most: int = 2) -> str | None:
    """A line where a run did not end as it should, or said more than a note and an error."""
    if ended.status not in statuses:
        return f"ended with {ended.status}: {ended.lines[-3:]}"
    return f"{len(ended.lines)} lines: {ended.lines[-3:]}" if len(ended.lines) > most else None


def killed(by: signal.Signals, sandbox: Sandbox, chance: random.Random) -> str | None:
    """The signal at any instant, half of the time while Python imports; Ctrl-C to the whole group."""
    run = sandbox.start()
    sandbox.listens(run)
    longest = chance.choice((2.0, undisturbed(sandbox.quick, type(sandbox))[1]))
    time.sleep(chance.uniform(0, longest))
    if by == signal.SIGINT and run.poll() is None:
        os.killpg(run.pid, by)
    else:
        run.send_signal(by)
    ended = sandbox.finish(run)
    return None if by == signal.SIGKILL else ended_well(ended, (*ENDED_BY_FAULT, -by), most=1)


def loses_a_worker(sandbox: Sandbox, chance: random.Random) -> str | None:
    """One of the processes of the search is killed at any instant."""
    run = sandbox.start()
    end = time.monotonic() + chance.uniform(0.2, 0.9) * undisturbed(sandbox.quick, type(sandbox))[1]
    while time.monotonic() < end and run.poll() is None:
        time.sleep(0.05)
    for pid in sandbox.processes():
        if pid != run.pid and b"spawn_main" in _command(pid):
            os.kill(pid, signal.SIGKILL)
            break
    return ended_well(sandbox.finish(run), (0,), most=0)


def _command(pid: int) -> bytes:
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return b""


def files_are_small(sandbox: Sandbox, chance: random.Random) -> str | None:
    """No file may be longer than so many bytes: what is written is lost as on a full disk."""
    import resource  # Not on Windows, where this file is imported all the same.

    size = chance.choice((0, 100, 3000, 20_000, 100_000, 500_000))

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    ended = sandbox.run(before=limit)
    # With files of no byte at all, nothing can be said into one either.
    return ended_well(ended, (*ENDED_BY_FAULT, 120), most=DISK_LINES)


def keeps_damaged_trials(sandbox: Sandbox, chance: random.Random) -> str | None:
    """What an interrupted run kept is damaged."""
    wrong = killed(signal.SIGINT, sandbox, chance)
    for path in sorted(sandbox.folder.glob("work/.*/*.npz")):
        content = bytearray(path.read_bytes())
        for _ in range(3):
            content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        path.write_bytes(
            bytes(content) if chance.random() < 0.7 else bytes(content[: len(content) // 2])
        )
    return wrong


def two_at_once(sandbox: Sandbox, chance: random.Random) -> str | None:
    """Two of the same command at once, into one folder."""
    first = sandbox.start()
    time.sleep(chance.uniform(0, 0.5))
    second = sandbox.start()
    ends = [first.wait(), sandbox.finish(second).status]
    if ends != [0, 0]:
        return f"two at once ended with {ends}"
    expected, _ = undisturbed(sandbox.quick, type(sandbox))
    return None if sandbox.result() == expected else "two at once: another result"


def has_no_home(sandbox: Sandbox, chance: random.Random) -> str | None:
    """The cache folder cannot be made."""
    blocked = sandbox.folder / "home" / "file"
    blocked.touch()
    ended = sandbox.run({"HOME": str(blocked), "BRUSHGRIP_CACHE": str(blocked / "cache")})
    del chance
    return ended_well(ended, (0,), most=2)


FAULTS: dict[str, Callable[[Sandbox, random.Random], str | None]] = {
    **{
        f"run_{name}": partial(killed, getattr(signal, by))
        for name, by in SIGNALS.items()
        if hasattr(signal, by)
    },
    "run_loses_worker": loses_a_worker,
    "run_file_limit": files_are_small,
    "run_damaged_trials": keeps_damaged_trials,
    "run_two_at_once": two_at_once,
    "run_no_home": has_no_home,
}
CLASSES = {name: one_by_one(partial(attempt, fault)) for name, fault in FAULTS.items()}
