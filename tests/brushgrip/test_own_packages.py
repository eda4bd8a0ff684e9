from pathlib import Path

import pytest

from brushgrip.cli import own_packages
from brushgrip.cli.own_packages import BEGINNINGS, foreign_packages


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder where `symbolic` stands, and no `observers` is anywhere."""
    (tmp_path / "symbolic").mkdir()
    found = own_packages._origin
    places = {"symbolic": tmp_path / "symbolic" / "__init__.py", "observers": None}
    monkeypatch.setattr(own_packages, "_origin", lambda name: places.get(name, found(name)))
    return tmp_path


def test_ours_are_ours() -> None:
    assert foreign_packages() == ""


def test_a_package_elsewhere_is_not_ours(place: Path) -> None:
    (place / "symbolic" / "__init__.py").write_text(f"{BEGINNINGS['symbolic']}\nraise SystemExit\n")
    said = foreign_packages()

    assert f"'symbolic' in {place / 'symbolic'} is another distribution's" in said
    assert "'observers' is missing" in said
    assert "identification" not in said


def test_a_package_that_was_written_over_is_not_ours(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = place / "symbolic" / "__init__.py"
    monkeypatch.setattr(own_packages, "__file__", str(place / "brushgrip" / "cli" / "own_packages.py"))
    package.write_text('"""Something else."""\n')
    assert f"'symbolic' in {package.parent} is another" in foreign_packages()
    package.write_text(BEGINNINGS["symbolic"])
    assert "'symbolic'" not in foreign_packages()
