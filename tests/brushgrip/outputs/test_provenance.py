"""Where results come from, and whose folder is whose."""

import hashlib
import json
import os
from pathlib import Path
from typing import Any

import pytest

from brushgrip.inputs.command_inputs import gather_inputs
from brushgrip.outputs.provenance import (
    KEY,
    digest_of,
    markdown_comment,
    provenance_file,
    provenance_of,
    remove_earlier,
    require_same_run,
)
from brushgrip.outputs.verbosity import COMMAND_LINE
from symbolic import InvalidInputError
from tests.brushgrip.helpers import Run, Write


def write_result(made: dict[str, Any]) -> Path:
    document = Path("diagnosis.json")
    document.write_text(json.dumps({"provenance": {**made, "files": ["old.png", "../far.png", ""]}}))
    return document


@pytest.fixture
def recordings(tmp_path: Path) -> list[Path]:
    paths = [tmp_path / "a.csv", tmp_path / "b.csv"]
    for path in paths:
        path.write_text(f"t,psi of {path.name}\n")
    return paths


def test_inputs_have_their_digests_and_the_command_stands_there(recordings: list[Path]) -> None:
    COMMAND_LINE.set(("diagnose", "a.csv"))
    made = provenance_of(recordings, recordings[0], robust=0.1)

    assert [file["name"] for file in made["inputs"]] == ["a.csv", "b.csv"]
    content = b"t,psi of a.csv\n"
    digest = hashlib.sha256(content).hexdigest()
    assert made["inputs"][0] == {"name": "a.csv", "sha256": digest, "bytes": len(content)}
    assert (made["rig"]["sha256"], made["rig"]["content"]) == (digest, content.decode())
    assert made["command"] == ["brushgrip", "diagnose", "a.csv"]
    assert made["time_utc"].endswith("+00:00")
    assert made["settings"] == {"robust": 0.1}


@pytest.mark.parametrize("files", [5, "old.png", None, {"old.png": 1}, [5, None, "a\0.png", "old.png"]])
def test_files_to_clear_are_plain_names(files: Any, recordings: list[Path]) -> None:
    made = provenance_of(recordings)
    document = Path("diagnosis.json")
    document.write_text(json.dumps({"provenance": {**made, "files": files}}))

    expected = ("old.png",) if isinstance(files, list) else ()
    assert require_same_run(document, made, force=False) == expected


def test_the_same_run_may_replace_itself(recordings: list[Path]) -> None:
    made = provenance_of(recordings, robust=None, ground=[])
    document = write_result(made | {"time_utc": "2020-01-01T00:00:00+00:00"})

    assert require_same_run(document, made, force=False) == ("old.png",)
    assert require_same_run(Path("none.json"), made, force=False) == ()


@pytest.mark.parametrize(
    "change", ["input", "order", "setting", "signals", "no provenance", "damaged", "text"]
)
def test_another_run_is_not_replaced_unless_forced(recordings: list[Path], change: str) -> None:
    document = write_result(provenance_of(recordings, robust=None))
    robust, signals = (0.1 if change == "setting" else None), {"t": 1} if change == "signals" else {}
    if change == "input":
        recordings[1].write_text("other")
    texts = {"no provenance": "{}", "damaged": "{", "text": '{"provenance": "run"}'}
    if change in texts:
        document.write_text(texts[change])
    order = recordings[::-1] if change == "order" else recordings
    made = provenance_of(order, signals=signals, robust=robust)

    with pytest.raises(InvalidInputError, match=r"holds another run.*--force replaces it"):
        require_same_run(document, made, force=False)
    require_same_run(document, made, force=True)


def test_only_what_a_run_wrote_is_cleared(tmp_path: Path) -> None:
    for name in ("old.png", "kept.png", "mine.txt", "run.csv"):
        (tmp_path / name).write_text("x")

    remove_earlier(tmp_path, ["old.png", "kept.png", "gone.png", "run.csv"], ["kept.png"])

    assert sorted(path.name for path in tmp_path.iterdir()) == ["kept.png", "mine.txt", "run.csv"]


def test_beside_a_device_goes_nothing(run: Run, write_csv: Write, rig: Path) -> None:
    for device in ("/dev/null", "/dev/full"):
        assert provenance_file(Path(device)) == Path(os.devnull)
    outcome = run("simulate", "--rig", rig, write_csv("bare.csv"), "--out", "/dev/null")

    assert (outcome.status, outcome.err) == (0, "")
    assert not Path("/dev/null.provenance.json").exists()


@pytest.mark.usefixtures("interpreted")
def test_a_table_has_its_origin_beside_it_and_what_is_no_text_by_its_escape_sequence(
    run: Run, write_csv: Write, rig: Path
) -> None:
    out = Path("torque.csv")
    odd = ("--ground", "steel\udcff")

    assert run("simulate", "--rig", rig, write_csv("bare.csv"), "--out", out, *odd).status == 0
    told = json.loads(provenance_file(out).read_text())
    assert [file["name"] for file in told["inputs"]] == ["bare.csv"]
    assert told["rig"]["sha256"] == digest_of(rig)
    assert told["command"][:2] == ["brushgrip", "simulate"]
    assert told["settings"]["ground"] == ["steel\udcff"]


def test_a_comment_in_markdown_is_not_ended_by_what_it_tells(recordings: list[Path]) -> None:
    made = provenance_of(recordings, note="--> <script>")
    comment = markdown_comment(made)

    assert comment.startswith("\n<!--\n{")
    assert comment.endswith("}\n-->\n")
    assert comment.count("-->") == 1
    assert json.loads(comment[6:-5])[KEY] == json.loads(json.dumps(made))


@pytest.mark.parametrize("a", [0.045, 0.05])
def test_another_rig_than_that_of_the_diagnosis_is_told(
    rig: Path, capsys: pytest.CaptureFixture[str], a: float
) -> None:
    model, told = Path("model.json"), {"content": f"[rig]\na = {a}\ne = 0.009\n[tyre]\nk = 2e6\n"}
    model.write_text(json.dumps({KEY: {"rig": told}}))
    gather_inputs(rig=rig, model=model)

    line = (
        "the rig file says a = 0.045 m, e = 0.009 m; the model was found with a = 0.05 m, e = 0.009 m:"
        " for the same wheel declare the lengths that it was found with; for another one diagnose anew,"
        " with recordings of it\n"
    )
    assert capsys.readouterr() == ("", line if a == 0.05 else "")
    model.write_text("{}")
    gather_inputs(rig=rig, model=model)
    assert capsys.readouterr() == ("", "")
