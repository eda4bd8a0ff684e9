"""What the script on changing friction counts, on strokes and runs that are known."""

from pathlib import Path

import numpy as np
import pytest

from changing_friction import CHANGED, CONSTANT, Stroke, figures, runs_beside, strokes
from identification import Recording
from observers import Estimates, Status
from second_rig import LOAD, RIG, TYRE


def test_a_stroke_is_judged_by_its_last_quarter() -> None:
    t = np.arange(600) / 100
    psi, n = 0.25 * np.sin(np.pi * t), np.zeros(t.size)
    late = np.abs(psi) > 0.126
    slide = 0.375 * LOAD * RIG.a
    M_z = -np.sign(np.cos(np.pi * t)) * slide * np.where(late, 0.8, 0.3)
    recording = Recording(name="r", t=t, psi=psi, psi_dot=n, M_z=M_z, F_N=n + LOAD, rig=RIG, tyre=TYRE)
    status = np.where(np.abs(t - 2.0) < 0.004, int(Status.RESET), 0)
    found = Estimates(
        t=t, mu=n, mu_std=n, M_z_predicted=n, informed=n > 0, usable=n > 0, mu_eff=n + 0.9,
        mu_eff_std=n + 0.1, M_slide=n, nis=n, status=status, turn=n,
    )  # fmt: skip
    rows = strokes(recording, found)

    assert [round(row.begin, 1) for row in rows] == [0.5, 1.5, 2.5, 3.5, 4.5]
    assert [row.alarm for row in rows] == [False, True, False, False, False]
    for row in rows:
        assert (row.force, row.mu, row.std, row.usable) == pytest.approx((0.8, 0.9, 0.1, 0))


def test_figures_of_strokes_that_are_known() -> None:
    still = [Stroke(i, 1.0, 1.1 if i % 2 else 0.9, 0.06, i == 3, i / 4) for i in range(4)]
    forces = [1.0, 0.5, 1.0, 0.5, 1.3, 0.5, 1.4, 0.5]
    off = [1.0, 1.0, 1.0, 1.0, 1.05, 1.0, 1.2, 1.0]
    changed = [
        Stroke(i, f, f * o, 0.1 * f, i == 4, 0.25)
        for i, (f, o) in enumerate(zip(forces, off, strict=True))
    ]
    found = figures(dict.fromkeys(CONSTANT, still) | dict.fromkeys(CHANGED, changed))

    # Strokes after 3 s are judged: 4 in each run, of which one is 20 % off; one is a change by 30 %.
    assert found == ["10.0 %", "75 % of 24", "6 of 6", "6 of 24", "100 %", "88 %", "38 %", "25 %"]
    # Others are judged by the ratio of these: one that is told 20 % too high is not within 10 %.
    high = [stroke._replace(mu=1.2, usable=1.0) for stroke in still]
    runs = dict.fromkeys(CONSTANT, still) | {"tension_9lb_1Hz": high}
    assert figures(runs, ["tension_9lb_1Hz"], [])[0] == "20.0 %"
    assert figures(runs, ["tension_9lb_1Hz"], [])[1:] == [
        "– of 0", "0 of 0", "1 of 4", "0 %", "–", "100 %", "–",
    ]  # fmt: skip


def test_other_runs_of_the_data_set_are_found(tmp_path: Path) -> None:
    for name in (*CONSTANT, *CHANGED, "tension_9lb_1Hz", "step0.03forward", "harmonic_00", "notes"):
        (tmp_path / f"{name}.npz").touch()

    assert runs_beside(tmp_path) == (["tension_9lb_1Hz"], ["step0.03forward"])
