"""Change the code in one place at a time and see that the named tests notice.

    python tests/mutants/run.py [--jobs N] [PATTERN]

Every file tests/mutants/*.toml holds entries

    [[mutant]]
    file = "symbolic/exact_zone_patch.py"
    from = "text that occurs exactly once in the file"
    to = "text in its place"
    tests = ["tests/symbolic/test_exact_zone_patch.py"]

The tests run in copies of the checkout, first unchanged, then once for every change. Exit status 1 if
a change survives, if its text does not occur exactly once, or if its tests do not pass on the unchanged
code.
PATTERN, a regular expression, selects entries by their file or text.
"""

import argparse
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from queue import Queue

ROOT = Path(__file__).resolve().parents[2]
TIME_LIMIT = 600.0
"""A change that makes its tests run for so long is noticed [s]."""
TESTS_FAILED = 1
"""pytest's exit status where tests ran and some failed."""


@dataclass(frozen=True, kw_only=True)
class Mutant:
    """One change of the code, and the tests that have to notice it."""

    file: str
    before: str
    after: str
    tests: tuple[str, ...]

    @property
    def title(self) -> str:
        """File and the text that is changed, in one line."""
        return f"{self.file}: {' '.join(self.before.split())} -> {' '.join(self.after.split())}"

    def occurrences(self, root: Path) -> int:
        """How often the text stands in the file; 0 where there is no such file."""
        path = root / self.file
        return path.read_text("utf-8").count(self.before) if path.is_file() else 0


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What the tests said of a mutant."""

    mutant: Mutant
    verdict: str
    seconds: float
    output: str = ""


def read_mutants(folder: Path) -> list[Mutant]:
    """All entries of the folder's files, in order."""
    mutants = []
    for path in sorted(folder.glob("*.toml")):
        for entry in tomllib.loads(path.read_text("utf-8"))["mutant"]:
            if set(entry) != {"file", "from", "to", "tests"} or not entry["tests"]:
                sys.exit(f"{path.name}: an entry has file, from, to and tests, not {sorted(entry)}")
            mutants.append(
                Mutant(
                    file=entry["file"],
                    before=entry["from"],
                    after=entry["to"],
                    tests=tuple(entry["tests"]),
                )
            )
    return mutants


def copy_checkout(target: Path) -> Path:
    """Copy tracked files, and new ones that will be, without anything compiled."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    listing = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    for name in filter(None, listing.split("\0")):
        if (ROOT / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target / name)
    return target


def run_tests(checkout: Path, tests: Sequence[str]) -> tuple[int, str]:
    """Exit status of pytest and what it printed; bytecode is never written, so none can be stale."""
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *tests]
    try:
        result = subprocess.run(
            command,
            cwd=checkout,
            env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1", "PYTHONPATH": str(checkout)},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
            timeout=TIME_LIMIT,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return TESTS_FAILED, f"stopped after {TIME_LIMIT:g} s"
    finally:
        end_stragglers(checkout)
    return result.returncode, result.stdout


def end_stragglers(checkout: Path) -> None:
    """End what a change has left running: workers without a parent would keep a core for ever."""
    mark = f"PYTHONPATH={checkout}\0".encode()
    for environment in Path("/proc").glob("[0-9]*/environ"):
        with suppress(OSError):
            if mark in environment.read_bytes() + b"\0":
                os.kill(int(environment.parent.name), signal.SIGKILL)


def judge(mutant: Mutant, checkout: Path) -> Outcome:
    """Apply the change in a copy of the checkout, run its tests, undo it."""
    count, begin = mutant.occurrences(checkout), time.monotonic()
    if count != 1:
        return Outcome(mutant=mutant, verdict=f"occurs {count} times", seconds=0.0)
    path = checkout / mutant.file
    original = path.read_text("utf-8")
    path.write_text(original.replace(mutant.before, mutant.after), "utf-8")
    try:
        status, output = run_tests(checkout, mutant.tests)
    finally:
        path.write_text(original, "utf-8")
    verdict = {0: "survived", TESTS_FAILED: "noticed"}.get(status, f"pytest ended with {status}")
    return Outcome(mutant=mutant, verdict=verdict, seconds=time.monotonic() - begin, output=output)


def judge_all(mutants: Sequence[Mutant], checkouts: Sequence[Path]) -> Iterator[Outcome]:
    """Judge every mutant, as many at a time as there are checkouts; outcomes in the mutants' order."""
    free: Queue[Path] = Queue()
    for checkout in checkouts:
        free.put(checkout)

    def in_a_free_checkout(mutant: Mutant) -> Outcome:
        checkout = free.get()
        try:
            return judge(mutant, checkout)
        finally:
            free.put(checkout)

    with ThreadPoolExecutor(len(checkouts)) as pool:
        yield from pool.map(in_a_free_checkout, mutants)


def passes_unchanged(mutants: Sequence[Mutant], checkout: Path) -> bool:
    """Whether all tests that are named pass before anything is changed."""
    tests = sorted({test for mutant in mutants for test in mutant.tests})
    status, output = run_tests(checkout, tests)
    if status != 0:
        print(f"the tests do not pass on the unchanged code:\n{output}")
    return status == 0


def main() -> int:
    """Print a line for every mutant; 1 if one of them is not noticed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("pattern", nargs="?", default="")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--folder", type=Path, default=Path(__file__).parent, help=argparse.SUPPRESS)
    options = parser.parse_args()
    mutants = [m for m in read_mutants(options.folder) if re.search(options.pattern, m.title)]
    with tempfile.TemporaryDirectory() as scratch:
        folders = [Path(scratch) / f"checkout_{number}" for number in range(max(options.jobs, 1))]
        checkouts = [copy_checkout(folder) for folder in folders]
        if not mutants or not passes_unchanged(mutants, checkouts[0]):
            return 1
        bad = 0
        for outcome in judge_all(mutants, checkouts):
            print(f"{outcome.verdict:10} {outcome.seconds:5.0f} s  {outcome.mutant.title}", flush=True)
            if outcome.verdict != "noticed":
                bad += 1
                print("\n".join(f"    {line}" for line in outcome.output.splitlines()[-5:]))
    print(f"{len(mutants) - bad} of {len(mutants)} changes noticed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
