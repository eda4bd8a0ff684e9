from pathlib import Path

import numpy as np
import pytest

from brushgrip.pictures import draw_experiment
from identification.experiments.discriminating_experiment import Proposal
from identification.experiments.steering import Manoeuvre


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
