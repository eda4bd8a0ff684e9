"""From the declared model to the one found, on the measured recordings: writes two pages with figures.

    python examples/walk_through.py [DATA] --out docs/evidence/measured.md

DATA holds the recordings (`brushgrip fetch`); default: see published.py. What came out goes to OUT, how
it was found to measured_search.md beside it. Their text is in walk_through.in.md and
walk_through_search.in.md beside this script; every number and picture in them is made here. Some minutes
on two cores.
"""

import argparse
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from brushgrip.pictures.diagnosis import draw_loops, draw_residual_correlations, draw_residuals
from brushgrip.report.tables import errors_by_stage
from brushgrip.wording.formatting import (
    effect_words,
    listed,
    percent,
    sentence,
    value_with_std,
)
from identification import Diagnosis, Recording, diagnose
from identification.fits.covariance import covariance
from identification.fits.fitting import fit
from identification.selection.trial import RANKING, model_of, thin_for_ranking
from published import measured_folder, measured_recordings
from symbolic import EFFECTS

TRAINING = ("fem1", "fem4_ident", "piros2_ident", "piros4")
PUBLISHED_K = 2.438e6
"""k of [Györök 2022], from free vibration [N/m^2]."""
SPOKEN_OF = (
    {"frictional_creep", "tared_pretwist", "pressure_skew", "friction_drift"},
    {"frictional_creep", "tared_pretwist", "patch_width", "friction_drift"},
)
"""Effects that the text of the page explains: of the search with four held out, and with none."""
SPOKEN_VALUES = {
    "twist": "tared_pretwist.psi_0",
    "tare": "tared_pretwist.M_0",
    "scale": "friction_drift.scale",
    "steel": "friction_drift.gain [steel]",
    "emery": "friction_drift.gain [emery]",
}
"""Parameters that it tells, of the first of these searches, by their keys in the template."""
TEMPLATE, SEARCH_TEMPLATE = (
    Path(__file__).with_name(f"walk_through{part}.in.md") for part in ("", "_search")
)
SEARCH = "measured_search.md"


def errors_table(diagnosis: Diagnosis) -> str:
    """Errors of the three stages."""
    table = errors_by_stage(diagnosis)
    _, *heads = table.headings
    lines = [f"| model | {' | '.join(heads)} |", "|---|" + "---:|" * len(heads)]
    stages = ("assumed", "refitted: k and μ fitted", "found: with the effects")
    for name, (_, *cells) in zip(stages, table.rows, strict=True):
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def effects_table(diagnosis: Diagnosis) -> str:
    """Effects in order, with parameters and the effects from which they are indistinguishable."""
    lines = [
        "| effect | parameters | judged error then | ΔBIC | indistinguishable from |",
        "|---|---|---:|---:|---|",
    ]
    for effect in diagnosis.effects:
        values = "; ".join(f"{n} = {value_with_std(e)}" for n, e in effect.parameters.items())
        rivals = listed([effect_words(name) for name in effect.indistinguishable_from], "or") or "–"
        lines.append(
            f"| {effect_words(effect.name)} | {values} | {percent(effect.holdout_nrmse_after)}"
            f" | {effect.delta_bic:+.0f} | {rivals} |".replace("-", "−")
        )
    return "\n".join(lines)


def recordings_table(diagnosis: Diagnosis) -> str:
    """Every recording left out in turn, before and after."""
    lines = ["| recording | before | after |", "|---|---:|---:|"]
    before, after = diagnosis.before.left_out, diagnosis.after.left_out
    lines += [f"| {name} | {percent(before[name])} | {percent(after[name])} |" for name in before]
    return "\n".join(lines)


def vibration(diagnosis: Diagnosis, training: Sequence[Recording]) -> tuple[str, str]:
    """Stiffness about the kingpin at 45 mm [N m/rad]: of the published k, and of what was found.

    The latter with its deviation, for which k and k_t have to be taken together.
    """
    a, e = 0.045, 0.009
    per_k = 2 * (a**3 / 3 + a * e**2)
    thinned = [thin_for_ranking(recording) for recording in training]
    fitted = fit(model_of(diagnosis.model.effects, RANKING), thinned, diagnosis.values)
    k = fitted.values.tyre["k"]
    compliance = 1 / (per_k * k)
    slope = np.zeros(len(fitted.labels))
    slope[fitted.labels.index((None, "k"))] = -compliance / k
    carcass = "carcass_torsion.k_t"
    if carcass in fitted.values.tyre:
        # Its coordinate is the compliance.
        compliance += 1 / fitted.values.tyre[carcass]
        slope[fitted.labels.index((None, carcass))] = 1
    spread = np.sqrt(slope @ covariance(fitted, thinned) @ slope) / compliance**2
    return f"{per_k * PUBLISHED_K:.0f}", f"{1 / compliance:.0f} ± {spread:.0f}"


def figures(
    split: Diagnosis, seconds: float, whole: Diagnosis, recordings: Sequence[Recording]
) -> Mapping[str, str]:
    """Everything that the template asks for."""
    published, series = vibration(split, [r for r in recordings if r.name in TRAINING])
    return {
        **{
            key: value_with_std(split.parameters[name]) if name in split.parameters else "–"
            for key, name in SPOKEN_VALUES.items()
        },
        "split_errors": errors_table(split),
        "split_effects": effects_table(split),
        "repeats": percent(split.repeatability and split.repeatability.spread),
        "floor": percent(split.repeatability and split.repeatability.nrmse),
        "split_seconds": f"{seconds:.0f}",
        "split_k": value_with_std(split.parameters["k"]),
        "whole_errors": errors_table(whole),
        "whole_effects": effects_table(whole),
        "whole_recordings": recordings_table(whole),
        "reading_before": sentence(split.signatures_before.summary_paragraph),
        "reading_after": sentence(split.signatures_after.summary_paragraph),
        "evidence": sentence(split.unexplained.evidence.split(". ")[0]),
        "experiments": "\n".join(
            f"- {sentence(e.experiment.sentence)}" for e in split.effects if e.experiment
        ),
        "published": published,
        "series": series,
        "count": str(len(EFFECTS)),
    }


def draw(folder: Path, split: Diagnosis) -> None:
    """The pictures beside the page."""
    folder.mkdir(parents=True, exist_ok=True)
    draw_residual_correlations(
        folder / "signatures.png", split.signatures_before, split.signatures_after
    )
    draw_loops(folder / "loops.png", split)
    draw_residuals(folder / "residuals.png", split)


def _progress(began: float) -> Callable[[str, int, int], None]:
    def report(message: str, done: int, total: int) -> None:
        if done == 0:
            print(f"{time.perf_counter() - began:6.0f} s  {message} ({total})", file=sys.stderr)

    return report


def main() -> None:
    """Diagnose twice and write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", nargs="?", type=Path, default=measured_folder())
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args()
    recordings = measured_recordings(options.data)
    if not recordings:
        sys.exit(f"no recordings in {options.data}; `brushgrip fetch` downloads them")
    training = [r for r in recordings if r.name in TRAINING]
    holdout = [r for r in recordings if r.name not in TRAINING]
    began = time.perf_counter()
    split = diagnose(training, holdout, jobs=options.jobs, progress=_progress(began))
    seconds = time.perf_counter() - began
    whole = diagnose(recordings, jobs=options.jobs, progress=_progress(began))
    for diagnosis, names in zip((split, whole), SPOKEN_OF, strict=True):
        if {effect.name for effect in diagnosis.effects} != names:
            print(f"the text of {TEMPLATE.name} describes other effects: revise it", file=sys.stderr)
    draw(options.out.with_suffix(""), split)
    told = figures(split, seconds, whole, recordings)
    for template, path in ((TEMPLATE, options.out), (SEARCH_TEMPLATE, options.out.with_name(SEARCH))):
        page = template.read_text("utf-8").format_map(told)
        path.write_text(page, encoding="utf-8", newline="\n")
    print(f"{options.out}: held out {figures_line(split, whole)}")


def figures_line(split: Diagnosis, whole: Diagnosis) -> str:
    """The two results in one line."""
    split_errors = [percent(e.summary()["holdout_torque_nrmse"]) for e in (split.before, split.after)]
    whole_errors = [percent(e.summary()["left_out_torque_nrmse"]) for e in (whole.before, whole.after)]
    by_split, in_turn = (" -> ".join(errors) for errors in (split_errors, whole_errors))
    return f"{by_split}, left out in turn {in_turn}"


if __name__ == "__main__":
    main()
