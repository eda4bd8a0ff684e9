"""The tables of the report: captions, headings and cells as text."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from brushgrip.estimation.friction_by_both_models import FrictionByBothModels, settling_and_coverage
from brushgrip.estimation.observe_recording import FrictionTrack
from brushgrip.report.friction_summary import (
    FIGURE_TEXTS,
    GROUP_LABELS,
    common_load_clause,
    common_load_text,
    last_usable_friction_text,
    median_loads,
    model_behind_friction_text,
    note_on_changing_friction,
    usable_span_text,
)
from brushgrip.wording.diagnosis_in_words import GRADES, parameter_words_and_owner, rivals_of
from brushgrip.wording.formatting import (
    candidate_parameters,
    candidate_reason,
    effect_words,
    listed,
    parameter_list,
    percent,
    signed,
    torque_error_text,
    value_with_std,
    worse_recordings,
)
from identification import Diagnosis, SignalCorrelation, TorqueErrors


@dataclass(frozen=True, kw_only=True)
class ReportTable:
    """A table whose first column names its rows."""

    caption: str
    headings: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: Sequence[int] = ()  # Columns that hold words; the others hold numbers, to the right.
    narrow: bool = False  # No wider than its content.


def friction_by_recording(friction: FrictionByBothModels, diagnosis: Diagnosis) -> ReportTable:
    """Friction of each recording, by ground: what the first screen shows."""
    tracks, named = friction.tracks_of(), any(friction.grounds)
    loads = median_loads(diagnosis)
    rows = [
        (
            *(name, *[ground or "–"][:named], f"{loads[name]:.0f}" if name in loads else "–"),
            *(last_usable_friction_text(tracks[name]), usable_span_text(tracks[name])),
        )
        for ground, names in friction.grounds.items()
        for name in sorted(names, key=lambda name: loads.get(name, 0.0))
        if name in tracks
    ]
    return ReportTable(
        caption="Last usable friction μ_eff of each recording"
        f" {model_behind_friction_text(friction, diagnosis)}, ± 95 % band (if model and tolerances are"
        " right), and when it is usable"
        + "; for a further recording the ± of the ground counts"
        * bool(friction.prediction_band_by_ground())
        + "; a dash where none is, or too much contradicts it later" * any(r[-2] == "–" for r in rows)
        + f"; {common_load_clause(friction)}" * (friction.load is not None)
        + "; --ground NAME says it for a further recording too" * (not named),
        headings=(
            *("recording", *["ground"][:named], "median load [N]"),
            *(f"μ_eff{common_load_text(friction)}", "usable"),
        ),
        rows=rows,
        words=(1, 4) if named else (3,),
    )


def settling_and_coverage_table(friction: FrictionByBothModels, diagnosis: Diagnosis) -> ReportTable:
    """Figures of settling and coverage before → after for each group, each with what it means."""
    rows = []
    groups = dict(reversed(friction.names_by_group().items()))
    stages = (friction.before, friction.after)
    for figure, (label, factor, text, words) in FIGURE_TEXTS.items():
        cells = []
        for names in groups.values():
            means = [settling_and_coverage(stage, names)[figure] for stage in stages]
            pair = " → ".join("–" if mean is None else text.format(factor * mean) for mean in means)
            known = min(sum(getattr(stage[n], figure) is not None for n in names) for stage in stages)
            # A mean over fewer recordings than there are says so.
            cells.append(pair + f" ({known} of {len(names)})" * (known < len(names)))
        rows.append((label, *cells, words))
    some = any(" of " in figure for _, *figures, _ in rows for figure in figures)
    return ReportTable(
        caption="Mean over recordings: by the assumed → by the model found"
        + ". In brackets: how many recordings have the figure" * some
        + note_on_changing_friction(diagnosis),
        headings=["figure", *(GROUP_LABELS[group] for group in groups), "in plain words"],
        rows=rows,
        words=(len(groups) + 1,),
    )


def friction_by_observer(tracks: Sequence[FrictionTrack]) -> ReportTable:
    """Friction by every observer at its last usable sample."""
    labels = dict.fromkeys(t.reference_label for t in tracks if t.reference is not None)
    alike: dict[tuple[str, ...], list[str]] = {}
    for t in tracks:
        reference = "–" if t.reference is None else f"{t.reference:.3f}"
        shown = (t.name, last_usable_friction_text(t), reference, usable_span_text(t))
        alike.setdefault(shown, []).append(t.label)
    return ReportTable(
        caption="Friction μ_eff ± 95 % band at the last usable sample; observers that agree share a row"
        + (f". Reference: {listed(list(labels))} afterwards" if labels else ""),
        headings=("recording", "observer", "μ_eff", "reference", "usable"),
        rows=[
            (name, listed(observers), friction, reference, usable)
            for (name, friction, reference, usable), observers in alike.items()
        ],
        words=(1, 4),
    )


def errors_by_stage(diagnosis: Diagnosis) -> ReportTable:
    """Mean errors of the three stages of the model."""
    columns = {"torque_rmse": "training [N m]", "torque_nrmse": "training [%]"}
    if diagnosis.holdout:
        columns |= {"holdout_torque_rmse": "validation [N m]", "holdout_torque_nrmse": "validation [%]"}
    if diagnosis.after.unrefitted:
        columns["holdout_torque_nrmse_unrefitted"] = "nothing adjusted [%]"
    if diagnosis.after.left_out:
        columns["left_out_torque_nrmse"] = "left out in turn [%]"
    means = {stage: errors.summary() for stage, errors in torque_errors_by_stage(diagnosis).items()}
    return ReportTable(
        caption="Torque error, root mean square, in N m and in % of range; mean of recordings",
        headings=("model", *columns.values()),
        rows=[
            (stage, *[(percent if "nrmse" in key else torque_error_text)(mean[key]) for key in columns])
            for stage, mean in means.items()
        ],
    )


def torque_errors_by_stage(diagnosis: Diagnosis) -> dict[str, TorqueErrors]:
    """Errors of each stage of the model, by its name in reports."""
    return {"assumed": diagnosis.declared, "refitted": diagnosis.before, "found": diagnosis.after}


def errors_by_recording(diagnosis: Diagnosis) -> ReportTable:
    """Errors of each recording; those that got worse are marked."""
    stages = torque_errors_by_stage(diagnosis)
    both = {name: stages[name] for name in ("refitted", "found")}
    worse = worse_recordings(diagnosis)
    headings = ["recording", "used for"]
    headings += [f"{stage} [{unit}]" for unit in ("N m", "%") for stage in stages]
    headings += [f"left out, {stage} [%]" for stage in both if diagnosis.after.left_out]
    headings += [f"nothing adjusted, {stage} [%]" for stage in both if diagnosis.after.unrefitted]
    rows = []
    for name in (*diagnosis.recordings, *diagnosis.holdout):
        row = [name, "validation" if name in diagnosis.holdout else "training"]
        row += [torque_error_text(errors.rmse[name]) for errors in stages.values()]
        row += [percent(errors.nrmse[name]) for errors in stages.values()]
        if diagnosis.after.left_out:
            row += [percent(errors.left_out[name]) for errors in both.values()]
        if diagnosis.after.unrefitted:
            row += [percent(errors.unrefitted.get(name)) for errors in both.values()]
        if worse:
            row.append(Markup('<span class="worse">▲ worse</span>') if name in worse else "")
        rows.append(row)
    return ReportTable(
        caption="Root mean square torque error of each recording, in N m and in % of its range; refitted"
        " to training alone, k may suit a validation recording worse",
        headings=[*headings, *[""][: len(worse)]],
        rows=rows,
        words=(1,),
    )


def residual_correlations(diagnosis: Diagnosis) -> ReportTable:
    """Signals that the residual of the refitted and of the found model follows, the strongest first."""
    after = {s.signal: s for s in diagnosis.signatures_after.signatures}
    before = sorted(diagnosis.signatures_before.signatures, key=lambda s: -abs(s.correlation))
    return ReportTable(
        caption="Correlation of the residual with each signal alone; in brackets the limit that chance"
        " exceeds in 1 of 100 cases, * beyond it",
        headings=("signal", "refitted", "found", "usual cause"),
        rows=[
            (
                s.signal,
                _correlation_cell(s),
                _correlation_cell(after[s.signal]),
                s.reading.removeprefix("usually ") if s.is_significant_and_large else "",
            )
            for s in before
        ],
        words=(3,),
    )


def _correlation_cell(signature: SignalCorrelation) -> str:
    if signature.band > 0.995:  # Nothing of the signal is left.
        return "fitted, not testable"
    mark = "*" if signature.is_significant else ""
    value = f"{signature.correlation:+.2f}".replace("-", "−")
    return f"{value if value.strip('+−0.') else '0.00'}{mark} ({signature.band:.2f})"


def candidates_table(diagnosis: Diagnosis) -> ReportTable:
    """Every candidate's first step."""
    return ReportTable(
        caption="Candidates as ranked: fitted coarsely, to thinned recordings, so that figures under"
        " “Effects found” differ; error in % of range",
        headings=(
            *("effect", "description", "parameters ± standard deviation"),
            *("error", "ΔBIC", "outcome"),
        ),
        rows=[
            (
                *(effect_words(c.name), c.summary.partition(";")[0]),
                candidate_parameters(c) or "by recording",
                *(percent(c.holdout_nrmse), signed(c.delta_bic), candidate_reason(diagnosis, c)),
            )
            for c in diagnosis.candidates
        ],
        words=(1, 2, 5),
    )


def effects_table(diagnosis: Diagnosis) -> ReportTable:
    """The effects found."""
    return ReportTable(
        caption="In order of selection; error of each beside those above it, ΔBIC beside all others, all"
        " fitted to the whole recordings",
        headings=(
            *("effect", "grade", "belongs to", "parameters ± standard deviation"),
            *("error with it", "ΔBIC", "indistinguishable from"),
        ),
        rows=[
            (
                *(effect_words(e.name), GRADES[e.grade]),
                "not known" if e.grade == "stands_in" else e.scope,
                *(parameter_list(e.parameters), percent(e.holdout_nrmse_after), signed(e.delta_bic)),
                rivals_of(e) or "–",
            )
            for e in diagnosis.effects
        ],
        words=(1, 2, 3, 6),
    )


def parameters_table(diagnosis: Diagnosis) -> ReportTable:
    """Every parameter of the model found, those of several recordings that agree in one row."""
    held_out = tuple(f" [{name}]" for name in diagnosis.holdout)
    owners: dict[tuple[str, str], list[str]] = {}
    for name, estimate in diagnosis.parameters.items():
        if name.startswith("mu ["):  # Of the model's own law, not to be quoted.
            continue
        label, owner = parameter_words_and_owner(name)
        known = value_with_std(estimate) + " *" * name.endswith(held_out)
        text = known if estimate.std is not None else f"{known}, not determined by these recordings"
        owners.setdefault((label, text), []).append(owner)
    labels = [label for label, _ in owners]
    return ReportTable(
        caption="Parameters of the model found (but its internal μ) ± standard deviation of the fit."
        " *: of a validation recording; shared parameters were kept fixed, so the ± is too small",
        headings=("parameter", "of", "value"),
        rows=sorted(
            ((label, listed(names) or "all", text) for (label, text), names in owners.items()),
            key=lambda row: labels.index(row[0]),
        ),
        words=(1,),
        narrow=True,
    )


def command_line(provenance: Mapping[str, Any]) -> str:
    """The command that made a report, its files without their folders, which concern no reader."""
    files = [*provenance["inputs"], *filter(None, (provenance.get("rig"), provenance.get("model")))]
    names = {file["name"] for file in files}

    def without_folder(word: str) -> str:
        last = re.split(r"[/\\]", word.rstrip("/\\"))[-1]
        return last if last in names or re.match(r"[/\\~.]|[A-Za-z]:[/\\]", word) else word

    words = ("".join(map(without_folder, re.split("([=,])", word))) for word in provenance["command"])
    return " ".join(words)


def files_read(provenance: Mapping[str, Any]) -> ReportTable:
    """Files that were read, with their digests."""
    files = [*provenance["inputs"], *filter(None, (provenance.get("rig"), provenance.get("model")))]
    digest = Markup('<code title="{0}">{1}</code>')
    return ReportTable(
        caption="Files that were read, and the digest of the model that was written",
        headings=("file", "SHA-256, first 16 digits"),
        rows=[(file["name"], digest.format(file["sha256"], file["sha256"][:16])) for file in files],
        words=(1,),
    )
