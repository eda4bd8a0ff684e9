import os
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from brushgrip.outputs.atomic import staged_directory, staged_file
from symbolic import InvalidInputError


def names(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def fail_after(path: Path, text: str = "half") -> None:
    path.write_text(text, encoding="utf-8")
    raise KeyboardInterrupt


def write(path: str | Path, text: str) -> None:
    with staged_file(path) as stage:
        stage.write_text(text, encoding="utf-8")


def test_what_is_not_finished_is_hidden(tmp_path: Path) -> None:
    with staged_file(tmp_path / "figure.png") as stage, staged_directory(tmp_path / "out") as folder:
        hidden = {path.name for path in tmp_path.iterdir()}
        assert {stage.parent.name, folder.parent.name} == hidden
        assert all(name.startswith(".brushgrip-") for name in hidden)
        assert stage.suffix == ".png", "for those who look at it"
        stage.write_text("new")


@pytest.mark.long
def test_what_a_killed_process_left_goes_with_the_next(tmp_path: Path, repository_root: Path) -> None:
    code = (
        "import os, sys; from pathlib import Path\n"
        "from brushgrip.outputs.atomic import staged_directory\n"
        "with staged_directory(Path(sys.argv[1]) / 'out') as stage:\n"
        "    (stage / 'report.html').write_text('half'); os.kill(os.getpid(), 9)"
    )
    subprocess.run([sys.executable, "-c", code, str(tmp_path)], cwd=repository_root)
    (left,) = tmp_path.iterdir()
    (tmp_path / ".brushgrip-of-the-user").mkdir()
    with staged_file(tmp_path / "one") as one, staged_directory(tmp_path / "two") as two:
        assert not left.exists()
        one.write_text("1")
        (two / "file").write_text("2")

    assert names(tmp_path) == [".brushgrip-of-the-user", "one", "two", "two/file"]


@pytest.mark.parametrize("staged", [staged_file, staged_directory])
@pytest.mark.parametrize("place", ["file/below", "file/far/below", "/proc/none/x"])
def test_unwritable_shows_before_the_work(tmp_path: Path, staged: Any, place: str) -> None:
    (tmp_path / "file").write_text("x")
    path = tmp_path / place
    with pytest.raises(InvalidInputError) as caught, staged(path):
        pytest.fail("the work began")

    assert str(caught.value).startswith(f"{path}: cannot be written: ")
    assert names(tmp_path) == ["file"]


class TestStagedFile:
    def test_writes_and_replaces_and_makes_folders(self, tmp_path: Path) -> None:
        path = tmp_path / "new" / "folder" / "out.csv"
        write(path, "t,μ\n")
        write(str(path), "t,mu\n1,2\n")

        assert path.read_bytes() == b"t,mu\n1,2\n"
        assert names(tmp_path) == ["new", "new/folder", "new/folder/out.csv"]

    def test_follows_a_link(self, tmp_path: Path) -> None:
        (tmp_path / "link").symlink_to(tmp_path / "target")
        write(tmp_path / "link", "x")

        assert (tmp_path / "link").is_symlink()
        assert (tmp_path / "target").read_text() == "x"

    def test_permissions_are_those_of_any_new_file(self, tmp_path: Path) -> None:
        write(tmp_path / "atomic", "x")
        (tmp_path / "plain").write_text("x")

        modes = {stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("atomic", "plain")}
        assert len(modes) == 1

    def test_a_device_stays_a_device(self) -> None:
        write("/dev/null", "x")

        assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)

    def test_folder_in_its_place(self, tmp_path: Path) -> None:
        with pytest.raises(InvalidInputError, match=r"is a folder, expected the name of a file$"):
            write(tmp_path, "x")

    @pytest.mark.parametrize("text", ["new", "new \ud800"])
    def test_failure_leaves_the_old(self, tmp_path: Path, text: str) -> None:
        path = tmp_path / "out"
        path.write_text("old")
        with pytest.raises((KeyboardInterrupt, UnicodeEncodeError)), staged_file(path) as stage:
            fail_after(stage, text)

        assert path.read_text() == "old"
        assert names(tmp_path) == ["out"]


class TestStagedDirectory:
    def test_new_folder_with_missing_parents(self, tmp_path: Path) -> None:
        final = tmp_path / "some" / "where"
        with staged_directory(final) as stage:
            (stage / "figures").mkdir()
            (stage / "figures" / "one.png").write_text("1")
            (stage / "report.html").write_text("2")
            assert not final.exists()

        assert names(final) == ["figures", "figures/one.png", "report.html"]
        assert names(tmp_path)[0] == "some"
        assert os.access(final, os.R_OK | os.W_OK | os.X_OK)

    def test_existing_folder_keeps_what_is_not_written(self, tmp_path: Path) -> None:
        (tmp_path / "figures").mkdir()
        (tmp_path / "figures" / "old.png").write_text("old")
        (tmp_path / "report.html").write_text("old")
        with staged_directory(tmp_path) as stage:
            (stage / "figures").mkdir()
            (stage / "figures" / "one.png").write_text("1")
            (stage / "report.html").write_text("new")

        assert names(tmp_path) == ["figures", "figures/old.png", "figures/one.png", "report.html"]
        assert (tmp_path / "report.html").read_text() == "new"

    @pytest.mark.parametrize("exists", [False, True])
    def test_failure_writes_nothing(self, tmp_path: Path, exists: bool) -> None:
        final = tmp_path / "new" / "out"
        if exists:
            final.mkdir(parents=True)
        before = names(tmp_path)
        with pytest.raises(KeyboardInterrupt), staged_directory(final) as stage:
            fail_after(stage / "report.html")

        assert names(tmp_path) == before

    def test_file_in_its_place(self, tmp_path: Path) -> None:
        (tmp_path / "out").write_text("x")
        with (
            pytest.raises(InvalidInputError, match=r"out: is not a folder$"),
            staged_directory(tmp_path / "out"),
        ):
            pytest.fail("the work began")

    def test_something_in_the_way_is_found_before_anything_moves(self, tmp_path: Path) -> None:
        (tmp_path / "report.html").mkdir()
        with (
            pytest.raises(InvalidInputError, match=r"report\.html: is in the way; remove it"),
            staged_directory(tmp_path) as stage,
        ):
            (stage / "report.html").write_text("x")

        assert names(tmp_path) == ["report.html"]
