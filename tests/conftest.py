"""Places and settings that the whole test suite shares.

Compiled models are cached in the user's cache directory (or in ``BRUSHGRIP_CACHE``). The tests
leave that as it is, so that neither the next run nor a parallel worker compiles a model again.

A test marked `long` is a campaign at full size; a smaller one beside it belongs to the quick tier. Of a
test with many cases the quick tier takes `MOST_CASES`, spread evenly; the others count as long.
"""

import inspect
import os
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from observers.compiled_step import compiled_step, compiled_stretch
from symbolic.compilation.compiled_function_cache import compiler
from tests.compile_once import OPTIMISATION, compile_unoptimised
from tests.interpreted import without_machine_code

# No test needs a display. Set before matplotlib is imported; commands that tests start inherit it.
os.environ["MPLBACKEND"] = "Agg"

if OPTIMISATION == "-O0":
    compile_unoptimised()

# The same examples in every run: a failure is a change of the code. No example has a time limit.
settings.register_profile(
    "project",
    derandomize=True,
    deadline=None,
    max_examples=25,
    database=None,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("project")

MOST_CASES = 5
"""Cases of one test function in the quick tier."""
ROOT = Path(__file__).resolve().parent.parent


NOT_ON_WINDOWS = re.compile(
    r"#!/bin/sh|/dev/|/proc|preexec_fn|symlink_to|\.chmod\(|import resource|command_lines|map\(attempt"
    r"|os\.(fork|mkfifo|umask|kill|geteuid)|signal\.SIG(ALRM|HUP|INT|KILL|TERM)|resource\."
)
"""What a test cannot do there; such a test is skipped."""


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leaves all but some cases of a wide test to the long tier, and on Windows what that lacks."""
    for item in items if sys.platform == "win32" else ():
        if isinstance(item, pytest.Function) and NOT_ON_WINDOWS.search(inspect.getsource(item.function)):
            item.add_marker(pytest.mark.skip(reason="calls what Windows lacks"))
    cases: dict[str, list[pytest.Item]] = {}
    for item in items:
        if item.get_closest_marker("long") is None:
            cases.setdefault(item.nodeid.partition("[")[0], []).append(item)
    for wide in cases.values():
        quick = {round(i * (len(wide) - 1) / (MOST_CASES - 1)) for i in range(MOST_CASES)}
        for at, item in enumerate(wide if len(wide) > MOST_CASES else ()):
            if at not in quick:
                item.add_marker("long")


@pytest.fixture(scope="module")
def interpreted() -> Iterator[None]:
    """Nothing is compiled in the modules that ask for this."""
    with pytest.MonkeyPatch.context() as patch:
        without_machine_code(patch)
        yield


@pytest.fixture(scope="module")
def optimised() -> Iterator[None]:
    """What the modules that ask for this compile runs so often that optimisation pays."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("CC", raising=False)
        for kept in (compiler, compiled_step, compiled_stretch):
            kept.cache_clear()
        yield
    compiler.cache_clear()


@pytest.fixture(scope="session")
def repository_root() -> Path:
    """The checkout that is under test."""
    return ROOT


@pytest.fixture(scope="session")
def measured_dir() -> Path:
    """The published measurements (``*.mat``); skips where they are not at hand."""
    return _directory_with("*.mat", _measured_candidate())


@pytest.fixture(scope="session")
def simulation_dir() -> Path:
    """The published simulations (``sim_*.csv``), which stand beside the measurements."""
    return _directory_with("sim_*.csv", _measured_candidate().parent / "thesis_simulation")


def _measured_candidate() -> Path:
    configured = os.environ.get("BRUSHGRIP_DATA")
    return Path(configured).resolve() if configured else ROOT.parent / "shared" / "measured"


def _directory_with(pattern: str, directory: Path) -> Path:
    if not any(directory.glob(pattern)):
        pytest.skip(f"published data not at hand: no {pattern} in {directory} (set BRUSHGRIP_DATA)")
    return directory
