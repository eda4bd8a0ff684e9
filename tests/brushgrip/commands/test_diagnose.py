"""`brushgrip diagnose` and `demo` around a search that is not run: what it is asked, what is written."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import identification
from brushgrip.estimation import friction_by_both_models
from brushgrip.inputs.command_inputs import gather_inputs
from brushgrip.pictures.style import figure_saved_as_png
from brushgrip.published import bundled_files
from brushgrip.running import unfinished_search
from identification import Diagnosis, Huber, Journal, Recording
from identification.selection.trial_runner import worker_submitter
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from tests.brushgrip.factories import make_diagnosis, make_outcome
from tests.brushgrip.helpers import PNG, Outcome, Run, Write, contents, table_of

FILES = [
    "candidates.png", "diagnosis.json", "experiment_carcass_torsion.png", "friction.png", "loops.png",
    "mechanisms.png", "model.json", "overview.png", "report.html", "residuals.png", "signatures.png",
]  # fmt: skip
Diagnose = Callable[..., Outcome]


@pytest.fixture
def search(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[..., Any]], None]:
    """Puts a function in place of the search."""
    return lambda function: monkeypatch.setattr(identification, "diagnose", function)


@pytest.fixture
def asked(search: Callable[..., None]) -> list[Any]:
    """Puts a made-up diagnosis in place of the search; holds what was asked of it."""
    calls: list[Any] = []

    def close(
        recordings: Sequence[Recording], holdout: Sequence[Recording], *, progress: Any, **options: Any
    ) -> Diagnosis:
        progress("trying", 1, 2)
        training, held_out = (tuple(r.name for r in group) for group in (recordings, holdout))
        calls.append((training, held_out, options.get("jobs")))
        return make_diagnosis(training, held_out, worse=training[:1])

    search(close)
    return calls


@pytest.fixture
def no_report(monkeypatch: pytest.MonkeyPatch) -> None:
    """An empty page and no friction, for tests that do not look at them."""

    def blank(folder: Path, *_: object) -> None:
        (folder / "report.html").touch()

    monkeypatch.setattr(friction_by_both_models, "friction_by_both_models", lambda *_: None)
    monkeypatch.setattr("brushgrip.report.diagnosis_folder.write_report", blank)


@pytest.fixture
def diagnose(run: Run, rig: Path, write_csv: Write) -> Diagnose:
    """The command on a.csv to d.csv, or on what is given."""
    for number, name in enumerate("abcd"):
        write_csv(f"{name}.csv", {"M_z": [float(number + i) for i in range(60)]})

    def command(*arguments: object, out: object = "out") -> Outcome:
        given = arguments or ("a.csv", "b.csv", "c.csv", "d.csv")
        return run("diagnose", "--rig", rig, "--out", out, *given)

    return command


def enough(*_: object, **__: object) -> None:
    raise InvalidInputError("enough")


def finds_something(*_: object, journal: Journal | None, **__: object) -> None:
    """A search that ends with a fault once it has noted a trial."""
    assert journal is not None
    (journal.folder / "trial").touch()
    raise InvalidInputError("enough")


def test_writes_everything(diagnose: Diagnose, asked: list[Any]) -> None:
    outcome = diagnose("a", "b", "--holdout", "c", "d", "--jobs", 1, out="new/out")
    out = Path("new/out")
    content = json.loads((out / "diagnosis.json").read_text())

    assert (outcome.status, outcome.err) == (0, "")
    assert asked == [(("a", "b"), ("c", "d"), 1)]
    assert sorted(path.name for path in out.iterdir()) == FILES
    assert all(path.read_bytes().startswith(PNG) for path in out.glob("*.png"))
    assert [path.name for path in out.parent.iterdir()] == ["out"]
    assert content["recordings"] == ["a", "b"]
    assert content["effects"][0]["name"] == "carcass_torsion"
    assert json.loads((out / "model.json").read_text())["effects"][0] == "carcass_torsion"
    ranked = (
        "candidates are ranked on 120 of 240 samples, thinned towards 0.02 s (0.04 s where the error is"
        " large); the best are fitted to all"
    )
    assert outcome.out.startswith(ranked)
    for words in (
        *("lacks compliance and contact shape (carcass", "assumed", "391.2 ± 4.2 N m/rad"),
        *("patch width", "note: a got worse", "report: new/out/report.html"),
    ):
        assert words in outcome.out


@pytest.mark.usefixtures("no_report")
def test_pictures_of_an_earlier_run_go_and_nothing_else(diagnose: Diagnose, asked: list[Any]) -> None:
    out = Path("out")
    out.mkdir()
    for ours in ("experiment_stribeck.png", "friction.png", "mine.png"):
        with figure_saved_as_png(out / ours, 1.0):
            pass
    (out / "experiment_of_mine.png").write_bytes(b"not by us")

    assert diagnose().status == 0
    assert asked == [(("a", "b", "c", "d"), (), None)]
    assert sorted(path.name for path in out.glob("*.png")) == ["experiment_of_mine.png", "mine.png"]


@pytest.mark.usefixtures("no_report", "asked")
def test_nothing_is_said_of_thinning_where_none_is(diagnose: Diagnose, write_csv: Write) -> None:
    assert "ranked" not in diagnose(write_csv("sparse.csv", {"t": [0.02 * i for i in range(60)]})).out


def test_options_reach_the_search(diagnose: Diagnose, search: Callable[..., None]) -> None:
    given: dict[str, Any] = {}
    search(lambda *_, **options: given.update(options) or enough())

    diagnose("a", "--robust", 0.01)
    assert given["loss"] == Huber(threshold=0.01)
    assert "threshold must be a finite number greater than 0" in diagnose("a", "--robust", 0).err


def test_friction_takes_the_samples_that_the_search_takes(
    diagnose: Diagnose, search: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    # The search bounds the recordings itself, so that its result has the note.
    searched: list[str] = []
    estimated: list[object] = []
    thinned = ["those of", "the search"]

    def stop(training: Any, holdout: Any, *_: object) -> None:
        estimated.extend([*training, *holdout])
        enough()

    thinning = "identification.reading.trimming_and_thinning.thin_recordings"
    monkeypatch.setattr(thinning, lambda _: (thinned, None))
    monkeypatch.setattr("brushgrip.report.diagnosis_folder.thinning_note", lambda _: "")

    def searching(training: Any, *_: object, **__: object) -> Diagnosis:
        searched.extend(r.name for r in training)
        return make_diagnosis()

    search(searching)
    monkeypatch.setattr(friction_by_both_models, "friction_by_both_models", stop)
    diagnose()

    assert (searched, estimated) == (["a", "b", "c", "d"], thinned)


DiagnoseTorque = Callable[[Callable[[Array, float], Array]], tuple[Outcome, str]]


@pytest.fixture
def diagnose_torque(
    diagnose: Diagnose, write_csv: Write, repository_root: Path, monkeypatch: pytest.MonkeyPatch
) -> DiagnoseTorque:
    """Diagnoses what a sensor with a limit makes of a torque; gives the outcome and its first note."""
    friction = make_outcome()
    monkeypatch.setattr(friction_by_both_models, "friction_by_both_models", lambda *_: friction)
    columns = table_of(repository_root / "examples" / "recordings" / "train_a.csv")
    M_z = columns["M_z"]

    def diagnosed(sensor: Callable[[Array, float], Array]) -> tuple[Outcome, str]:
        ended = write_csv("a.csv", columns | {"M_z": sensor(M_z, 0.6 * M_z.max())})
        outcome = diagnose(ended, "b", "--jobs", 1)
        note, *_ = json.loads(Path("out/diagnosis.json").read_text())["notes"]
        return outcome, note

    return diagnosed


@pytest.mark.usefixtures("no_drawing")
def test_what_looks_wrong_with_an_input_stands_in_every_result(
    diagnose_torque: DiagnoseTorque, asked: list[Any]
) -> None:
    outcome, note = diagnose_torque(lambda M_z, top: M_z.clip(-top, top))
    page = Path("out/report.html").read_text("utf-8")

    clipped = "a: friction is above 0.79: the torque is clip"
    assert outcome.err.startswith(clipped)
    assert note.startswith(f"an input looks wrong, so that the result may be void: {clipped}")
    assert asked
    for told in (" ".join(outcome.out.split()), page):
        assert f"An input looks wrong, so that the result may be void: {clipped}" in told
        assert "end the input that looks wrong, or leave its recording out, and run this again" in told


@pytest.mark.usefixtures("no_drawing")
def test_a_sensor_that_may_end_voids_nothing(diagnose_torque: DiagnoseTorque, asked: list[Any]) -> None:
    outcome, note = diagnose_torque(lambda M_z, top: top * np.tanh(M_z / top))

    assert asked
    assert outcome.err.startswith("a: the torque seems to end at")
    assert note.startswith("the sensor may end: a: the torque seems to end at")
    for told in (" ".join(outcome.out.split()), Path("out/report.html").read_text("utf-8")):
        assert "he sensor may end: a: the torque" in told
        assert "result may be void" not in told
        assert "leave its recording out" not in told


@pytest.mark.usefixtures("no_report")
def test_an_interrupted_search_keeps_its_trials(
    diagnose: Diagnose, asked: list[Any], search: Callable[..., None]
) -> None:
    finish = identification.diagnose

    def interrupted(*_: object, journal: Journal, **__: object) -> None:
        (journal.folder / "trial").touch()
        raise KeyboardInterrupt

    search(interrupted)
    outcome = diagnose()

    assert outcome.status in (1, 130)
    assert "the same command goes on" in outcome.err
    assert Path(".out.unfinished/trial").exists()
    assert not Path("out").exists()
    assert not asked

    search(finish)
    assert diagnose().status == 0
    assert not Path(".out.unfinished").exists()


def test_trials_are_kept_where_there_is_a_place(
    diagnose: Diagnose, search: Callable[..., None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BRUSHGRIP_CACHE", str(tmp_path / "cache"))
    search(finds_something)
    # A name that leaves no room for another one beside it.
    long = tmp_path / ("o" * 250)
    note, fault = diagnose().err.splitlines()

    assert f"kept in {tmp_path / '.out.unfinished'}" in note
    assert fault == "brushgrip: enough"
    for _ in range(2):
        assert f"kept in {tmp_path / 'cache' / 'unfinished'}" in diagnose(out=long).err
    assert len(list((tmp_path / "cache" / "unfinished").iterdir())) == 1
    long.mkdir()
    assert f"kept in {long / '.unfinished'}" in diagnose(out=long).err


def test_it_is_said_that_nothing_can_be_kept(
    diagnose: Diagnose, search: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    def faulty(*_: object, journal: Journal | None, **__: object) -> None:
        raise InvalidInputError(f"enough, {journal}")

    search(faulty)
    monkeypatch.setattr(unfinished_search, "cache_directory", lambda: Path("a.csv/cache"))

    assert diagnose(out="o" * 250).err.splitlines() == [
        "what is found cannot be kept, no folder can be written; interrupted, all begins anew",
        "brushgrip: enough, None",
    ]


@pytest.mark.long
@pytest.mark.usefixtures("asked")
def test_a_folder_in_the_way_of_the_report_does_not_cost_the_search(
    diagnose: Diagnose, search: Callable[..., None]
) -> None:
    finish = identification.diagnose

    def searching(*given: Any, journal: Journal, **options: Any) -> Diagnosis:
        (journal.folder / "trial").touch()
        return finish(*given, journal=journal, **options)

    Path("out/report.html").mkdir(parents=True)
    search(searching)
    outcome = diagnose()

    assert outcome.status == 2
    assert "report.html: is in the way" in outcome.err
    assert "the same command goes on" in outcome.err
    assert Path(".out.unfinished/trial").exists()

    Path("out/report.html").rmdir()
    assert diagnose().status == 0
    assert not Path(".out.unfinished").exists()


def test_a_failure_leaves_nothing(diagnose: Diagnose, search: Callable[..., None]) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ZeroDivisionError

    search(fail)
    before = contents(Path())
    with pytest.raises(ZeroDivisionError):
        diagnose()

    assert contents(Path()) == before


class TestDemo:
    @pytest.mark.usefixtures("no_report")
    def test_runs_on_the_embedded_recordings(self, run: Run, asked: list[Any]) -> None:
        outcome = run("demo", "--out", "out")
        (training, held_out, _) = asked[0]

        assert outcome.status == 0
        assert len(training) >= 2
        assert len(held_out) >= 1
        written = sorted(path.name for path in Path("out").iterdir())
        assert written == ["diagnosis.json", "model.json", "report.html", "rig.toml"]

    @pytest.mark.usefixtures("interpreted")
    def test_friction_by_both_models_and_every_observer(self, write_csv: Write, rig: Path) -> None:
        recordings = gather_inputs([str(write_csv("held.csv"))], rig=rig).recordings()
        outcome = friction_by_both_models.friction_by_both_models(
            [], recordings, make_diagnosis(("a",), ("held",))
        )
        assert outcome is not None
        tracks = outcome.tracks

        labels = ["EKF, assumed model", "EKF, model found", "MHE, model found"]
        assert [track.label for track in tracks] == labels
        assert outcome.complete_tracks == tracks
        assert {track.reference for track in tracks} == {1.3}
        assert all(track.mu.size == 60 for track in tracks)

        with worker_submitter(2) as submit:
            found = make_diagnosis(("a",), ("held",))
            again = friction_by_both_models.friction_by_both_models([], recordings, found, submit)
        assert again is not None
        assert again.to_dict() == outcome.to_dict()
        for track, other in zip(tracks, again.tracks, strict=True):
            assert other.label == track.label
            np.testing.assert_array_equal(other.mu, track.mu)

    @pytest.mark.usefixtures("interpreted")
    def test_friction_without_stand_ins(self, write_csv: Write, rig: Path) -> None:
        """The model without them finds half of mu in all that was fitted."""
        recordings = gather_inputs([str(write_csv("held.csv"))], rig=rig).recordings()
        found = make_diagnosis(("a",), ("held",))
        own = {name: {**values, "mu": 0.5 * values["mu"]} for name, values in found.values.own.items()}
        poorer = found.model, replace(found.values, own=own)
        outcome = friction_by_both_models.friction_by_both_models(
            [], recordings, replace(found, without_stand_ins=poorer)
        )

        assert outcome is not None
        assert outcome.without_stand_ins == pytest.approx({"": 0.5})

    def test_missing_recordings_are_said(self, run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(bundled_files, "RIG", "elsewhere.toml")
        run("demo", "--out", "out").refused("elsewhere.toml")

    def test_the_examples_are_written_to_a_new_folder(self, run: Run, repository_root: Path) -> None:
        out = Path("mine")
        outcome = run("demo", "--examples", out)
        scripts = {path.name for path in (repository_root / "examples").glob("*.py")}

        assert outcome.status == 0
        assert outcome.out.startswith(f"wrote {len(scripts)} examples to {out}; python ")
        assert {path.name for path in out.glob("*.py")} == scripts
        assert (out / "recordings" / "rig.toml").is_file()
        assert (out / "reference_rig" / "__init__.py").is_file()
        assert not list(out.rglob("__pycache__"))
        run("demo", "--examples", out).refused("is not empty")
