"""Places and settings that the whole test suite shares.

Compiled models are cached in the user's cache directory (or in ``BRUSHGRIP_CACHE``). The tests
leave that as it is, so that neither the next run nor a parallel worker compiles a model again.

A test marked `long` is a campaign at full size; a smaller one beside it belongs to the quick tier.
"""

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

from tests.interpreted import without_machine_code

# No test needs a display. Set before matplotlib is imported; commands that tests start inherit it.
os.environ["MPLBACKEND"] = "Agg"

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

ROOT = Path(__file__).resolve().parent.parent


@pytest.fixture(scope="module")
def interpreted() -> Iterator[None]:
    """Nothing is compiled in the modules that ask for this."""
    with pytest.MonkeyPatch.context() as patch:
        without_machine_code(patch)
        yield


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
