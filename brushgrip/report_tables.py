"""The tables of the report."""

from collections.abc import Sequence

import numpy as np

from brushgrip.formatting import (
    error_columns,
    error_figures,
    fate,
    listed,
    parameters,
    percent,
    plain,
    quantity,
    torque,
    worse,
)
from brushgrip.friction import FrictionTrack
from brushgrip.html import Cell, bullets, paragraph, table
from identification.parameter_estimate import ParameterEstimate
from identification.residuals.signatures import Signature
from identification.results import Diagnosis

STAGES = ("declared", "before", "after")


def errors_table(diagnosis: Diagnosis) -> str:
    """Errors of the three stages, averaged over training and over held-out recordings."""
    stages = (
        ("declared, parameters as given", diagnosis.declared),
        ("before, parameters refitted", diagnosis.before),
        ("after, with the effects found", diagnosis.after),
    )
    rows = [
        [Cell(label), *(_number(figure) for figure in error_figures(diagnosis, errors))]
        for label, errors in stages
    ]
    header = [Cell("model"), *(_number(name) for name in error_columns(diagnosis).values())]
    return table("Root mean square torque error, averaged over recordings", header, rows)


def recordings_table(diagnosis: Diagnosis) -> str:
    """Errors of the three stages for each recording; one that got worse is marked."""
    stages = (diagnosis.declared, diagnosis.before, diagnosis.after)
    left_out = stages[1:] if diagnosis.after.left_out else ()
    rows = []
    for name in (*diagnosis.recordings, *diagnosis.holdout):
        got_worse = worse(diagnosis, name)
        figures = [_number(torque(errors.rmse[name])) for errors in stages]
        figures += [_number(percent(errors.nrmse[name])) for errors in stages]
        figures += [_number(percent(errors.left_out[name])) for errors in left_out]
        role = "held out" if name in diagnosis.holdout else "training"
        mark = Cell("▲ worse" if got_worse else "", warn=got_worse)
        rows.append([Cell(name), Cell(role), *figures, mark])
    header = [
        Cell("recording"),
        Cell("used for"),
        *(_number(f"{stage} [N m]") for stage in STAGES),
        *(_number(f"{stage} [%]") for stage in STAGES),
        *(_number(f"left out, {stage} [%]") for stage in STAGES[1:] if left_out),
        Cell(""),
    ]
    caption = "Root mean square torque error of each recording, in N m and in % of its torque range"
    return table(caption, header, rows)


def signatures_table(diagnosis: Diagnosis) -> str:
    """What the residual follows before any effect is tried, and after; what stands out is marked."""
    after = {s.signal: s for s in diagnosis.signatures_after.signatures}
    rows = [
        [
            Cell(one.signal),
            _number(_correlation(one)),
            _number(_correlation(after[one.signal])),
            Cell(one.reading if one.stands_out else ""),
        ]
        for one in sorted(diagnosis.signatures_before.signatures, key=lambda s: -abs(s.correlation))
    ]
    header = [Cell("signal"), _number("before"), _number("after"), Cell("what usually leaves it")]
    caption = (
        "Correlation of the residual; in brackets what chance leaves in 99 of 100 cases, * beyond it"
    )
    return table(caption, header, rows)


def _correlation(signature: Signature) -> str:
    mark = "*" if signature.leaves_band else ""
    return f"{signature.correlation:+.2f}{mark} ({signature.band:.2f})".replace("-", "−")


def candidates_table(diagnosis: Diagnosis) -> str:
    """Candidates in order of their error, and what became of them."""
    rows = [
        [
            Cell(plain(candidate.name)),
            Cell(candidate.summary),
            _number(percent(candidate.holdout_nrmse)),
            _number(f"{candidate.delta_bic:+.1f}".replace("-", "−")),
            Cell(fate(diagnosis, candidate.name)),
        ]
        for candidate in diagnosis.candidates
    ]
    header = [
        Cell("effect"),
        Cell("what it is"),
        _number("error"),
        _number("ΔBIC"),
        Cell("outcome"),
    ]
    return table("Candidates, best first; error in % of range", header, rows)


def effects_table(diagnosis: Diagnosis) -> str:
    """Effects in order of selection with their parameters."""
    rows = []
    for effect in diagnosis.effects:
        alike = listed([plain(name) for name in effect.indistinguishable_from], "or")
        rows.append(
            [
                Cell(plain(effect.name)),
                Cell(effect.summary),
                Cell(parameters(effect.parameters)),
                _number(percent(effect.holdout_nrmse_after)),
                _number(f"{effect.delta_bic:+.1f}".replace("-", "−")),
                Cell(alike or "–"),
            ]
        )
    header = [
        Cell("effect"),
        Cell("what it is"),
        Cell("parameters ± standard deviation"),
        _number("error then"),
        _number("ΔBIC"),
        Cell("cannot be told from"),
    ]
    return table("In order of selection", header, rows)


def parameters_table(diagnosis: Diagnosis) -> str:
    """Every parameter of the final model."""
    rows = [
        [Cell(name), _number(quantity(estimate)), Cell(_remark(estimate))]
        for name, estimate in diagnosis.parameters.items()
    ]
    header = [Cell("parameter"), _number("value ± standard deviation"), Cell("")]
    caption = "All parameters of the final model; a recording's own ones carry its name"
    return table(caption, header, rows, narrow=True) if rows else ""


def friction_table(tracks: Sequence[FrictionTrack]) -> str:
    """Each track's final value, beside the reference, and its share of informative samples."""
    rows = []
    for track in tracks:
        std = float(track.mu_std[-1])
        final = ParameterEstimate(
            value=float(track.mu[-1]), std=std if np.isfinite(std) else None, unit="1"
        )
        reference = "–" if track.reference is None else f"{track.reference:.4g}"
        rows.append(
            [
                Cell(track.name),
                Cell(track.label),
                _number(quantity(final)),
                _number(reference),
                _number(f"{100 * float(np.mean(track.informed)):.0f} %"),
            ]
        )
    header = [
        Cell("recording"),
        Cell("observer"),
        _number("μ at the end ± standard deviation"),
        _number("reference"),
        _number("informed samples"),
    ]
    references = dict.fromkeys(t.reference_label for t in tracks if t.reference is not None)
    named = f"; reference: {listed(list(references))}" if references else ""
    return table(f"Friction at the last sample{named}", header, rows)


def notes(sentences: Sequence[str]) -> str:
    """The notes of a diagnosis."""
    return paragraph("Notes:") + bullets(sentences) if sentences else ""


def _number(text: str) -> Cell:
    return Cell(text, number=True)


def _remark(estimate: ParameterEstimate) -> str:
    return "" if estimate.std is not None else "not determined by these recordings"
