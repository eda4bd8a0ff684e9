"""Damaged files of every format: guided by coverage with atheris, or as hypothesis draws them."""

import importlib.util
import re
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st

from tests.attack.attack_class import Effort, Tried, examples
from tests.attack.targets import TARGETS, Target, broken, seeds
from tests.attack.workplace import sweep

FINDINGS = Path("attack_findings")
"""Inputs that broke something are left here."""
SLOWEST = 10
"""An input that takes longer is a failure [s]."""
LARGEST_MEMORY = 700
"""A process that takes more is a failure [MB]."""
LARGEST_INPUT = 1 << 14
"""Of the fuzzer [bytes]."""
FUZZER = "tests.attack.fuzz_process"
NO_ATHERIS = "(as hypothesis draws them: atheris is not installed, pip install atheris)"


WORDS = (
    *(b"", b"nan", b"inf", b"-1", b"0", b"1e999", b"1e-323", b"\n", b"\r", b",", b'"', b"#", b"=", b"."),
    *(b"\0", b"\xff", b"\x1b[2J", b"[[", b"{", b"\xef\xbb\xbf", b"\x7f" * 4, b"\xff" * 8, b"9" * 5000),
)
"""What parsers stumble over."""


@st.composite
def damaged(draw: st.DrawFn, seeds: Sequence[bytes]) -> bytes:
    """A whole file with a few changes: bytes, words, a piece cut out or doubled, or two files in one."""
    content = bytearray(draw(st.sampled_from(seeds)))
    for _ in range(draw(st.integers(1, 4))):
        start = draw(st.integers(0, len(content)))
        stop = min(len(content), start + draw(st.sampled_from((0, 1, 2, 4, 8, 64, len(content)))))
        piece = bytes(content[start:stop])
        other = draw(st.sampled_from(seeds))
        new = st.one_of(
            st.binary(max_size=8),
            st.sampled_from(WORDS),
            st.sampled_from((piece * 2, piece[::-1], other[start:])),
        )
        content[start:stop] = draw(new)
    return bytes(content)


def attack_files(name: str, effort: Effort) -> Iterator[Tried]:
    """Damage files of one format."""
    if importlib.util.find_spec("atheris") is None:
        yield from drawn(name, effort)
        return
    with tempfile.TemporaryDirectory() as folder:
        yield from guided(name, effort, Path(folder))


def guided(name: str, effort: Effort, folder: Path) -> Iterator[Tried]:
    """Files that reach new code are changed further; in a process of its own, as it may die."""
    corpus, findings = folder / "corpus", folder / "findings"
    corpus.mkdir()
    findings.mkdir()
    for number, content in enumerate([*seeds(name), *(path.read_bytes() for path in broken(name))]):
        (corpus / f"{number}").write_bytes(content)
    options = {
        "artifact_prefix": f"{findings}/",
        "max_len": LARGEST_INPUT,
        "print_final_stats": 1,
        "rss_limit_mb": LARGEST_MEMORY,
        "seed": effort.seed + 1,
        "timeout": SLOWEST,
    }
    if effort.seconds < 1e9:
        options["max_total_time"] = max(1, round(effort.seconds))
    if effort.inputs < sys.maxsize:
        options["runs"] = effort.inputs
    arguments = [f"-{option}={value}" for option, value in options.items()]
    process = subprocess.run(
        [sys.executable, "-m", FUZZER, name, str(findings), str(corpus), *arguments],
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    sweep()
    counted = re.search(r"number_of_executed_units: (\d+)", process.stderr)
    yield Tried(int(counted[1]) if counted else 0)
    found = sorted(findings.iterdir())
    yield from (Tried(0, _kept(name, path.name, path.read_bytes())) for path in found)
    if process.returncode and not found:
        yield Tried(0, f"ended with {process.returncode}: {process.stderr[-200:]}")


def drawn(name: str, effort: Effort) -> Iterator[Tried]:
    """Files with a few changes, without guidance."""

    @given(damaged(seeds(name)))
    def attempt(content: bytes) -> None:
        if place := broken_by(TARGETS[name], content):
            raise AssertionError(_kept(name, place, content))

    yield from (tried._replace(note=NO_ATHERIS) for tried in examples(attempt)(effort))


def broken_by(target: Target, content: bytes) -> str | None:
    """What an input broke, by exception, file and line; None where the target held."""
    try:
        target(content)
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return f"{type(error).__name__}-{Path(place.filename).stem}-{place.lineno}"
    return None


def _kept(name: str, place: str, content: bytes) -> str:
    """What broke, and the file in which the first input that broke it is kept."""
    path = FINDINGS / name / place
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists():
        path.write_bytes(content)
    return f"{place}, kept in {path}"


CLASSES = {name: partial(attack_files, name) for name in TARGETS}
