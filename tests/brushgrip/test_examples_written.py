from collections.abc import Callable
from pathlib import Path
from typing import Any

Run = Callable[..., Any]


def test_the_examples_are_written_to_a_new_folder(
    run: Run, tmp_path: Path, repository_root: Path
) -> None:
    out = tmp_path / "mine"
    outcome = run("demo", "--examples", out)
    scripts = {path.name for path in (repository_root / "examples").glob("*.py")}

    assert outcome.status == 0
    assert outcome.out.startswith(f"wrote {len(scripts)} examples to {out}; python ")
    assert {path.name for path in out.glob("*.py")} == scripts
    assert (out / "recordings" / "rig.toml").is_file()
    assert (out / "reference_rig" / "__init__.py").is_file()
    assert not list(out.rglob("__pycache__"))
    refused = run("demo", "--examples", out)
    assert refused.status == 2
    assert "is not empty" in refused.err
