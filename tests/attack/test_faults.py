"""The short form of the faults of whole runs."""

from pathlib import Path

import pytest

from tests.attack.faults import FAULTS, attempt

pytestmark = pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="finds processes in /proc")
QUICK = ("run_killed",)


@pytest.mark.parametrize(
    "name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.long) for n in FAULTS]
)
def test_the_same_command_goes_on(name: str) -> None:
    assert attempt(FAULTS[name], 1, quick=True) is None
