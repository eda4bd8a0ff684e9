"""Nothing that is read is run, and nothing that is fetched leaves its folder."""

import re
from pathlib import Path

from brushgrip.published.fetch import published_files

RUNS_WHAT_IT_READS = re.compile(
    r"\bpickle\.(load|Unpickler)|from pickle\b|\b(import|from) (marshal|shelve|joblib|dill)\b"
    r"|allow_pickle=True|\beval\(|\bexec\(|\bshell=True|\bos\.system\("
)
OWN_PROCESSES = "worker_processes.py"
"""It unpickles what its own processes send through pipes that nobody else holds."""
PACKAGES = ("symbolic", "observers", "identification", "brushgrip")


def test_nothing_that_is_read_is_unpickled_or_run(repository_root: Path) -> None:
    offenders = [
        f"{path.relative_to(repository_root)}: {found[0]}"
        for package in PACKAGES
        for path in (repository_root / package).rglob("*.py")
        if path.name != OWN_PROCESSES
        for found in RUNS_WHAT_IT_READS.finditer(path.read_text("utf-8"))
    ]

    assert offenders == []


def test_published_files_have_plain_names() -> None:
    registry = published_files("here").registry

    assert registry
    assert all(re.fullmatch(r"\w[\w.-]*\.(mat|csv)", name) for name in registry)
