import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from brushgrip.inputs.command_inputs import gather_inputs
from brushgrip.inputs.recording_files import (
    download_folder,
    locate_recording,
    refuse_overwriting,
    unique_labels,
)
from symbolic import InvalidInputError
from tests.brushgrip.helpers import Write
from tests.refusal import refused

Columns = dict[str, np.ndarray]


class TestLocate:
    @pytest.mark.parametrize(
        ("there", "name", "found"),
        [
            (["run.csv"], "run.csv", "run.csv"),
            (["run.csv"], "run", "run.csv"),
            (["run.1.csv"], "run.1", "run.1.csv"),
            (["run.mat", "run.csv"], "run", "run.mat"),
        ],
    )
    def test_suffix_may_be_left_out(
        self, tmp_path: Path, there: list[str], name: str, found: str
    ) -> None:
        for file in there:
            (tmp_path / file).touch()

        assert locate_recording(str(tmp_path / name)) == tmp_path / found

    def test_order_of_places(self, monkeypatch: pytest.MonkeyPatch) -> None:
        folders = [Path("here").resolve(), Path("data").resolve(), download_folder()]
        for folder in folders:
            folder.mkdir(parents=True)
            (folder / "fem1.mat").touch()
        monkeypatch.chdir(folders[0])
        monkeypatch.setenv("BRUSHGRIP_DATA", str(folders[1]))

        found = []
        for folder in folders:
            found.append(locate_recording("fem1").resolve())
            assert locate_recording("fem1.mat").resolve() == found[-1]
            (folder / "fem1.mat").unlink()

        assert found == [folder / "fem1.mat" for folder in folders]

    def test_a_folder_of_the_same_name_is_passed_over(self) -> None:
        Path("fem1").mkdir()
        with pytest.raises(InvalidInputError, match="fem1: is a folder"):
            locate_recording("fem1")
        Path("fem1.csv").touch()

        assert locate_recording("fem1") == Path("fem1.csv")

    def test_says_where_it_looked(self, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
        monkeypatch.setenv("BRUSHGRIP_DATA", "data")
        message = refused(locate_recording, "fem9")
        for place in ("here", " data", str(download_folder()), "brushgrip fetch"):
            assert place in message
        looked = f"looked for fem9, fem9.mat, fem9.csv and fem9.txt in {tmp_path}"
        assert refused(locate_recording, str(tmp_path / "fem9")).endswith(looked)


@pytest.mark.parametrize(
    ("paths", "labels"),
    [
        (["a.csv", "b.csv"], ["a", "b"]),
        # Folders tell equal names apart, as many as it takes; then suffixes.
        (["one/run.csv", "two/run.csv", "two/else.csv"], ["one_run", "two_run", "else"]),
        (["one/x/run.csv", "two/x/run.csv"], ["one_x_run", "two_x_run"]),
        (["run.csv", "run.txt"], ["run_csv", "run_txt"]),
        # What no screen can show.
        (["a\nb.csv", "\x1b[2J.csv"], ["a b", r"\x1b[2J"]),
    ],
)
def test_every_recording_has_a_label_of_its_own(paths: list[str], labels: list[str]) -> None:
    assert unique_labels([Path("/") / path for path in paths]) == labels


@pytest.mark.parametrize("again", ["run.csv", "./run.csv", "run", "copy.csv", "link.csv"])
def test_a_recording_counts_once(write_csv: Write, rig: Path, again: str) -> None:
    path = write_csv("run.csv")
    shutil.copy(path, Path("copy.csv"))
    Path("link.csv").symlink_to(path)
    with pytest.raises(InvalidInputError, match=r"is the same recording as run\.csv"):
        gather_inputs(["run.csv", again], rig=rig).recordings()


@pytest.mark.parametrize("kept", [slice(0, 59), slice(1, 60), slice(0, 60, 2), slice(20, 45)])
def test_a_part_of_a_recording_is_the_same(
    write_csv: Write, rig: Path, table: dict[str, np.ndarray], kept: slice
) -> None:
    whole = write_csv("whole.csv")
    part = write_csv("part.csv", {name: values[kept] for name, values in table.items()})
    with pytest.raises(InvalidInputError, match=r"is the same recording as .*whole\.csv"):
        gather_inputs([str(whole), str(part)], rig=rig).recordings()


def test_two_runs_may_have_much_in_common(
    write_csv: Write, rig: Path, table: dict[str, np.ndarray]
) -> None:
    shared = np.arange(60) < 28
    one = write_csv("one.csv")
    other = write_csv("other.csv", {"M_z": np.where(shared, table["M_z"], table["M_z"] + 0.5)})

    inputs = gather_inputs([str(one), str(other)], rig=rig)
    assert [recording.name for recording in inputs.recordings()] == ["one", "other"]


def run_of(
    seed: int, noise: float = 0.07, period: float = 0.01, start: float = 0.0, hum: float = 0.0
) -> Columns:
    """A robot's run, always along the same path; its noise is its own."""
    t = np.arange(start, 10.0, period)
    psi = 0.3 * np.sin(1.2 * t) + 0.05 * np.sin(4 * t)
    M_z = -8 * np.tanh(8 * psi + 0.3 * np.cos(1.2 * t)) + hum * np.sin(2 * np.pi * 49.7 * t)
    return {
        "t": t, "psi": psi, "F_N": 400.0 + 0 * t,
        "M_z": M_z + noise * np.random.default_rng(seed).standard_normal(t.size),
    }  # fmt: skip


def rounded(run: Columns) -> Columns:
    return {name: np.array([float(f"{value:.4g}") for value in of]) for name, of in run.items()}


def resampled(run: Columns, period: float, start: float = 0.0) -> Columns:
    t = np.arange(start, run["t"][-1], period)
    return {name: np.interp(t, run["t"], values) for name, values in run.items()} | {"t": t}


COPIES: dict[str, Callable[[Columns], Columns]] = {
    "four digits": rounded,
    "degrees": lambda run: run | {"psi": np.radians(np.round(np.degrees(run["psi"]), 3))},
    "later": lambda run: rounded(run | {"t": run["t"] + 3.0}),
    "between samples": lambda run: resampled(run, 0.01, 0.005),
    "another rate": lambda run: resampled(run, 0.007),
    "half, from zero": lambda run: {n: v[400:] - v[400] * (n == "t") for n, v in rounded(run).items()},
    "gain": lambda run: run | {"M_z": 1.0001 * run["M_z"]},
}


@pytest.mark.parametrize("noise", [0.01, 0.07])
@pytest.mark.parametrize("copy", COPIES.values(), ids=COPIES)
def test_a_copy_is_known_however_it_was_written(
    write_csv: Write, rig: Path, copy: Callable[[Columns], Columns], noise: float
) -> None:
    run = run_of(1, noise)
    paths = [str(write_csv("run.csv", run)), str(write_csv("copy.csv", copy(run)))]
    for order in (paths, paths[::-1]):
        with pytest.raises(InvalidInputError, match=r"is the same recording as"):
            gather_inputs(order, rig=rig).recordings()


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(
    ("noise", "period", "start"),
    [(0.07, 0.01, 0.0), (0.07, 0.01, 0.005), (0.01, 0.01, 0.0), (0.07, 0.05, 0.0), (0.0, 0.01, 0.0),
     (0.03, 0.02, 0.01)],
)  # fmt: skip
def test_two_runs_along_one_path_are_two(
    write_csv: Write, rig: Path, seed: int, noise: float, period: float, start: float
) -> None:
    other = write_csv("other.csv", run_of(2 * seed + 1, noise, period, start))
    for first in (run_of(2 * seed), run_of(2 * seed, max(noise, 0.001), period)):
        one = write_csv("one.csv", first)
        assert len(gather_inputs([str(one), str(other)], rig=rig).recordings()) == 2
    hums = [str(write_csv(f"hum_{n}.csv", run_of(9 * seed + n, noise + 0.02, hum=0.3))) for n in (0, 1)]
    assert len(gather_inputs(hums, rig=rig).recordings()) == 2


@pytest.fixture
def folder(rig: Path, write_csv: Write) -> Path:
    """The working folder with good.csv, rig.toml, and links."""
    good, tmp_path = write_csv("good.csv"), rig.parent
    (tmp_path / "sub").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "sub")
    (tmp_path / "link.csv").symlink_to(good)
    os.link(good, tmp_path / "hard.csv")
    return tmp_path


SPELLINGS = [
    "good.csv", "nosub/../good.csv", "nosub/deeper/../../good.csv", "sub/../good.csv",
    "link/../good.csv", "good.csv/../good.csv", "link.csv", "nosub/../link.csv", "hard.csv",
    "nosub/../hard.csv",
]  # fmt: skip


@pytest.mark.parametrize("spelling", SPELLINGS)
def test_an_output_is_known_as_an_input(folder: Path, spelling: str) -> None:
    assert folder
    with pytest.raises(InvalidInputError, match="would overwrite what is read"):
        refuse_overwriting([Path(spelling)], [Path("good.csv")])


def test_another_file_of_the_same_name_may_be_written(folder: Path) -> None:
    written = [Path("sub/good.csv"), Path("nosub/good.csv"), Path("new.csv")]
    refuse_overwriting(written, [Path("good.csv")])
    # What a link leads to counts, not how it reads.
    (folder / "sub" / "deep").mkdir()
    (folder / "far").symlink_to(folder / "sub" / "deep")
    refuse_overwriting([Path("far/../good.csv")], [Path("good.csv")])


@pytest.mark.parametrize(
    ("recording", "beside"),
    [("run.blf", "car.dbc"), ("run.log", "car.dbc"), ("run.mcap", "metadata.yaml"),
     ("run.tdms", "run.tdms_index"), ("run_0.db3", "run_1.db3")],
)  # fmt: skip
def test_what_lies_beside_a_recording_is_read_too(folder: Path, recording: str, beside: str) -> None:
    for name in (recording, beside, "table.csv"):
        (folder / "sub" / name).write_text("")
    read = gather_inputs([f"sub/{recording}"]).files
    assert [path.name for path in read] == [recording, beside]
    with pytest.raises(InvalidInputError, match="would overwrite what is read"):
        refuse_overwriting([Path("nosub/../sub") / beside], read)
    refuse_overwriting([Path("sub/other.csv"), Path(beside)], read)
