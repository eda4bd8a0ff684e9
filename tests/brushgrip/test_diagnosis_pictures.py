"""Pictures of a diagnosis: signatures of the residual, and experiments."""

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from brushgrip.pictures import draw_experiment, draw_signatures
from brushgrip.pictures.style import AFTER, BEFORE, QUIET
from tests.brushgrip.factories import experiment, signatures


def share(picture: np.ndarray, colour: str) -> float:
    """Share of pixels of a colour."""
    wanted = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    return float(np.mean(np.abs(picture[..., :3] - wanted).max(axis=-1) < 0.02))


@pytest.mark.parametrize("with_after", [True, False])
def test_both_stages_and_the_band_are_drawn(tmp_path: Path, with_after: bool) -> None:
    path = tmp_path / "signatures.png"
    draw_signatures(path, signatures(0.8, 0.3), signatures(0.05, 0.1) if with_after else None)
    picture = matplotlib.image.imread(path)

    assert share(picture, BEFORE) > 0.02
    assert (share(picture, AFTER) > 0.001) == with_after
    assert share(picture, QUIET) > 1e-4


def test_nothing_is_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "signatures.png"
    draw_signatures(path, signatures(1.0, 1.0), signatures(-1.0, 0.1))
    picture = matplotlib.image.imread(path)[..., :3]

    for edge in (picture[:2], picture[-2:], picture[:, :2], picture[:, -2:]):
        assert edge.min() > 0.99


def test_longer_bars_cover_more(tmp_path: Path) -> None:
    shares = []
    for strength in (0.2, 0.9):
        path = tmp_path / f"{strength}.png"
        draw_signatures(path, signatures(strength, 0.3))
        shares.append(share(matplotlib.image.imread(path), BEFORE))

    assert shares[1] > 2 * shares[0]


@pytest.mark.parametrize("load", [0.0, 30.0], ids=["held", "changed"])
def test_draws_an_experiment(tmp_path: Path, load: float) -> None:
    instruction = (
        "sweep between -0.52 and 0.89 rad at 0.24 rad/s and, while the patch slides, slow down to 0.02"
        " rad/s for 0.11 rad twice in each sweep, load 308 N, 36 s"
    )
    path = tmp_path / "experiment.png"
    draw_experiment(path, experiment(load, instruction))

    assert path.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    assert path.stat().st_size > 20_000
