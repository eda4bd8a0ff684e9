"""The default tuning on the published measurements, beside the estimate published with them."""

from pathlib import Path

import numpy as np
import pytest

from identification import read_recording
from observers import Ekf, Mhe, run
from symbolic import Model

DECLARED = 1.674
"""Friction on steel, from towing a block: a reference of another rubber on another day."""
SETTLED = 1.89
"""Time from which [Györök 2022] scores its estimate [s], table 6.1."""
PSI, M_Z, ESTIMATE = 1, 3, 10


@pytest.mark.measured
@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ("name", "shift"), [("fem1", 190), ("fem3", 142), ("fem4_ident", 174), ("fem5", 92)]
)
def test_closer_to_the_declared_friction_than_the_published_estimate(
    measured_dir: Path, name: str, shift: int, kind: type[Ekf] | type[Mhe]
) -> None:
    published = measured_dir / f"author_estimate_{name.removesuffix('_ident')}.csv"
    if not published.exists():
        pytest.skip(f"no {published.name} beside the recordings")
    author = np.genfromtxt(published, delimiter=",")[1:]
    recording = read_recording(measured_dir / f"{name}.mat")
    same = slice(shift, shift + len(author))
    np.testing.assert_allclose(recording.psi[same], author[:, PSI], atol=1e-9)
    np.testing.assert_allclose(recording.M_z[same], author[:, M_Z], atol=1e-9)

    observer = kind(model=Model(), values={"k": recording.tyre.k}, rig=recording.rig)
    estimates = run(observer, recording.t, recording.psi, recording.F_N, recording.M_z)
    settled = author[:, 0] >= SETTLED
    ours, theirs = (
        np.sqrt(np.mean((mu[settled] - DECLARED) ** 2))
        for mu in (estimates.mu[same], author[:, ESTIMATE])
    )

    assert (observer.tuning.mu, observer.tuning.mu_std) == (1.0, 0.5)
    assert estimates.informed[same][settled].mean() > 0.7
    assert ours < theirs, f"{name}: rmse {ours:.3f}, published {theirs:.3f}"
