"""A verdict on each of several sets of recordings: what the model misses, error before and after.

    python examples/verdicts.py CASE... [--out FILE.md]

A case is a folder with a rig.toml and recordings (.csv); none is held out, each is left out in turn.
Prints one row of a table for each, in Markdown; `--out` writes the table to a file as well.
"""

import argparse
from pathlib import Path

from brushgrip.wording.diagnosis_in_words import GRADES
from brushgrip.wording.formatting import (
    effect_words,
    listed,
    parameter_list,
    percent,
    sentence,
    value_with_std,
)
from identification import Diagnosis, diagnose, read_recording, read_rig

OPENING = """# Verdicts

`python examples/verdicts.py CASE... --out docs/evidence/verdicts.md` writes this page.

A case is a folder of recordings from a rig that is not ours; what was planted in it is not known here.
After a look at case_1 two rules of the search were corrected: one law of a family goes before two that
do as well; no exchange makes a second law of a family. Nothing else was adjusted.

"Error" is that of the fit to all recordings, "left out" that of each by the shared parameters of the
others: root mean squares of the torque over its range, averaged. A stand-in is no finding: it explains
too little beside what is left, or a parameter of it is at the end of its range."""
HEADER = (
    "| case | the assumed model lacks | indistinguishable from | error before | after"
    " | left out, before | after | unexplained |\n|---|---|---|---:|---:|---:|---:|---|"
)


def case(folder: Path, jobs: int | None) -> Diagnosis:
    """The diagnosis of all recordings of a folder."""
    rig = read_rig(folder / "rig.toml")
    recordings = [read_recording(path, rig) for path in sorted(folder.glob("*.csv"))]
    return diagnose(recordings, jobs=jobs)


def row(name: str, diagnosis: Diagnosis) -> str:
    """One row of the table."""
    effects = [
        f"**{e.family}**: {effect_words(e.name)} ({parameter_list(e.parameters)}), {GRADES[e.grade]}"
        for e in diagnosis.effects
    ]
    rivals = [
        f"{effect_words(e.name)}: {listed([effect_words(r) for r in e.indistinguishable_from], 'or')}"
        for e in diagnosis.effects
        if e.indistinguishable_from
    ]
    before, after = diagnosis.before.summary(), diagnosis.after.summary()
    figures = [
        percent(summary[key])
        for key in ("torque_nrmse", "left_out_torque_nrmse")
        for summary in (before, after)
    ]
    unexplained = "yes" if diagnosis.unexplained.present else "no"
    cells = [name, "; ".join(effects) or "nothing", "; ".join(rivals) or "–", *figures, unexplained]
    return f"| {' | '.join(cells)} |"


def details(diagnoses: dict[str, Diagnosis]) -> list[str]:
    """A paragraph a case: k, what is left, its notes; first one with the notes that all cases have."""
    shared = [
        n for n in next(iter(diagnoses.values())).notes if all(n in d.notes for d in diagnoses.values())
    ]
    paragraphs = [" ".join(f"In every case: {sentence(note)}" for note in shared)] if shared else []
    for name, diagnosis in diagnoses.items():
        lines = [f"**{name}**: k = {value_with_std(diagnosis.parameters['k'])}."]
        if diagnosis.unexplained.present:
            lines.append(f"Left: {sentence(diagnosis.unexplained.evidence)}")
        lines += [f"Note: {sentence(note)}" for note in diagnosis.notes if note not in shared]
        paragraphs.append(" ".join(lines))
    return paragraphs


def main() -> None:
    """Diagnose every case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="+", type=Path)
    parser.add_argument("--out", type=Path)
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args()
    rows, diagnoses = [], {}
    print(HEADER)
    for folder in options.cases:
        diagnoses[folder.name] = case(folder, options.jobs)
        rows.append(row(folder.name, diagnoses[folder.name]))
        print(rows[-1], flush=True)
    if options.out:
        table = "\n".join([HEADER, *rows])
        text = "\n\n".join([OPENING, table, *details(diagnoses)])
        options.out.write_text(f"{text}\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
