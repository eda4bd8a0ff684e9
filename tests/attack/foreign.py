"""Compilers that fail, a cache of compiled models that two runs share, and what other versions kept."""

import random
import shutil
import signal
from collections.abc import Callable
from functools import partial
from hashlib import sha256
from pathlib import Path

from tests.attack.attack_class import one_by_one
from tests.attack.faults import attempt, ended_well, killed
from tests.attack.whole_runs import Sandbox

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


FAULTS: dict[str, Callable[[Sandbox, random.Random], str | None]] = {
    "run_no_compiler": has_no_compiler,
    "run_shared_cache": shares_a_cache,
    "run_foreign_trials": keeps_foreign_trials,
}
CLASSES = {name: one_by_one(partial(attempt, fault)) for name, fault in FAULTS.items()}
