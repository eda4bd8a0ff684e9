"""The job of the page on clusters runs, with two workers here in place of SLURM's."""

import os
import re
import shutil
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = {
    "srun": 'shift\n"$@" &\n"$@" &\nwait\n',
    # Both take a while, as schedulers do.
    "dask": '[ "$1" = worker ] && exit\nsleep 0.3\necho \'{"address": "tcp://now:1"}\' > "$3"\n',
    "brushgrip": 'echo "${@: -1}" > scheduler.txt\n',
}
"""Stands for commands, in bash."""


def run_job(folder: Path, *stand_ins: str) -> None:
    """Run the job of the page in a folder, as job 7 of SLURM; what it leaves running ends with it."""
    page = (ROOT / "docs" / "start" / "cluster.md").read_text(encoding="utf-8")
    (job,) = re.findall(r"^```bash\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    (folder / "bin").mkdir()
    for name in stand_ins:
        command = folder / "bin" / name
        command.write_text(f"#!/bin/bash\n{COMMANDS[name]}")
        command.chmod(0o755)
    path = os.pathsep.join([str(folder / "bin"), str(Path(sys.executable).parent), os.environ["PATH"]])
    own = {"PATH": path, "HOME": str(folder), "SLURM_JOB_ID": "7", "BRUSHGRIP_INTERPRET": "1"}
    with subprocess.Popen(
        ["bash", "-ec", job], cwd=folder, env={**os.environ, **own}, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    ) as process:  # fmt: skip
        try:
            assert process.wait(timeout=120) == 0
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash at hand")
def test_a_job_takes_its_own_scheduler_and_none_of_an_earlier_job(tmp_path: Path) -> None:
    for left in ("scheduler.json", "scheduler_6.json"):
        (tmp_path / left).write_text('{"address": "tcp://earlier:1"}')
    run_job(tmp_path, *COMMANDS)

    assert (tmp_path / "scheduler.txt").read_text() == "tcp://now:1\n"


@pytest.mark.long
def test_the_job_estimates_the_friction_of_every_recording(tmp_path: Path) -> None:
    pytest.importorskip("distributed", reason="needs brushgrip[cluster]")
    (tmp_path / "recordings").mkdir()
    shutil.copy(ROOT / "examples" / "recordings" / "rig.toml", tmp_path)
    for name in ("a", "b", "c"):
        source = ROOT / "examples" / "recordings" / "train_a.csv"
        shutil.copy(source, tmp_path / "recordings" / f"{name}.csv")
    run_job(tmp_path, "srun")

    lines = (tmp_path / "table.csv").read_text(encoding="utf-8").splitlines()
    assert [line.partition(",")[0] for line in lines] == ["recording", "a", "b", "c"]
    assert len({line.partition(",")[2] for line in lines[1:]}) == 1
