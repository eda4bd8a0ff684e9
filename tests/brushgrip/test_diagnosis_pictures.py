"""Pictures of a diagnosis: signatures of the residual, and experiments."""

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from brushgrip.pictures import draw_experiment, draw_signatures
from brushgrip.pictures.style import AFTER, BEFORE, QUIET
from identification.experiments.proposals import Proposal
from identification.experiments.steering import Manoeuvre
from identification.residuals.signals import RESIDUAL_SIGNALS, effects_leaving
from identification.residuals.signatures import Autocorrelation, Signature, Signatures
from symbolic import EFFECTS


def signatures(strength: float, band: float) -> Signatures:
    lags = 0.01 * np.arange(1, 201)
    return Signatures(
        rms=0.01,
        autocorrelation=Autocorrelation(
            lags=lags, values=np.exp(-lags / band) * np.cos(3 * lags), band=0.04, memory=0.5
        ),
        signatures=tuple(
            Signature(
                signal=signal.name,
                unit=signal.unit,
                correlation=strength * (-1) ** number,
                band=band,
                slope=1.0,
                size=0.01 * strength,
                effects=effects_leaving(signal, 1, EFFECTS.values()),
                reading=signal.positive,
            )
            for number, signal in enumerate(RESIDUAL_SIGNALS)
        ),
        followed=(),
    )


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
    t = np.arange(500) * 0.02
    manoeuvre = Manoeuvre(
        instruction="sweep between -0.52 and 0.89 rad at 0.24 rad/s and, while the patch slides, slow "
        "down to 0.02 rad/s for 0.11 rad twice in each sweep, load 308 N, 36 s",
        t=t,
        psi=np.sin(t),
        psi_dot=np.cos(t),
        F_N=400 + load * np.sign(np.sin(t)),
    )
    proposal = Proposal(
        found="stribeck", rival="rate_friction", manoeuvre=manoeuvre, torque=5 * np.sin(t),
        rival_torque=5 * np.sin(t) + 0.1 * np.cos(t), separation=0.01, now=0.002, noise=0.004, times=1,
        standard_errors=5.0,
    )  # fmt: skip
    path = tmp_path / "experiment.png"
    draw_experiment(path, proposal)

    assert path.read_bytes().startswith(b"\x89PNG\r\n\x1a\n")
    assert path.stat().st_size > 20_000
