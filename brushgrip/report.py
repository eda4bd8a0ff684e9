"""The report: one page that needs nothing beside itself, and its pictures."""

from collections.abc import Sequence
from pathlib import Path

from brushgrip.formatting import doubts, headline, plain, remainder, sentence
from brushgrip.friction import FrictionTrack
from brushgrip.html import figure, heading, page, paragraph, section
from brushgrip.pictures import (
    draw_candidates,
    draw_experiment,
    draw_friction,
    draw_loops,
    draw_residuals,
    draw_signatures,
)
from brushgrip.report_tables import (
    candidates_table,
    effects_table,
    errors_table,
    friction_table,
    parameters_table,
    recordings_table,
    signatures_table,
)
from brushgrip.report_tables import notes as notes_list
from identification.results import Diagnosis

PAGE = "report.html"


def write_report(folder: Path, diagnosis: Diagnosis, friction: Sequence[FrictionTrack] = ()) -> Path:
    """Writes report.html and its pictures.

    Args:
        folder: an existing folder.
        diagnosis: what was found.
        friction: estimates of friction over time to show, may be empty.

    Returns:
        The page.
    """
    blocks = [
        _opening(diagnosis),
        _errors(diagnosis),
        _loops(folder, diagnosis),
        _residuals(folder, diagnosis),
        _signatures(folder, diagnosis),
        _candidates(folder, diagnosis),
        _effects(diagnosis),
        _experiments(folder, diagnosis),
    ]
    if friction:
        blocks.append(_friction(folder, friction))
    blocks.append(_unexplained(diagnosis))
    path = folder / PAGE
    text = page(headline(diagnosis), *blocks)
    path.write_text(text, encoding="utf-8", newline="\n")
    return path


def _opening(diagnosis: Diagnosis) -> str:
    training, holdout = len(diagnosis.recordings), len(diagnosis.holdout)
    if holdout:
        judged = f"{holdout} held out to judge every candidate and the result"
    elif training > 1:
        judged = "none held out: each was left out in turn to judge"
    else:
        judged = "none held out: with a single recording the errors are those of the fit itself"
    return (
        '<header>\n<p class="kind">brushgrip diagnosis</p>\n'
        f"{heading(headline(diagnosis))}\n"
        f"{paragraph(f'{doubts(diagnosis)} {remainder(diagnosis)}'.strip(), 'lead')}\n"
        f"{paragraph(f'{_count(training)} for training, {judged}.', 'faint')}\n</header>"
    )


def _count(number: int) -> str:
    return f"{number} recording{'s' * (number != 1)}"


def _errors(diagnosis: Diagnosis) -> str:
    return section(
        "Torque errors",
        paragraph(
            "Every recording is simulated freely from its first to its last sample. Declared: "
            "parameters as given, μ fitted where none is. Before: declared structure, k and each "
            "recording's μ refitted. After: with the effects found. On held-out recordings all "
            "shared parameters stay as trained; μ and, where the model has them, torque zero and "
            "starting twist are refitted."
        ),
        errors_table(diagnosis),
        recordings_table(diagnosis),
    )


def _loops(folder: Path, diagnosis: Diagnosis) -> str:
    path = folder / "loops.png"
    draw_loops(path, diagnosis)
    return section(
        "Hysteresis loops",
        figure(
            path,
            "Aligning torque over yaw angle: measured, before and after, for every recording.",
            "Torque over yaw angle, measured and simulated: one representative recording above, "
            "all others below, each with its error before → after in % of its torque range.",
        ),
    )


def _selection(shown: int, present: int) -> str:
    return "" if shown == present else f" Shown are {shown} of {present} recordings."


def _residuals(folder: Path, diagnosis: Diagnosis) -> str:
    path = folder / "residuals.png"
    shown = draw_residuals(path, diagnosis)
    return section(
        "Residuals",
        figure(
            path,
            "Simulated minus measured torque over time and over yaw angle, before and after.",
            "Simulated minus measured torque, left over time, right over yaw angle. What is "
            "only noise has no shape in either." + _selection(shown, len(diagnosis.series)),
        ),
    )


def _signatures(folder: Path, diagnosis: Diagnosis) -> str:
    path = folder / "signatures.png"
    draw_signatures(path, diagnosis.signatures_before, diagnosis.signatures_after)
    return section(
        "What the residual follows",
        paragraph(f"Before any effect is tried: {diagnosis.signatures_before.reading}"),
        paragraph(f"After the effects found: {diagnosis.signatures_after.reading}"),
        figure(
            path,
            "Autocorrelation of the residual, and its correlation with signals, before and after.",
            "Left: how long the residual remembers. Right: how far it follows each signal, with what "
            "chance leaves in 99 of 100 cases, the memory of both taken into account.",
        ),
        signatures_table(diagnosis),
    )


def _experiments(folder: Path, diagnosis: Diagnosis) -> str:
    figures = []
    for effect in diagnosis.effects:
        if effect.experiment:
            path = folder / f"experiment_{effect.name}.png"
            draw_experiment(path, effect.experiment)
            figures.append(
                figure(
                    path,
                    f"Angle, load and torque of the experiment proposed for {plain(effect.name)}.",
                    sentence(effect.experiment.sentence),
                )
            )
    return section("Next experiments", *figures) if figures else ""


def _candidates(folder: Path, diagnosis: Diagnosis) -> str:
    if not diagnosis.candidates:
        return ""
    path, criteria = folder / "candidates.png", diagnosis.criteria
    draw_candidates(path, diagnosis)
    return section(
        "Candidates",
        figure(
            path,
            "Torque error with each candidate effect alone, best on top.",
            "First step of the search: each effect alone on top of the declared structure, "
            "everything refitted. ΔBIC below zero speaks for the effect; up to "
            f"{criteria.strong:g} is allowed where the error of held-out recordings falls by more than "
            f"{criteria.clear:g} standard errors.",
        ),
        candidates_table(diagnosis),
    )


def _effects(diagnosis: Diagnosis) -> str:
    if diagnosis.effects:
        found = effects_table(diagnosis)
    else:
        found = paragraph("No effect earned its place; the declared structure stands.")
    return section("Effects found", found, parameters_table(diagnosis))


def _friction(folder: Path, friction: Sequence[FrictionTrack]) -> str:
    path = folder / "friction.png"
    draw_friction(path, friction)
    return section(
        "Friction over time",
        figure(
            path,
            "Estimated friction coefficient over time with its band of two standard deviations.",
            "Causal estimates: each value uses only samples up to its time. Bold where the "
            "estimate is informed by the recording, pale while it still rests on the prior.",
        ),
        friction_table(friction),
    )


def _unexplained(diagnosis: Diagnosis) -> str:
    blocks = [
        paragraph(remainder(diagnosis)),
        paragraph(sentence(diagnosis.unexplained.evidence), "faint"),
        notes_list(diagnosis.notes),
    ]
    return section("What remains unexplained", *blocks)
