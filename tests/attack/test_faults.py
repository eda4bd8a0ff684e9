"""The short form of the faults of whole runs."""

from functools import partial
from pathlib import Path

import pytest

from tests.attack.disks import fault_of_disk, may_mount
from tests.attack.faults import FAULTS, attempt
from tests.attack.foreign import FAULTS as FOREIGN

QUICK = ("run_killed", "run_damaged_trials")
"""The others take minutes more, and belong to `make attack`."""
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="finds processes in /proc"),
]


@pytest.mark.parametrize("name", QUICK)
def test_the_same_command_goes_on(name: str) -> None:
    assert attempt(FAULTS[name], 1, quick=True) is None


@pytest.mark.parametrize("name", FOREIGN)
def test_nothing_foreign_changes_the_result(name: str) -> None:
    assert attempt(FOREIGN[name], 1, quick=True) is None


@pytest.mark.skipif(not may_mount(), reason="only root may mount")
@pytest.mark.parametrize("read_only", [False, True])
def test_a_disk_that_takes_nothing(read_only: bool) -> None:
    assert attempt(partial(fault_of_disk, read_only), 1, quick=True) is None
