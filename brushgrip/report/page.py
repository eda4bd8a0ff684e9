"""The report: one page that needs no other file, and its pictures."""

import base64
import re
from collections.abc import Callable, Container, Mapping, Sequence
from inspect import getmembers, isfunction
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from brushgrip.estimation.friction_by_both_models import FrictionByBothModels, found_model
from brushgrip.estimation.observe_recording import FrictionTrack
from brushgrip.outputs.atomic import write_utf8
from brushgrip.pictures.diagnosis import (
    MAX_RECORDINGS,
    draw_candidates,
    draw_experiment,
    draw_loops,
    draw_mechanisms,
    draw_residual_correlations,
    draw_residuals,
)
from brushgrip.pictures.friction import draw_friction, draw_friction_by_ground
from brushgrip.pictures.style import is_drawn_by_us, picture_as_png_and_svg
from brushgrip.report import (
    friction_summary,
    next_steps,
    plain_summary,
    tables,
    validity_and_missing_effects,
    what_effects_do,
)
from brushgrip.wording import diagnosis_in_words, formatting
from brushgrip.wording import friction_in_words as friction_wording
from identification import Diagnosis
from identification.selection.trial_runner import Submit, results_of, run_in_this_process

PAGE, TEMPLATE = "report.html", "report.html.j2"
EXPERIMENT = "experiment_{}"
"""Picture of the experiment that is proposed for an effect, by its name."""
DRAWN = ("loops", "residuals", "signatures", "candidates", "friction", "overview", "mechanisms")
STEMS = (*DRAWN, EXPERIMENT.format(r"\w+"))
"""Pictures of a report, by their names without suffix."""
_PICTURES = re.compile(rf"({'|'.join(STEMS)})\.png")
_MAX_DRAWING_SIZE = 3_000_000
"""Bytes of a drawing that the page takes."""
_MAX_LINE_SAMPLES = 100_000
"""Samples of all recordings that are drawn as lines; of more the page takes points."""
_WORDING_MODULES = (
    formatting,
    diagnosis_in_words,
    friction_wording,
    friction_summary,
    what_effects_do,
    validity_and_missing_effects,
    next_steps,
    plain_summary,
)
"""Modules whose public functions the template uses, as functions and as filters."""


def write_report(
    folder: Path,
    diagnosis: Diagnosis,
    friction: Sequence[FrictionTrack] = (),
    outcome: FrictionByBothModels | None = None,
    provenance: Mapping[str, Any] | None = None,
    submit: Submit = run_in_this_process,
) -> Path:
    """Writes report.html and its pictures.

    Args:
        folder: an existing folder.
        diagnosis: the result of the search.
        friction: estimates of friction over time to show, may be empty.
        outcome: friction before and after, recording by recording; None where none was estimated.
        provenance: of the results, see `brushgrip.outputs.provenance`; None where nobody says.
        submit: takes the drawing of pictures to processes.

    Returns:
        The page.
    """
    drawings = _draw_pictures(folder, diagnosis, friction, outcome, submit)
    template = _jinja_environment(folder, drawings).get_template(TEMPLATE)
    text = template.render(
        diagnosis=diagnosis,
        friction=friction,
        friction_outcome=outcome,
        provenance=provenance,
        residuals_shown=min(MAX_RECORDINGS, len(diagnosis.series)),
        compared=len({track.name for track in friction}),
        model=found_model(diagnosis),
        tables=tables,
    )
    write_utf8(folder / PAGE, text)
    return folder / PAGE


def remove_stale_pictures(folder: Path, written: Container[str]) -> None:
    """Removes what an earlier report drew and this one did not; all other files stay."""
    for path in folder.glob("*.png"):
        if path.name not in written and _PICTURES.fullmatch(path.name) and is_drawn_by_us(path):
            path.unlink()


def _draw_pictures(
    folder: Path,
    diagnosis: Diagnosis,
    friction: Sequence[FrictionTrack],
    outcome: FrictionByBothModels | None,
    submit: Submit,
) -> dict[str, bytes]:
    """Writes the pictures; returns those that the page takes as drawings, by names of files."""
    pictures: dict[str, tuple[Callable[..., None], Sequence[Any]]] = {
        "residuals": (draw_residuals, [diagnosis]),
        "loops": (draw_loops, [diagnosis]),
        "signatures": (
            draw_residual_correlations,
            [diagnosis.signatures_before, diagnosis.signatures_after],
        ),
    }
    if friction:
        pictures["friction"] = draw_friction, [friction]
    if diagnosis.candidates:
        pictures["candidates"] = draw_candidates, [diagnosis]
    for effect in diagnosis.effects:
        if effect.experiment:
            pictures[EXPERIMENT.format(effect.name)] = draw_experiment, [effect.experiment]
    if outcome:
        own = outcome.tracks_of()
        by_ground = {g: [own[n] for n in names if n in own] for g, names in outcome.grounds.items()}
        ends = {
            g: (one.mu_eff, one.further or 0.0) for g, one in outcome.prediction_band_by_ground().items()
        }
        pictures["overview"] = draw_friction_by_ground, [by_ground, ends]
    if any(family.curve for family in diagnosis.families):
        pictures["mechanisms"] = draw_mechanisms, [diagnosis]
    wanted = sum(series.t.size for series in diagnosis.series) <= _MAX_LINE_SAMPLES
    futures = {
        f"{stem}.png": submit(picture_as_png_and_svg, draw, f"{stem}.png", content, wanted)
        for stem, (draw, content) in pictures.items()
    }
    drawings = {}
    for name, (points, lines) in results_of(futures).items():
        (folder / name).write_bytes(points)
        if lines is not None:
            drawings[name] = lines
    return drawings


def _jinja_environment(folder: Path, drawings: Mapping[str, bytes]) -> Environment:
    """The templates, with pictures of a folder and the words of `_WORDING_MODULES`."""
    environment = Environment(
        loader=PackageLoader("brushgrip.report"),
        autoescape=True,
        undefined=StrictUndefined,
        finalize=_with_nonbreaking_units,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    words: dict[str, Callable[..., object]] = {
        name: word
        for module in _WORDING_MODULES
        for name, word in getmembers(module, isfunction)
        if word.__module__ == module.__name__  # Others came by import.
    }
    environment.filters |= words
    environment.globals |= words | {
        "grades": diagnosis_in_words.GRADES,
        "headings": lambda sections: re.findall(r'<h2 id="(\w+)">(.+)</h2>', sections),
        "picture": lambda name: _picture_data_uri(folder / name, drawings.get(name)),
    }
    return environment


def _with_nonbreaking_units(value: Any) -> Any:
    """A text whose percent signs, deviations and units stay on the line of what they belong to."""
    if not isinstance(value, str) or isinstance(value, Markup):
        return value
    together = (
        r"(?<=[\d)]) (%|± ?)|± (?=\d)|\[N m\]|(?<=[\d⁰¹²³⁴⁵⁶⁷⁸⁹]) (?=(N|m|mm|s|rad)\b)|\bN (?=m\b)"
    )
    apart = re.sub(r"(?<=\d)%(?!\w)", " %", value)
    return re.sub(together, lambda found: found[0].replace(" ", "\N{NO-BREAK SPACE}"), apart)


def _picture_data_uri(png: Path, drawing: bytes | None) -> Markup:
    """A picture as an address that holds its content: a drawing, or where that is too large, points."""
    kind, content = "png", png.read_bytes()
    if drawing is not None and len(drawing) <= _MAX_DRAWING_SIZE:
        kind, content = "svg+xml", drawing
    # Nothing in it is to be escaped, and it is too long to be searched for units.
    return Markup(f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}")
