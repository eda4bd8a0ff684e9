"""Pictures of a diagnosis: signatures of the residual, and experiments."""

from dataclasses import replace
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from matplotlib.figure import Figure

from brushgrip.estimation.observe_recording import FrictionTrack
from brushgrip.pictures import diagnosis as diagnosis_pictures
from brushgrip.pictures.diagnosis import (
    _write_reasons_on_bars,
    draw_experiment,
    draw_residual_correlations,
    draw_residuals,
)
from brushgrip.pictures.friction import RECORDINGS, STYLES, draw_friction, draw_friction_by_ground
from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, QUIET
from tests.brushgrip.factories import TRACKS, experiment, make_diagnosis, signatures


def share(picture: np.ndarray, colour: str) -> float:
    """Share of pixels of a colour."""
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return float(np.mean(np.abs(picture[..., :3] - wanted).max(axis=-1) < 0.02))


def test_signatures_of_both_stages() -> None:
    pictures = []
    for before, after in ((signatures(1.0, 1.0), signatures(-1.0, 0.1)), (signatures(0.2, 0.3),) * 2):
        draw_residual_correlations(Path("signatures.png"), before, after)
        pictures.append(matplotlib.image.imread("signatures.png"))
    long, short = pictures

    assert share(long, AFTER) > 0.001
    assert share(long, BEFORE) > 2 * share(short, BEFORE) > 0.005, "longer bars cover more"
    assert share(short, QUIET) > 1e-4, "the band"
    for edge in (long[:2], long[-2:], long[:, :2], long[:, -2:]):
        assert edge[..., :3].min() > 0.99, "nothing is cut off"


def test_a_candidate_whose_figures_alone_mislead_says_why() -> None:
    diagnosis = make_diagnosis()
    torsion, offset = diagnosis.effects
    own = {c.name: c for c in diagnosis.candidates}
    late = replace(own[offset.name], delta_bic=7.6)
    better = replace(own["speed_law"], delta_bic=-85.1)
    ranked = (better, own["patch_width"], own[torsion.name], own["backlash"], late)
    axes = Figure().add_subplot()
    _write_reasons_on_bars(axes, replace(diagnosis, candidates=ranked))

    assert [text.get_text() for text in axes.texts] == [
        "no clear gain beside what was added", "", "", "", "helps once carcass torsion is in the model"
    ]  # fmt: skip
    assert [text.get_bbox_patch() for text in axes.texts] == [None] * 5, "its bar stays visible"
    assert (axes.texts[0].get_color(), axes.texts[4].get_color()) == (MEASURED, "white")


def test_residuals_name_their_torque_once(monkeypatch: pytest.MonkeyPatch) -> None:
    figures: list[Figure] = []
    monkeypatch.setattr(diagnosis_pictures, "legend_above", lambda figure, _: figures.append(figure))
    draw_residuals(Path("residuals.png"), make_diagnosis())

    assert figures[0].get_supylabel() == "model − recorded [N m]"
    assert {axes.get_ylabel() for axes in figures[0].axes} == {""}


def test_two_observers_that_agree_are_both_visible(tracks: list[FrictionTrack]) -> None:
    ekf = replace(tracks[1], mu=np.full(500, 1.3))
    path = Path("friction.png")
    draw_friction(path, [tracks[0], ekf, replace(ekf, label="MHE, model found")])
    # Below the legend, which has both.
    picture = matplotlib.image.imread(path)[200:]

    assert min(share(picture, STYLES[i].colour) for i in (1, 2)) > 2e-4


def test_the_overview_has_a_line_for_each_recording() -> None:
    path = Path("overview.png")
    draw_friction_by_ground(path, {"ice": TRACKS[:1], "steel": TRACKS[1:2]}, {"ice": (1.2, 0.3)})
    alone = matplotlib.image.imread(path)
    draw_friction_by_ground(path, {"": TRACKS[:2]}, {})
    together = matplotlib.image.imread(path)

    # A colour means one recording, on all grounds.
    for picture in (alone, together):
        assert min(share(picture, RECORDINGS[i]) for i in (0, 1)) > 5e-4
        assert share(picture, RECORDINGS[2]) < 1e-4
    assert alone.shape[0] > 1.5 * together.shape[0]
    # Ice has a band, in light grey.
    assert share(alone, "#e6e8ea") > share(together, "#e6e8ea") + 0.05


@pytest.mark.parametrize("load", [0.0, 30.0], ids=["held", "changed"])
def test_draws_an_experiment(load: float) -> None:
    instruction = (
        "sweep between -0.52 and 0.89 rad at 0.24 rad/s and, while the patch slides, slow down to 0.02"
        " rad/s for 0.11 rad twice in each sweep, load 308 N, 36 s"
    )
    path = Path("experiment.png")
    draw_experiment(path, experiment(load, instruction))

    assert path.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    assert path.stat().st_size > 20_000
