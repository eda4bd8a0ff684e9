"""Workflow files of a public host: they parse, and name what there is; no run there is claimed."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

yaml = pytest.importorskip("yaml", reason="reads the workflow files")
NAMES = ("tests", "release")


def workflow(root: Path, name: str) -> dict[str, Any]:
    return yaml.safe_load((root / ".github" / "workflows" / f"{name}.yml").read_text("utf-8"))


def lines_of(workflow: dict[str, Any]) -> list[str]:
    steps = [step for job in workflow["jobs"].values() for step in job["steps"]]
    return [line for step in steps for line in step.get("run", "").splitlines()]


@pytest.mark.parametrize("name", NAMES)
def test_they_name_what_there_is(name: str, repository_root: Path) -> None:
    lines = lines_of(workflow(repository_root, name))
    extras = tomllib.loads((repository_root / "pyproject.toml").read_text("utf-8"))["project"]
    extras = extras["optional-dependencies"]
    makefile = (repository_root / "Makefile").read_text("utf-8")

    assert lines
    for line in lines:
        for group in re.findall(r"\.\[([\w,]+)\]", line):
            assert set(group.split(",")) <= set(extras)
        for target in re.findall(r"^make (\w+)", line):
            assert re.search(rf"^{target}:", makefile, flags=re.MULTILINE)
        for path in re.findall(r"\btests/[\w/.]+", line):
            assert (repository_root / path).exists()


def test_windows_runs_the_tests_that_make_runs(repository_root: Path) -> None:
    steps = workflow(repository_root, "tests")["jobs"]["test"]["steps"]
    (windows,) = (step["run"] for step in steps if step.get("if") == "runner.os == 'Windows'")
    recipe = (repository_root / "Makefile").read_text("utf-8").partition("\ntest: ")[2]

    assert re.search(r'-m "[^"]+"', recipe)[0] in windows  # type: ignore[index]
    assert '-e ".[test]"' in windows


def test_only_the_job_that_publishes_may_identify_itself(repository_root: Path) -> None:
    release = workflow(repository_root, "release")
    trusted = {name for name, job in release["jobs"].items() if "id-token" in job.get("permissions", {})}

    assert trusted == {"publish"}
    assert release["permissions"] == {"contents": "read"}
    assert set(release["jobs"]["publish"]["needs"]) == {"build", "try"}
    assert any("twine check --strict dist/*" in line for line in lines_of(release))
    assert "secrets" not in str(release)
