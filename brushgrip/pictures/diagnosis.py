"""Pictures of a diagnosis: loops, residuals, what they follow, candidates, mechanisms, experiments."""

import re
from collections.abc import Sequence
from math import ceil
from pathlib import Path
from textwrap import fill

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from brushgrip.pictures.style import (
    AFTER,
    BEFORE,
    MEASURED,
    QUIET,
    figure_saved_as_png,
    legend_above,
    representative_first,
    set_title,
)
from brushgrip.wording.formatting import (
    candidate_outcome,
    candidate_reason,
    effect_words,
    listed,
    percent,
    signed,
)
from identification import Candidate, Curve, Diagnosis, FoundFamily, Proposal, Series, Signatures
from identification.loop_plot import matplotlib_text

Stage = tuple[Signatures, str, str]
"""Signatures of one stage of the model, their colour and their label."""
_STAGES = ((BEFORE, "refitted"), (AFTER, "found"))
MAX_RECORDINGS = 6
"""Most recordings in the picture of residuals; the representative and held-out ones come first."""
_MAX_COLUMNS = 4
"""Most small loops in a row."""
_INDISTINGUISHABLE = "#9cc3e0"
"""Colour of effects that are indistinguishable from an added one."""
_DECADE = 10.0
"""Ratio of greatest to least place from which an axis is logarithmic [1]."""
_TITLE_WIDTH = 130
"""Letters of a title that fit above the picture of an experiment."""


def draw_loops(path: Path, diagnosis: Diagnosis) -> None:
    """Draw torque over yaw angle: one recording large, all others small below it."""
    first, *others = representative_first(diagnosis)
    rows = ceil(len(others) / _MAX_COLUMNS)
    columns = max(2, ceil(len(others) / rows)) if rows else 1
    with figure_saved_as_png(path, 4.8 + 2.2 * rows) as figure:
        grid = figure.add_gridspec(rows + 1, columns, height_ratios=[4.4] + [2.2] * rows)
        large = figure.add_subplot(grid[0, :])
        artists = _loop(large, first, diagnosis)
        large.set(xlabel="yaw angle ψ [rad]", ylabel="aligning torque $M_z$ [N m]")
        for number, series in enumerate(others):
            small = figure.add_subplot(grid[1 + number // columns, number % columns])
            _loop(small, series, diagnosis, width=0.8)
            if number + columns >= len(others):
                small.set_xlabel("ψ [rad]")
            if number % columns == 0:
                small.set_ylabel("$M_z$ [N m]")
        legend_above(figure, artists)


def _loop(axes: Axes, series: Series, diagnosis: Diagnosis, width: float = 1.2) -> list[Artist]:
    curves = (
        (series.measured, QUIET, "recorded", 3.0),
        (series.before, BEFORE, "refitted", 0.9),
        (series.after, AFTER, "found", 0.9),
    )
    artists: list[Artist] = []
    for torque, colour, label, share in curves:
        artists += axes.plot(series.psi, torque, color=colour, lw=width * share, label=label)
    before, after = diagnosis.before.nrmse[series.name], diagnosis.after.nrmse[series.name]
    change = f"{percent(before)} → {percent(after)}"
    if width < 1:
        axes.set_title(f"{matplotlib_text(series.name)}\n{change}", fontsize=8)
    else:
        set_title(axes, series, f", error {change} of range")
    return artists


def draw_residuals(path: Path, diagnosis: Diagnosis) -> None:
    """Draw simulated minus recorded torque of `MAX_RECORDINGS` at most, before and after."""
    shown = representative_first(diagnosis)[:MAX_RECORDINGS]
    with figure_saved_as_png(path, 0.9 + 1.9 * len(shown)) as figure:
        grid = figure.add_gridspec(len(shown), 2, width_ratios=[2, 1])
        for row, series in enumerate(shown):
            over_time = figure.add_subplot(grid[row, 0])
            over_angle = figure.add_subplot(grid[row, 1], sharey=over_time)
            artists = _draw_residual(over_time, over_angle, series)
            set_title(over_time, series)
            over_angle.tick_params(labelleft=False)
        over_time.set_xlabel("time t [s]")
        over_angle.set_xlabel("yaw angle ψ [rad]")
        figure.supylabel("model − recorded [N m]", fontsize="medium")
        legend_above(figure, artists)


def _draw_residual(over_time: Axes, over_angle: Axes, series: Series) -> list[Artist]:
    artists: list[Artist] = []
    for torque, (colour, label) in zip((series.before, series.after), _STAGES, strict=True):
        residual = torque - series.measured
        artists += over_time.plot(series.t, residual, color=colour, lw=0.9, label=label)
        over_angle.plot(series.psi, residual, color=colour, lw=0.6, alpha=0.85)
    for axes in (over_time, over_angle):
        axes.axhline(0, color=MEASURED, lw=0.7)
    over_time.margins(x=0.01)
    return artists


def draw_residual_correlations(path: Path, before: Signatures, after: Signatures) -> None:
    """Draw the autocorrelation and the correlation with each signal, with 99 % bands."""
    stages: list[Stage] = [(before, *_STAGES[0]), (after, *_STAGES[1])]
    with figure_saved_as_png(path, 1.2 + 0.34 * len(before.signatures)) as figure:
        autocorrelation, correlations = figure.subplots(1, 2, width_ratios=[2, 3])
        _autocorrelation(autocorrelation, stages)
        _draw_correlations(correlations, stages)
        key: list[Artist] = [Patch(color=colour, label=label) for _, colour, label in stages]
        key.append(Patch(color=QUIET, label="99 % band of chance"))
        legend_above(figure, key)


def _autocorrelation(axes: Axes, stages: Sequence[Stage]) -> None:
    """Autocorrelation over lag; that of white noise stays within the band."""
    widest = max(signatures.autocorrelation.band for signatures, _, _ in stages)
    axes.axhspan(-widest, widest, color=QUIET, alpha=0.7, lw=0)
    for signatures, colour, _ in stages:
        series = signatures.autocorrelation
        axes.plot([0.0, *series.lags], [1.0, *series.values], color=colour)
    axes.axhline(0, color=MEASURED, lw=0.7)
    axes.set_ylim(top=1.04)
    axes.margins(x=0)
    axes.set(xlabel="lag [s]", ylabel="autocorrelation [1]", title="Autocorrelation of the residual")


def _draw_correlations(axes: Axes, stages: Sequence[Stage]) -> None:
    """Bars of correlation on the band of independent residuals of the same autocorrelation."""
    names = [signature.signal for signature in stages[0][0].signatures]
    height = 0.8 / len(stages)
    for number, (signatures, colour, _) in enumerate(stages):
        for row, signature in enumerate(signatures.signatures):
            y = row + (number - (len(stages) - 1) / 2) * height
            axes.barh(y, 2 * signature.band, left=-signature.band, height=height, color=QUIET, alpha=0.7)
            axes.barh(y, signature.correlation, height=0.55 * height, color=colour)
    axes.axvline(0, color=MEASURED, lw=0.7)
    axes.set_yticks(range(len(names)), names)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.set(xlim=(-1.02, 1.02), xlabel="correlation of model − recorded [1]")
    axes.set_title("Correlation of the residual with signals")


def draw_candidates(path: Path, diagnosis: Diagnosis) -> None:
    """Draw the error of each candidate as a bar, best on top, with error and ΔBIC as figures."""
    candidates = diagnosis.candidates
    with figure_saved_as_png(path, 1.3 + 0.26 * max(1, len(candidates))) as figure:
        axes = figure.add_subplot()
        errors = [100 * candidate.holdout_nrmse for candidate in candidates]
        colours = [_colour(diagnosis, candidate) for candidate in candidates]
        axes.barh(range(len(candidates)), errors, color=colours, height=0.7)
        axes.set_yticks(range(len(candidates)), [effect_words(c.name) for c in candidates])
        axes.invert_yaxis()
        axes.grid(visible=False, axis="y")
        share = diagnosis.before.summary()["holdout_torque_nrmse"]
        baseline = None if share is None else 100 * share
        _limit_error_axis(axes, errors, baseline)
        _write_error_and_bic(axes, candidates)
        _write_reasons_on_bars(axes, diagnosis)
        judged = "validation" if diagnosis.holdout else "left-out"
        axes.set_xlabel(f"{judged} torque error with this effect alone [% of range]")
        legend_above(figure, _candidate_legend(axes, diagnosis, baseline))


def _colour(diagnosis: Diagnosis, candidate: Candidate) -> str:
    text = candidate_outcome(diagnosis, candidate.name)
    return AFTER if text.startswith("added") else _INDISTINGUISHABLE if text else QUIET


def _limit_error_axis(axes: Axes, errors: list[float], baseline: float | None) -> None:
    """Limit the error axis, which begins at 0; bars far beyond the others are cut off at the right."""
    usual = max(sorted(errors)[: max(1, len(errors) // 2)], default=1.0)
    longest = max([*errors, baseline or 0.0, 1e-9])
    axes.set_xlim(0, 1.04 * min(longest, 2.5 * max(usual, baseline or 0.0, 1e-9)))


def _write_error_and_bic(axes: Axes, candidates: tuple[Candidate, ...]) -> None:
    beside = axes.get_yaxis_transform()
    rows = [("error", "ΔBIC", -1.0)] + [
        (f"{100 * c.holdout_nrmse:.2f} %", signed(c.delta_bic), float(row))
        for row, c in enumerate(candidates)
    ]
    for error, evidence, row in rows:
        for place, text in ((1.08, error), (1.17, evidence)):
            axes.text(place, row, text, transform=beside, ha="right", va="center", fontsize=8)


def _write_reasons_on_bars(axes: Axes, diagnosis: Diagnosis) -> None:
    """Say on its bar why a candidate was added or not where its own figures say otherwise."""
    added = [effect.name for effect in diagnosis.effects]
    first = next((row for row, c in enumerate(diagnosis.candidates) if c.name in added[:1]), 0)
    for row, candidate in enumerate(diagnosis.candidates):
        text, name = "", candidate.name
        if name in added[1:] and candidate.delta_bic >= 0:
            before = listed([effect_words(one) for one in added[: added.index(name)]])
            text = f"helps once {before} is in the model"
        elif row < first and not candidate_outcome(diagnosis, name):
            text = candidate_reason(diagnosis, candidate)
        # Letters of the bar's colour would not be seen on it, white ones not beside it.
        dark = _colour(diagnosis, candidate) == AFTER
        edge = [withStroke(linewidth=2.5, foreground=AFTER if dark else QUIET)]
        axes.text(
            *(0.01, row, text), transform=axes.get_yaxis_transform(), va="center", fontsize=8,
            color="white" if dark else MEASURED, path_effects=edge,
        )  # fmt: skip


def _candidate_legend(axes: Axes, diagnosis: Diagnosis, baseline: float | None) -> list[Artist]:
    key: list[Artist] = []
    if diagnosis.effects:
        key.append(Patch(color=AFTER, label="added to the model"))
    if any(effect.indistinguishable_from for effect in diagnosis.effects):
        key.append(Patch(color=_INDISTINGUISHABLE, label="cannot be told from an added one"))
    key.append(Patch(color=QUIET, label="not added"))
    if baseline is not None:
        label = f"no effect: {baseline:.2f} %"
        key.append(axes.axvline(baseline, color=BEFORE, lw=1.4, label=label))
    return key


def draw_mechanisms(path: Path, diagnosis: Diagnosis) -> None:
    """Draw the curve of each mechanism with its band of two standard deviations."""
    drawn = [(family, family.curve) for family in diagnosis.families if family.curve]
    rows = ceil(len(drawn) / 2)
    with figure_saved_as_png(path, 0.6 + 3.6 * rows) as figure:
        for number, (family, curve) in enumerate(drawn):
            artists = _curve(figure.add_subplot(rows, min(2, len(drawn)), number + 1), family, curve)
        legend_above(figure, artists)


def _curve(axes: Axes, family: FoundFamily, curve: Curve) -> list[Artist]:
    artists: list[Artist] = []
    artists += axes.plot(curve.x, curve.declared, color=BEFORE, label="assumed law, same parameters")
    artists += axes.plot(curve.x, curve.y, color=AFTER, label="found, with two standard deviations")
    known = np.isfinite(curve.std)
    if curve.x.min() > 0 and curve.x.max() > _DECADE * curve.x.min():
        axes.set_xscale("log")
    # A loop folds back, so that its band is drawn leg by leg.
    for leg in np.split(np.arange(curve.x.size), 1 + np.flatnonzero(np.diff(np.sign(np.diff(curve.x))))):
        at = leg[known[leg]]
        low, high = curve.y[at] - 2 * curve.std[at], curve.y[at] + 2 * curve.std[at]
        axes.fill_between(curve.x[at], low, high, color=AFTER, alpha=0.25, lw=0)
    of_friction = "internal friction μ [1]"  # Not μ_eff.
    label = of_friction if curve.y_unit == "1" else f"{curve.y_name} [{curve.y_unit}]"
    axes.set(xlabel=f"{curve.x_name} [{curve.x_unit}]", ylabel=label)
    laws = listed([effect_words(name) for name in family.effects])
    axes.set_title(f"{effect_words(family.name)}: {laws}")
    return artists


def draw_experiment(path: Path, proposal: Proposal) -> None:
    """Draw angle and load over time, the torques of the two models, and their difference."""
    manoeuvre = proposal.manoeuvre
    with figure_saved_as_png(path, 7.2) as figure:
        rows = figure.subplots(4, 1, sharex=True, height_ratios=[2.0, 1.0, 2.4, 1.4])
        angle, load, torques, difference = rows
        angle.plot(manoeuvre.t, manoeuvre.psi, color=MEASURED)
        # Each unit stays on the line of its number.
        title = re.sub(r"(?<=\d) (?=(?:rad|s|N)\b)", "\N{NO-BREAK SPACE}", manoeuvre.instruction)
        angle.set(ylabel="yaw angle ψ\n[rad]", title=fill(title, _TITLE_WIDTH))
        load.plot(manoeuvre.t, manoeuvre.F_N, color=MEASURED)
        load.set_ylabel("load $F_N$\n[N]")
        # By 5 % of the load at least, so that a constant load looks constant.
        low, high = load.get_ylim()
        middle, half = (low + high) / 2, max((high - low) / 2, 0.05 * (low + high) / 2)
        load.set_ylim(middle - half, middle + half)
        artists: list[Artist] = []
        for torque, name, colour, width in (
            (proposal.rival_torque, proposal.rival, BEFORE, 2.0),
            (proposal.torque, proposal.found, AFTER, 1.0),
        ):
            label = effect_words(name)
            artists += torques.plot(manoeuvre.t, torque, color=colour, lw=width, label=label)
        torques.set_ylabel("aligning torque\n$M_z$ [N m]")
        difference.plot(manoeuvre.t, proposal.torque - proposal.rival_torque, color=MEASURED)
        title = f"difference {percent(proposal.separation)} of range"
        difference.set(xlabel="time t [s]", ylabel="difference\n[N m]", title=title)
        figure.align_ylabels(rows)
        legend_above(figure, artists)
