"""The whole search repeated without each recording in turn, which then judges what came out.

    python examples/left_out_search.py [DATA] [--out FILE.md]

Prints one row of a table for each recording as it is done, in Markdown; `--out` writes the table to a
file. A search a recording: some minutes on two cores for the measured ones.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from brushgrip.wording.formatting import effect_words, percent
from identification import Recording, diagnose
from identification.diagnosis.unrefitted_prediction import unrefitted_residuals
from identification.selection.trial import Trial, TrialTask, run_trial
from published import measured_folder, measured_recordings

OPENING = """# The search without the recording that judges

`python examples/left_out_search.py --out docs/evidence/left_out_search.md` writes this page.

Each of the eight measured recordings is left out in turn, and the whole search runs on the other seven:
neither the effects nor the shared parameters have seen the recording that judges. Only its own μ is
fitted to it, and its torque zero, drift of the zero or starting twist where the search named one. With
"nothing adjusted" μ comes from the other recordings on its ground, by their loads.

Errors are root mean squares of the torque over its range, "before" with the declared structure, "after"
with the effects named. The library and the rules of the search were designed with all eight in sight,
last that a length which follows the load is a mechanism of its own: before, the means after were 1.43
and 2.45 %."""
HEADER = (
    "| left out | before | after | nothing adjusted, before | after | named without it |\n"
    "|---|---:|---:|---:|---:|---|"
)


FIGURES = ("before", "after", "unrefitted_before", "unrefitted_after")


@dataclass(frozen=True, kw_only=True)
class SearchScore:
    """What one search came to: its effects, and the errors over range on the recording left out [1]."""

    name: str
    before: float
    after: float
    unrefitted_before: float
    unrefitted_after: float
    effects: tuple[str, ...]

    def row(self) -> str:
        """Its row of the table."""
        named = ", ".join(effect_words(effect) for effect in self.effects) or "nothing"
        figures = " | ".join(percent(getattr(self, figure)) for figure in FIGURES)
        return f"| {self.name} | {figures} | {named} |"


def search_without(recordings: list[Recording], judge: Recording) -> SearchScore:
    """Search in all the others, judge on this one."""
    others = [r for r in recordings if r is not judge]
    diagnosis = diagnose(others)
    effects = diagnosis.model.effects
    declared = run_trial(TrialTask((), others, [judge]))
    named = run_trial(TrialTask(effects, others, [judge], start=diagnosis.values))
    return SearchScore(
        name=judge.name,
        before=declared.nrmse,
        after=named.nrmse,
        unrefitted_before=unrefitted(declared, others, judge),
        unrefitted_after=unrefitted(named, others, judge),
        effects=named.names,
    )


def unrefitted(trial: Trial, others: list[Recording], judge: Recording) -> float:
    """Error over range where nothing of the recording's own is fitted."""
    (residual,) = unrefitted_residuals(trial.fitted, others, [judge]).values()
    return float(np.sqrt(np.nanmean(residual**2)) / np.nanmax(judge.M_z - np.nanmin(judge.M_z)))


def summary(scores: list[SearchScore]) -> str:
    """The last row of the table, and what remains of the error."""
    means = [float(np.mean([getattr(j, figure) for j in scores])) for figure in FIGURES]
    row = f"| mean | {' | '.join(percent(mean) for mean in means)} | |"
    return f"{row}\n\nWhat remains of the error: {means[1] / means[0]:.2f}."


def main() -> None:
    """Leave out, search, judge."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", nargs="?", type=Path)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    folder = options.data or measured_folder()
    recordings = measured_recordings(folder)
    if options.out and not options.out.parent.is_dir():
        parser.error(f"there is no folder {options.out.parent}; make it first")
    if len(recordings) < 3:
        parser.error(f"{folder} holds {len(recordings)} recordings; three are needed")
    lines = [HEADER]
    print(HEADER)
    scores: list[SearchScore] = []
    for judge in recordings:
        scores.append(search_without(recordings, judge))
        lines.append(scores[-1].row())
        print(lines[-1], flush=True)
    lines.append(summary(scores))
    print(lines[-1])
    if options.out:
        options.out.write_text("\n".join([f"{OPENING}\n", *lines, ""]), "utf-8")


if __name__ == "__main__":
    main()
