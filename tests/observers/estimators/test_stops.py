"""Friction of a joint that is stops in parallel, from the torque of many stops added up in numpy."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from observers import Ekf, Mhe, run
from symbolic import Model, effects_named
from tests.observers.conftest import RIG, K, make
from tests.observers.factories import CLEAN_RIG

pytestmark = pytest.mark.usefixtures("interpreted")
MU, LOAD, CHI = 1.3, 400.0, -0.4
SHAPE = {"stops.early": 1 / (1 + CHI), "stops.late": 0.0, "stops.plateau": 3.0}
STIFFNESS, LIMIT = 2 / 3 * K * RIG.a**3, 3 / 8 * MU * LOAD * RIG.a


def joint(psi: NDArray[np.float64]) -> NDArray[np.float64]:
    """M_z of [Segalman 2005] with beta = 0: 4,000 springs of equal stiffness, each behind a slider."""
    slips = ((np.arange(4000) + 0.5) / 4000) ** (1 / (1 + CHI))
    slips *= LIMIT / STIFFNESS / slips.mean()
    stretch, M_z = np.zeros_like(slips), [0.0]
    for before, now in pairwise(psi):
        stretch = np.clip(stretch + now - before, -slips, slips)
        M_z.append(-STIFFNESS * float(stretch.mean()))
    return np.array(M_z)


@pytest.mark.parametrize(
    ("kind", "settings"),
    [(Ekf, {}), pytest.param(Mhe, {"window": 20}, marks=pytest.mark.long)],
    ids=["ekf", "mhe"],
)
def test_friction_of_a_joint(kind: Any, settings: Any) -> None:
    t = np.arange(300) / 100
    psi = 6 * LIMIT / STIFFNESS * np.sin(5 * t) * (1 + 0.3 * np.sin(2 * t))
    M_z = joint(psi)
    noisy = M_z + 0.004 * np.ptp(M_z) * np.random.default_rng(8).standard_normal(t.size)
    columns = {"t": t, "psi": psi, "F_N": np.full(t.size, LOAD), "M_z": noisy}
    rig = replace(RIG, e=0.0)
    model = Model(effects=effects_named(["stops"]), bristles=24)

    seen = run(
        make(kind, model=model, values={"k": K, **SHAPE}, rig=rig, **CLEAN_RIG, **settings), **columns
    )
    declared = run(make(kind, rig=rig, **CLEAN_RIG, **settings), **columns)

    error = np.abs(seen.mu - MU)[150:]
    assert seen.informed[150:].all()
    assert error.max() < 0.02 * MU
    assert np.mean(error < 2 * seen.mu_std[150:]) > 0.9
    assert np.nanmean(seen.nis[150:]) < 1.5 < np.nanmean(declared.nis[150:])
