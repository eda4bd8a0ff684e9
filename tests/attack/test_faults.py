"""The short form of the faults of whole runs."""

import os
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from tests.attack.batches import FAULTS as BATCHES
from tests.attack.batches import Batch
from tests.attack.disks import fault_of_disk, may_mount
from tests.attack.faults import FAULTS, attempt
from tests.attack.names import COMMANDS
from tests.attack.whole_runs import ROOT
from tests.attack.workplace import place_inputs

QUICK = (
    *("run_killed", "run_damaged_trials"),
    *("run_no_compiler", "run_shared_cache", "run_foreign_trials"),
)
"""The others take minutes more, and belong to `make attack`."""
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="finds processes in /proc"),
]


@pytest.mark.parametrize("name", QUICK)
def test_the_same_command_goes_on(name: str) -> None:
    assert attempt(FAULTS[name], 1, quick=True) is None


@pytest.mark.parametrize("name", ["batch_killed", "batch_no_scheduler"])
def test_the_same_batch_again(name: str) -> None:
    assert attempt(BATCHES[name], 1, kind=Batch) is None


@pytest.mark.skipif(not may_mount(), reason="only root may mount")
@pytest.mark.parametrize("read_only", [False, True])
def test_a_disk_that_takes_nothing(read_only: bool) -> None:
    assert attempt(partial(fault_of_disk, read_only), 1, quick=True) is None


@pytest.mark.parametrize("command", COMMANDS)
def test_a_limit_of_file_size(command: str, tmp_path: Path) -> None:
    """As by `ulimit -f`; Python lets a write beyond it fail in place of ending the process."""
    resource = pytest.importorskip("resource")
    place_inputs(tmp_path, "x.csv", "x.toml", "x.json")
    before = sorted(tmp_path.iterdir())
    words = [word.replace("{0}", "x") for word in COMMANDS[command]]
    ended = subprocess.run(
        [sys.executable, "-m", "brushgrip", *words],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(ROOT), "BRUSHGRIP_INTERPRET": "1"},
        capture_output=True, text=True, check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (200, 200)),
    )  # fmt: skip

    assert ended.returncode == 1
    assert ended.stderr == "brushgrip: cannot write: File too large\n"
    assert sorted(tmp_path.iterdir()) == before
