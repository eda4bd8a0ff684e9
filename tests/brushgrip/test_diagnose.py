import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import identification
from brushgrip import embedded_files, friction_outcome
from brushgrip.pictures.style import picture
from brushgrip.pipeline import locate_inputs
from identification.fits.loss import Huber
from identification.reading.recordings import Recording
from identification.results import Diagnosis
from identification.selection.journal import Journal
from symbolic import InvalidInputError

Run = Callable[..., Any]
Write = Callable[..., Path]
FILES = [
    "candidates.png", "diagnosis.json", "experiment_carcass_torsion.png", "loops.png", "model.json",
    "report.html", "residuals.png", "signatures.png",
]  # fmt: skip


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch, make_diagnosis: Callable[..., Diagnosis]) -> list[Any]:
    """Puts a made-up diagnosis in place of the search; holds what was asked of it."""
    calls: list[Any] = []

    def close(
        recordings: Sequence[Recording],
        holdout: Sequence[Recording],
        *,
        jobs: int | None = None,
        progress: Callable[[str, int, int], None],
        **_: object,
    ) -> Diagnosis:
        progress("trying", 1, 2)
        training, held_out = (tuple(r.name for r in group) for group in (recordings, holdout))
        calls.append((training, held_out, jobs))
        return make_diagnosis(training, held_out, worse=training[:1])

    monkeypatch.setattr(identification, "diagnose", close)
    return calls


@pytest.fixture
def no_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """An empty page, for tests that do not look at it."""

    def blank(folder: Path, *_: object) -> None:
        (folder / "report.html").touch()

    monkeypatch.setattr("brushgrip.diagnosing.write_report", blank)


@pytest.fixture
def paths(write_csv: Write) -> list[Path]:
    return [
        write_csv(f"{name}.csv", {"M_z": [float(number + i) for i in range(60)]})
        for number, name in enumerate("abcd")
    ]


def test_writes_everything(
    run: Run, asked: list[Any], paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    a, b, c, d = paths
    out = tmp_path / "new" / "out"
    outcome = run("diagnose", a, b, "--rig", rig, "--holdout", c, d, "--out", out, "--jobs", 3)

    assert outcome.status == 0
    assert asked == [(("a", "b"), ("c", "d"), 3)]
    assert sorted(path.name for path in out.iterdir()) == FILES
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == ["out"]
    content = json.loads((out / "diagnosis.json").read_text())
    assert content["recordings"] == ["a", "b"]
    assert content["effects"][0]["name"] == "carcass_torsion"
    assert json.loads((out / "model.json").read_text())["effects"][0] == "carcass_torsion"


@pytest.mark.usefixtures("no_report")
def test_pictures_of_an_earlier_run_go_and_nothing_else(
    run: Run, asked: list[Any], paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    out.mkdir()
    for ours in ("experiment_stribeck.png", "friction.png", "mine.png"):
        with picture(out / ours, 1.0):
            pass
    (out / "experiment_of_mine.png").write_bytes(b"not by us")
    outcome = run("diagnose", *paths, "--rig", rig, "--out", out)

    assert outcome.status == 0
    assert asked
    assert sorted(path.name for path in out.glob("*.png")) == ["experiment_of_mine.png", "mine.png"]


@pytest.mark.usefixtures("no_report")
def test_says_what_is_thinned(
    run: Run, asked: list[Any], paths: list[Path], write_csv: Write, rig: Path, tmp_path: Path
) -> None:
    outcome = run("diagnose", *paths[:2], "--rig", rig, "--out", tmp_path / "out")
    sparse = write_csv("sparse.csv", {"t": [0.02 * i for i in range(60)]})
    whole = run("diagnose", sparse, "--rig", rig, "--out", tmp_path / "whole")

    assert len(asked) == 2
    assert outcome.out.startswith(
        "candidates are ranked on 60 of 120 samples, thinned towards 0.02 s; the best are fitted to all"
    )
    assert "ranked" not in whole.out


@pytest.mark.usefixtures("no_report")
def test_says_what_was_found(
    run: Run, asked: list[Any], paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    outcome = run("diagnose", "--rig", rig, "--out", out, paths[0], "--holdout", *paths[1:3])

    assert asked
    assert outcome.err == ""
    for words in (
        "misses carcass torsion and torque offset",
        "declared",
        "391.2 ± 4.2 N m/rad",
        "patch width",
        "note: a got worse",
        f"report: {out / 'report.html'}",
    ):
        assert words in outcome.out


@pytest.mark.usefixtures("no_report")
def test_repeated_flags(
    run: Run, asked: list[Any], paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    held_out = [word for path in paths[1:] for word in ("--holdout", path)]
    run("diagnose", paths[0], *held_out, "--out", tmp_path / "out", "--rig", rig)

    assert asked == [(("a",), ("b", "c", "d"), None)]


@pytest.mark.usefixtures("no_report")
def test_no_holdout(run: Run, asked: list[Any], paths: list[Path], rig: Path, tmp_path: Path) -> None:
    outcome = run("diagnose", *paths, "--out", tmp_path / "out", "--rig", rig)

    assert outcome.status == 0
    assert asked == [(("a", "b", "c", "d"), (), None)]


def test_options_reach_the_search(
    run: Run, monkeypatch: pytest.MonkeyPatch, paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    asked: dict[str, Any] = {}

    def stop(*_: object, **options: object) -> None:
        asked.update(options)
        raise InvalidInputError("enough")

    monkeypatch.setattr(identification, "diagnose", stop)
    run("diagnose", *paths, "--out", tmp_path / "out", "--rig", rig, "--robust", 0.01)
    assert asked["loss"] == Huber(threshold=0.01)
    outcome = run("diagnose", *paths, "--out", tmp_path / "out", "--rig", rig, "--robust", 0)
    assert outcome.status == 2
    assert "threshold must be a finite number greater than 0" in outcome.err


def test_friction_takes_the_samples_that_the_search_takes(
    run: Run, monkeypatch: pytest.MonkeyPatch, paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    taken: list[object] = []

    def stop(training: Any, holdout: Any, _: object) -> None:
        taken.extend([*training, *holdout])
        raise InvalidInputError("enough")

    thinned = ["those of", "the search"]
    monkeypatch.setattr("identification.reading.long_recordings.bounded", lambda _: (thinned, None))
    monkeypatch.setattr("brushgrip.diagnosing.thinning", lambda _: "")
    monkeypatch.setattr(identification, "diagnose", lambda *_, **__: None)
    monkeypatch.setattr(friction_outcome, "friction_outcome", stop)
    run("diagnose", *paths, "--out", tmp_path / "out", "--rig", rig)

    assert taken == thinned


@pytest.mark.parametrize(
    ("column", "factor", "cause"),
    [
        ("psi", 180 / np.pi, "degrees"),
        ("t", 1e3, "milliseconds"),
        ("F_N", 1e-3, "kN"),
        ("M_z", -1.0, "other sign"),
    ],
)
def test_other_units_and_signs_are_named(
    run: Run, monkeypatch: pytest.MonkeyPatch, repository_root: Path, tmp_path: Path,
    column: str, factor: float, cause: str,
) -> None:  # fmt: skip
    def stop(*_: object, **__: object) -> None:
        raise InvalidInputError("enough")

    monkeypatch.setattr(identification, "diagnose", stop)
    recordings = repository_root / "examples" / "recordings"
    table = (recordings / "train_a.csv").read_text().splitlines()
    names = table[0].split(",")
    rows = np.loadtxt(table[1:], delimiter=",")
    rows[:, names.index(column)] *= factor
    np.savetxt(tmp_path / "wrong.csv", rows, delimiter=",", header=table[0], comments="")
    outcome = run(
        "diagnose", tmp_path / "wrong.csv", "--out", tmp_path / "out", "--rig", recordings / "rig.toml"
    )

    assert "wrong: " in outcome.err
    assert cause in outcome.err


@pytest.mark.usefixtures("no_report")
def test_an_interrupted_search_keeps_its_trials(
    run: Run,
    monkeypatch: pytest.MonkeyPatch,
    asked: list[Any],
    paths: list[Path],
    rig: Path,
    tmp_path: Path,
) -> None:
    finish = identification.diagnose

    def interrupted(*_: object, journal: Journal, **__: object) -> None:
        (journal.folder / "trial").touch()
        raise KeyboardInterrupt

    monkeypatch.setattr(identification, "diagnose", interrupted)
    outcome = run("diagnose", *paths, "--out", tmp_path / "out", "--rig", rig)

    assert outcome.status in (1, 130)
    assert "the same command goes on" in outcome.err
    assert (tmp_path / ".out.unfinished" / "trial").exists()
    assert not (tmp_path / "out").exists()
    assert not asked

    monkeypatch.setattr(identification, "diagnose", finish)
    assert run("diagnose", *paths, "--out", tmp_path / "out", "--rig", rig).status == 0
    assert not (tmp_path / ".out.unfinished").exists()


def test_a_fault_keeps_the_trials_too(
    run: Run, monkeypatch: pytest.MonkeyPatch, paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    def faulty(*_: object, **__: object) -> None:
        raise InvalidInputError("a: M_z is constant")

    kept = tmp_path / ".out.unfinished"
    kept.mkdir()
    (kept / "trial").touch()
    monkeypatch.setattr(identification, "diagnose", faulty)
    outcome = run("diagnose", *paths, "--out", tmp_path / "out", "--rig", rig)

    assert outcome.status == 2
    assert (kept / "trial").exists()
    note, fault = outcome.err.splitlines()
    assert f"kept in {kept}" in note
    assert fault == "brushgrip: a: M_z is constant"


def test_trials_are_kept_elsewhere_where_nothing_can_be_beside_the_results(
    run: Run, monkeypatch: pytest.MonkeyPatch, paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    seen: list[Path] = []

    def faulty(*_: object, journal: Journal, **__: object) -> None:
        (journal.folder / "trial").touch()
        seen.append(journal.folder)
        raise InvalidInputError("enough")

    monkeypatch.setattr(identification, "diagnose", faulty)
    monkeypatch.setenv("BRUSHGRIP_CACHE", str(tmp_path / "cache"))
    # A name that leaves no room for another one beside it.
    out = tmp_path / ("o" * 250)
    for _ in range(2):
        assert (
            f"kept in {tmp_path / 'cache' / 'unfinished'}"
            in run("diagnose", *paths, "--out", out, "--rig", rig).err
        )
    out.mkdir()
    assert f"kept in {out / '.unfinished'}" in run("diagnose", *paths, "--out", out, "--rig", rig).err

    assert seen[0] == seen[1] != seen[2]


def test_it_is_said_that_nothing_can_be_kept(
    run: Run, monkeypatch: pytest.MonkeyPatch, paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    def faulty(*_: object, journal: Journal | None, **__: object) -> None:
        raise InvalidInputError(f"enough, {journal}")

    monkeypatch.setattr(identification, "diagnose", faulty)
    monkeypatch.setenv("BRUSHGRIP_CACHE", str(paths[0] / "cache"))
    outcome = run("diagnose", *paths, "--out", tmp_path / ("o" * 250), "--rig", rig)

    assert outcome.err.splitlines() == [
        "what is found cannot be kept, no folder can be written; interrupted, all begins anew",
        "brushgrip: enough, None",
    ]


@pytest.mark.long
@pytest.mark.usefixtures("asked")
def test_a_folder_in_the_way_of_the_report_does_not_cost_the_search(
    run: Run, monkeypatch: pytest.MonkeyPatch, paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    finish = identification.diagnose

    def searching(*given: Any, journal: Journal, **options: Any) -> Diagnosis:
        (journal.folder / "trial").touch()
        return finish(*given, journal=journal, **options)

    (tmp_path / "out" / "report.html").mkdir(parents=True)
    monkeypatch.setattr(identification, "diagnose", searching)
    command = ("diagnose", *paths, "--out", tmp_path / "out", "--rig", rig)
    outcome = run(*command)

    assert outcome.status == 2
    assert "report.html: is in the way" in outcome.err
    assert "the same command goes on" in outcome.err
    assert (tmp_path / ".out.unfinished" / "trial").exists()

    (tmp_path / "out" / "report.html").rmdir()
    assert run(*command).status == 0
    assert not (tmp_path / ".out.unfinished").exists()


def test_training_and_held_out_must_differ(
    run: Run, asked: list[Any], paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    outcome = run("diagnose", *paths[:2], "--holdout", paths[1], "--out", tmp_path / "out", "--rig", rig)

    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    assert "is the same recording as" in outcome.err
    assert asked == []


def test_a_failure_leaves_nothing(
    run: Run, monkeypatch: pytest.MonkeyPatch, paths: list[Path], rig: Path, tmp_path: Path
) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(identification, "diagnose", fail)
    before = sorted(tmp_path.iterdir())
    with pytest.raises(ZeroDivisionError):
        run("diagnose", *paths, "--out", tmp_path / "out", "--rig", rig)

    assert sorted(tmp_path.iterdir()) == before


def test_constant_torque_takes_one_line(run: Run, write_csv: Write, rig: Path, tmp_path: Path) -> None:
    path = write_csv("flat.csv", {"M_z": [1.0] * 60})
    outcome = run("diagnose", path, "--out", tmp_path / "out", "--rig", rig)

    assert outcome.status == 2
    assert outcome.err.count("\n") == 1
    assert "flat: M_z is constant" in outcome.err
    assert not (tmp_path / "out").exists()


class TestDemo:
    @pytest.mark.usefixtures("no_report")
    def test_runs_on_the_embedded_recordings(
        self, run: Run, asked: list[Any], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
    ) -> None:
        monkeypatch.setattr(friction_outcome, "estimate_friction", lambda *_: [])
        outcome = run("demo", "--out", tmp_path / "out")
        (training, held_out, _) = asked[0]

        assert outcome.status == 0
        assert len(training) >= 2
        assert len(held_out) >= 1
        written = sorted(path.name for path in (tmp_path / "out").iterdir())
        assert written == ["diagnosis.json", "model.json", "report.html", "rig.toml"]

    @pytest.mark.usefixtures("interpreted")
    def test_friction_by_both_models_and_every_observer(
        self, make_diagnosis: Callable[..., Diagnosis], write_csv: Write, rig: Path
    ) -> None:
        path = write_csv("held.csv")
        diagnosis = make_diagnosis(("a",), ("held",))
        tracks = friction_outcome.estimate_friction(
            locate_inputs([str(path)], rig=rig).recordings(), diagnosis
        )

        assert [track.label for track in tracks] == [
            "EKF, declared model",
            "EKF, model found",
            "MHE, model found",
        ]
        assert {track.reference for track in tracks} == {1.3}
        assert all(track.mu.size == 60 for track in tracks)

    def test_missing_recordings_are_said(
        self, run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
    ) -> None:
        monkeypatch.setattr(embedded_files, "RIG", "elsewhere.toml")
        outcome = run("demo", "--out", tmp_path / "out")

        assert outcome.status == 2
        assert outcome.err.count("\n") == 1
        assert "elsewhere.toml" in outcome.err
