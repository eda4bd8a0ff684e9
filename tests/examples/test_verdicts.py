"""Verdicts on cases whose truth is known."""

from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

import verdicts
from identification import diagnose
from reference_rig import RigTyre, make_recording, recording_csv, rig_toml
from tests.brushgrip.factories import make_diagnosis
from tests.examples.running import execute


def test_rivals_count_as_right_and_stand_ins_as_nothing() -> None:
    found, planted = make_diagnosis(), ["patch_width", "backlash"]
    told = {"right": ["patch_width"], "missing": ["backlash"], "too many": ["torque_offset"]}
    assert verdicts.judged(planted, found) == told
    carcass, offset = found.effects
    unsure = replace(found, effects=(carcass, replace(offset, grade="stands_in")))
    assert verdicts.judged(planted, unsure) == {**told, "too many": []}
    assert verdicts.judgement_cell(verdicts.judged([], make_diagnosis(found=False))) == (
        "right: –; missing: –; too many: –"
    )


@pytest.mark.long
def test_a_case_with_a_truth_is_judged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    tyre, known, untold = RigTyre(a=0.045, e=0.009, k=2.4e6), tmp_path / "known", tmp_path / "untold"
    known.mkdir()
    (known / "rig.toml").write_text(rig_toml(tyre), encoding="utf-8")
    for seed in (3, 4):
        made = make_recording(seed, {"carcass_torsion": {"k_t": 150.0}}, **vars(tyre), duration=6.0)
        (known / f"r{seed}.csv").write_text(recording_csv(made), encoding="utf-8")
    (known / "truth").write_text("carcass_torsion\nbacklash\n", encoding="utf-8")
    with monkeypatch.context() as few:
        few.setattr(verdicts, "diagnose", partial(diagnose, candidates=["carcass_torsion"]))
        found = verdicts.case(known, jobs=1)
    monkeypatch.setattr(verdicts, "case", lambda *_: found)
    header, _, *rows, counted = execute(
        "verdicts.py", tmp_path, known, untold, "--jobs", 1, "--out", "page.md"
    ).out.splitlines()

    assert header.endswith("| unexplained | judged |")
    assert rows[0].endswith("| right: carcass torsion; missing: backlash; too many: – |")
    assert rows[1].endswith("| – |")
    told = "effects planted: 2, right: 1, missing: 1, too many: 0."
    assert counted == f"Cases with a truth: 1; {told}"
    assert (tmp_path / "page.md").read_text(encoding="utf-8").endswith(f"\n\n{counted}\n")
