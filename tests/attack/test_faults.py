"""The short form of the faults of whole runs."""

from pathlib import Path

import pytest

from tests.attack.faults import FAULTS, attempt

QUICK = ("run_killed", "run_damaged_trials")
"""The others take minutes more, and belong to `make attack`."""
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="finds processes in /proc"),
]


@pytest.mark.parametrize("name", QUICK)
def test_the_same_command_goes_on(name: str) -> None:
    assert attempt(FAULTS[name], 1, quick=True) is None
