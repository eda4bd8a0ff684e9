"""The default tuning on the published measurements, beside the estimate published with them."""

from pathlib import Path

import numpy as np
import pytest

from observers import Ekf, Mhe, run
from symbolic import Model
from tests.observers.published import DECLARED, M_Z, MU, SETTLED, STEEL, TIME, published, rms


@pytest.mark.measured
@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
@pytest.mark.parametrize(("name", "shift"), STEEL)
def test_closer_to_the_declared_friction_than_the_published_estimate(
    measured_dir: Path, name: str, shift: int, kind: type[Ekf] | type[Mhe]
) -> None:
    recording, author, same = published(measured_dir, name, shift)
    np.testing.assert_allclose(recording.M_z[same], author[M_Z], atol=1e-9)

    observer = kind(model=Model(), values={"k": recording.tyre.k}, rig=recording.rig)
    estimates = run(observer, recording.t, recording.psi, recording.F_N, recording.M_z)
    settled = author[TIME] >= SETTLED
    ours, theirs = (rms(mu[settled] - DECLARED) for mu in (estimates.mu[same], author[MU]))

    assert (observer.tuning.mu, observer.tuning.mu_std) == (1.0, 0.5)
    assert estimates.informed[same][settled].mean() > 0.7
    assert ours < theirs, f"{name}: rmse {ours:.3f}, published {theirs:.3f}"
