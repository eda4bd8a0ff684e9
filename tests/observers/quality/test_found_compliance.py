"""A model with a compliance, on turns too small to slide the whole patch."""

from dataclasses import replace

import numpy as np
import pytest

from observers import PROFILES, Ekf, run
from observers.planning.path import steer
from reference_rig import RIG_EFFECTS, RigTyre, free_path, simulate_bristles
from symbolic import Model, Rig, effects_named

PERIOD, LOAD = 0.01, 450.0
EFFECTS = ("carcass_torsion", "rate_friction")


def deviations(mu: float, rate: float, turns: tuple[float, float], **tuning: float) -> np.ndarray:
    """Usable deviations of mu over their standard deviation, on growing turns from rest."""
    rng = np.random.default_rng(0)
    sizes = np.append(np.geomspace(*turns, 4), np.full(40, turns[1]))
    points = [0.0, *(size * (-1) ** i for i, size in enumerate(sizes))]
    path = steer(points, rate, rate / 0.2, PERIOD, 8.0, rest=0.5)
    t = PERIOD * np.arange(path.psi.size)
    tyre = RigTyre(a=0.05, e=0.011, k=2.21e6, mu=mu)
    planted = [RIG_EFFECTS["rate_friction"](c=0.05), RIG_EFFECTS["carcass_torsion"](k_t=264.0)]
    truth = simulate_bristles(
        free_path(t, path.psi, load=LOAD, rate=1 / PERIOD), tyre, planted, bristles=800
    )
    observer = Ekf(
        model=Model(effects=effects_named(EFFECTS)),
        values={"k": 2.21e6, "carcass_torsion.k_t": 264.0, "rate_friction.c": 0.05},
        rig=Rig(a=0.05, e=0.011, J_A=0.05, b_t=0.1),
        tuning=replace(PROFILES["real_tyre"], **tuning),
    )
    M_z = truth.M_z + 0.04 * rng.standard_normal(t.size)
    found = run(observer, t, path.psi, np.full(t.size, LOAD), M_z)
    return np.abs(found.mu - mu)[found.usable] / found.mu_std[found.usable]


def test_small_turns_are_not_usable_and_wrong():
    # The memory of a mu that was not yet known once passed for torque: 10 deviations.
    sharp = {"error": 0.0036, "noise": 0.0078, "stiffness_std": 0.23, "error_travel": 0.03}
    assert (deviations(0.47, 0.35, (0.05, 0.05), **sharp, mu_walk=0.0012, mu_floor=0.004) < 3).all()


@pytest.mark.parametrize("mu", [0.1, 0.45, 0.8])
def test_turns_that_slide_the_whole_patch_are_usable_and_right(mu):
    usable = deviations(mu, 0.2, (0.05, 0.2), error=0.008)
    assert usable.size > 100
    assert (usable < 3).all()
