import os
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from brushgrip.outputs.atomic import staged_directory, staged_file
from symbolic import InvalidInputError


def names(folder: Path = Path()) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def write(path: str | Path, text: str) -> None:
    with staged_file(path) as stage:
        stage.write_text(text, encoding="utf-8")


def write_files(folder: str | Path, *paths: str) -> None:
    with staged_directory(folder) as stage:
        for path in paths:
            (stage / path).parent.mkdir(exist_ok=True)
            (stage / path).write_text("new")


def test_what_is_not_finished_is_hidden() -> None:
    with staged_file("figure.png") as stage, staged_directory("out") as folder:
        hidden = {path.name for path in Path().iterdir()}
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
    (left,) = Path().iterdir()
    Path(".brushgrip-of-the-user").mkdir()
    with staged_file("one") as one, staged_directory("two") as two:
        assert not left.exists()
        one.write_text("1")
        (two / "file").write_text("2")

    assert names() == [".brushgrip-of-the-user", "one", "two", "two/file"]


@pytest.mark.parametrize(
    ("staged", "place", "fault"),
    [
        *(
            (staged_file, place, "cannot be written: ")
            for place in ("file/x", "file/far/x", "/proc/none/x")
        ),
        *((staged_directory, place, "cannot be written: ") for place in ("file/far/x", "/proc/none/x")),
        (staged_file, "folder", "is a folder, expected the name of a file"),
        (staged_directory, "file", "is not a folder"),
    ],
)
def test_what_cannot_be_written_shows_before_the_work(staged: Any, place: str, fault: str) -> None:
    Path("file").write_text("x")
    Path("folder").mkdir()
    with pytest.raises(InvalidInputError, match=f"^{place}: {fault}"), staged(place):
        pytest.fail("the work began")

    assert names() == ["file", "folder"]


def spoil(stage: Path, text: str) -> None:
    (stage / "report.html" if stage.is_dir() else stage).write_text(text, encoding="utf-8")
    raise KeyboardInterrupt


@pytest.mark.parametrize("text", ["half", "half \ud800"])
@pytest.mark.parametrize(
    ("staged", "final", "there"),
    [
        (staged_file, "out", ["out"]),
        (staged_directory, "new/out", []),
        (staged_directory, "new/out", ["new", "new/out"]),
    ],
)
def test_a_failure_leaves_what_was_there(staged: Any, final: str, there: list[str], text: str) -> None:
    for name in there:
        Path(name).write_text("old") if staged is staged_file else Path(name).mkdir()
    with pytest.raises((KeyboardInterrupt, UnicodeEncodeError)), staged(final) as stage:
        spoil(stage, text)

    assert names() == there
    assert staged is staged_directory or Path(final).read_text() == "old"


def test_a_file_is_written_and_replaced_in_folders_that_are_made() -> None:
    path = Path("new/folder/out.csv")
    write(path, "t,μ\n")
    write(str(path), "t,mu\n1,2\n")

    assert path.read_bytes() == b"t,mu\n1,2\n"
    assert names() == ["new", "new/folder", "new/folder/out.csv"]


def test_links_devices_and_permissions_are_as_for_any_new_file() -> None:
    Path("link").symlink_to("target")
    write("link", "x")
    Path("plain").write_text("x")
    write("/dev/null", "x")

    assert Path("link").is_symlink()
    assert Path("target").read_text() == "x"
    assert Path("target").stat().st_mode == Path("plain").stat().st_mode
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)


def test_a_new_folder_appears_whole() -> None:
    final = Path("some/where")
    with staged_directory(final) as stage:
        (stage / "report.html").write_text("2")
        assert not final.exists()

    assert names() == ["some", "some/where", "some/where/report.html"]
    assert os.access(final, os.R_OK | os.W_OK | os.X_OK)


def test_an_existing_folder_keeps_what_is_not_written() -> None:
    Path("figures").mkdir()
    for old in ("figures/old.png", "report.html"):
        Path(old).write_text("old")
    write_files(Path(), "figures/one.png", "report.html")

    assert names() == ["figures", "figures/old.png", "figures/one.png", "report.html"]
    assert Path("report.html").read_text() == "new"


def test_something_in_the_way_is_found_before_anything_moves() -> None:
    Path("report.html").mkdir()
    with pytest.raises(InvalidInputError, match=r"report\.html: is in the way; remove it"):
        write_files(Path(), "figure.png", "report.html")

    assert names() == ["report.html"]
