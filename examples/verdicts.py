"""A verdict on each of several sets of recordings: what the model misses, error before and after.

    python examples/verdicts.py CASE... [--out FILE.md]

A case is a folder with a rig.toml and recordings (.csv); none is held out, each is left out in turn.
Prints one row of a table for each, in Markdown; `--out` writes the table to a file as well.

Where the folder has a file `truth`, with the name of a planted effect a line, the row says which of them
are right and missing, and which effects are too many; a last line counts them. A planted effect is right
if it, or one that it is indistinguishable from, is named as likely or ambiguous; every further effect
named so is one too many.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

from brushgrip.wording.diagnosis_in_words import CLEAR, GRADES
from brushgrip.wording.formatting import (
    effect_words,
    listed,
    parameter_list,
    percent,
    sentence,
    value_with_std,
)
from identification import Diagnosis, diagnose, read_recording, read_rig
from symbolic import effects_named

OPENING = """# Verdicts

`python examples/verdicts.py CASE... --out docs/evidence/verdicts.md` writes this page.

A case is a folder of recordings from a rig that is not ours; what was planted in it is not known here,
unless it has a file `truth`, with the name of an effect a line: then the row is judged.
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


def planted_in(folder: Path) -> list[str] | None:
    """Names of the effects planted in a case, none where nothing was; None where nobody says."""
    if not (truth := folder / "truth").is_file():
        return None
    return [effect.name for effect in effects_named(truth.read_text(encoding="utf-8").split())]


def judged(planted: Sequence[str], diagnosis: Diagnosis) -> dict[str, list[str]]:
    """Planted effects that were found and were not, and effects said to be missing that are not."""
    missing, too_many = [*planted], []
    said = [effect for effect in diagnosis.effects if effect.grade in CLEAR]
    for effect in sorted(said, key=lambda effect: effect.name not in planted):
        names = (effect.name, *effect.indistinguishable_from)
        if found := next((name for name in names if name in missing), None):
            missing.remove(found)
        else:
            too_many.append(effect.name)
    right = [name for name in planted if name not in missing]
    return {"right": right, "missing": missing, "too many": too_many}


def judgement_cell(found: Mapping[str, Sequence[str]]) -> str:
    """Names for each word; a dash for none."""
    return "; ".join(f"{word}: {listed([*map(effect_words, n)]) or '–'}" for word, n in found.items())


def count_of(judgements: Sequence[Mapping[str, Sequence[str]]]) -> str:
    """How many are right, missing and too many in all cases with a truth."""
    numbers = {word: sum(len(found[word]) for found in judgements) for word in judgements[0]}
    planted = numbers["right"] + numbers["missing"]
    told = ", ".join(f"{word}: {number}" for word, number in numbers.items())
    return f"Cases with a truth: {len(judgements)}; effects planted: {planted}, {told}."


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
    rows, diagnoses, judgements = [], {}, []
    planted = {folder: planted_in(folder) for folder in options.cases}
    is_judged = any(names is not None for names in planted.values())
    header = HEADER.replace("\n", " judged |\n") + "---|" if is_judged else HEADER
    print(header)
    for folder, names in planted.items():
        diagnoses[folder.name] = found = case(folder, options.jobs)
        cell = "–"
        if names is not None:
            judgements.append(judged(names, found))
            cell = judgement_cell(judgements[-1])
        rows.append(row(folder.name, found) + f" {cell} |" * is_judged)
        print(rows[-1], flush=True)
    counted = [count_of(judgements)] if is_judged else []
    print(*counted, sep="\n", end="\n" * is_judged)
    if options.out:
        table = "\n".join([header, *rows])
        text = "\n\n".join([OPENING, table, *details(diagnoses), *counted])
        options.out.write_text(f"{text}\n", encoding="utf-8", newline="\n")


if __name__ == "__main__":
    main()
