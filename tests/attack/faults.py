"""Faults that happen to whole runs; after each the same command comes to the same result.

Compilers that fail, a cache that two runs share and what other versions kept are among them.
"""

import os
import random
import shutil
import signal
import tempfile
import time
from collections.abc import Callable
from functools import cache, partial
from hashlib import sha256
from pathlib import Path

from tests.attack.attack_class import one_by_one
from tests.attack.whole_runs import Ended, Sandbox

ENDED_BY_FAULT = (0, 1, 2, 130)
"""Exit status of a run that was interrupted or met a fault and said so."""

DISK_LINES = 3
"""Of a run without room: that trials cannot be kept, where those before are, and the fault."""
Fault = Callable[[Sandbox, random.Random], str | None]
"""What happens to a run; it returns a line on what went wrong."""
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


def attempt(fault: Fault, number: int, quick: bool = False, kind: type[Sandbox] = Sandbox) -> str | None:
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
                wrong = sandbox.nobody_left() or sandbox.nothing_left()
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
        kept = len(content) if chance.random() < 0.7 else len(content) // 2
        path.write_bytes(bytes(content[:kept]))
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


def has_no_home(sandbox: Sandbox, _: random.Random) -> str | None:
    """The cache folder cannot be made."""
    blocked = sandbox.folder / "home" / "file"
    blocked.touch()
    ended = sandbox.run({"HOME": str(blocked), "BRUSHGRIP_CACHE": str(blocked / "cache")})
    return ended_well(ended, (0,), most=2)


QUICK_COMPILER = '#!/bin/sh\nexec cc "$@" -O0\n'
"""The last level counts, and without optimisation a model takes a second."""
BAD_COMPILERS = {
    "none": None,
    "fails": "#!/bin/sh\nexit 1\n",
    "is killed": "#!/bin/sh\nkill -9 $$\n",
    "writes half": '#!/bin/sh\nwhile [ "$1" != -o ]; do shift; done\necho half > "$2"\n',
}
"""Scripts that stand in for cc, None for none at all."""


def compiler(sandbox: Sandbox, script: str | None) -> dict[str, str]:
    """Environment in which models are compiled by a script, with a cache of the sandbox."""
    path = sandbox.folder / "home" / "cc"
    if script is not None:
        path.write_text(script)
        path.chmod(0o755)
    return {"BRUSHGRIP_INTERPRET": "", "CC": str(path)}


def has_no_compiler(sandbox: Sandbox, chance: random.Random) -> str | None:
    """There is no compiler, or one that fails: the same result, interpreted."""
    name = chance.choice(sorted(BAD_COMPILERS))
    ended = sandbox.run(compiler(sandbox, BAD_COMPILERS[name]))
    if wrong := ended_well(ended, (0,), most=1):
        return f"a compiler that {name}: {wrong}"
    shutil.rmtree(sandbox.out)
    return None


def shares_a_cache(sandbox: Sandbox, chance: random.Random) -> str | None:
    """Two runs at once compile into one cache, one may be killed; then its libraries are foreign."""
    environment = compiler(sandbox, QUICK_COMPILER)
    first, second = sandbox.start(environment), sandbox.start(environment, out="other")
    if chance.random() < 0.3:
        sandbox.listens(first)
        first.send_signal(signal.SIGKILL)
        first.wait()
        first = sandbox.start(environment)
    ends = [first.wait(), sandbox.finish(second).status]
    if ends != [0, 0]:
        return f"two with one cache ended with {ends}"
    results = {sandbox.result(), sandbox.result("other")}
    cache = sandbox.folder / "home" / "cache"
    if odd := [p.name for p in cache.iterdir() if p.suffix != ".so"]:
        return f"in the cache: {odd}"
    make_foreign(sorted(cache.glob("*.so")), chance)
    wrong = ended_well(sandbox.run(environment), (0,), most=0)
    results.add(sandbox.result())
    for name in ("out", "other"):
        shutil.rmtree(sandbox.folder / "work" / name)
    return wrong or (f"{len(results)} results" if len(results) > 1 else None)


def make_foreign(libraries: list[Path], chance: random.Random) -> None:
    """Every other library is cut short, damaged or another one whose name claims its content."""
    contents = [library.read_bytes() for library in libraries]
    for library in libraries[::2]:
        content = bytearray(chance.choice(contents))
        kind = chance.randrange(4)
        if kind == 0:
            content[chance.randrange(len(content))] ^= 1
        if kind == 1:
            del content[chance.randrange(len(content)) :]
        library.unlink()
        if kind >= 2:
            digest = sha256(content).hexdigest()[:24]
            library = library.with_name(f"{library.stem.rpartition('_')[0]}_{digest}.so")
        library.write_bytes(content)
        library.chmod(0o700)


def keeps_foreign_trials(sandbox: Sandbox, chance: random.Random) -> str | None:
    """What an interrupted run kept has other names, and other files lie beside."""
    wrong = killed(signal.SIGTERM, sandbox, chance)
    for folder in sandbox.folder.glob("work/.*"):
        paths = sorted(folder.glob("*.npz"))
        contents = [path.read_bytes() for path in paths]
        for path, content in zip(paths, contents[1:] + contents[:1], strict=True):
            path.write_bytes(content)
        for name in ("0" * 32 + ".npz", "01234567.part", "notes.json"):
            (folder / name).write_bytes(chance.randbytes(100))
    return wrong


FAULTS: dict[str, Fault] = {
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
    "run_no_compiler": has_no_compiler,
    "run_shared_cache": shares_a_cache,
    "run_foreign_trials": keeps_foreign_trials,
}
CLASSES = {name: one_by_one(partial(attempt, fault)) for name, fault in FAULTS.items()}
