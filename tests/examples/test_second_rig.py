"""What the second rig's script works out by itself."""

import numpy as np
import pytest

from identification import Recording
from second_rig import RIG, TYRE, place_in_gap
from symbolic import Model, effects_named, simulate

pytestmark = pytest.mark.usefixtures("interpreted")
MODEL = Model(effects=effects_named(["backlash", "pretwist"]), discretised=True, bristles=16)
VALUES = {"mu": 1.0, "k": 1e5, "backlash.gap": 0.05, "pretwist.psi_0": 0.0}


@pytest.mark.parametrize("first", [0.08, -0.08])
def test_path_begins_at_the_flank_that_the_first_torque_presses(first: float) -> None:
    t = np.arange(3) / 100
    still = Recording(
        name="r", t=t, psi=0 * t, psi_dot=0 * t, M_z=first + 0 * t, F_N=50 + 0 * t, rig=RIG, tyre=TYRE
    )

    placed = place_in_gap(MODEL, VALUES, still)

    assert placed["pretwist.psi_0"] == pytest.approx(-np.sign(first) * 0.025, rel=0.01)
    theta = np.asarray(MODEL.theta(VALUES | placed)).ravel()
    way = -np.sign(first)
    signals = np.array([[0.0, 0.002 * way], [0.0, 0.2 * way], [50.0, 50.0], [0.01, 0.01]])
    there = simulate(MODEL, signals, theta, np.array([RIG.a, RIG.e]))
    # Turned on against that flank the patch answers at once, with half a gap to go it would not.
    assert abs(there.M_z[1]) > 0.05
    assert np.sign(there.M_z[1]) == np.sign(first)
    assert place_in_gap(Model(), {"mu": 1.0, "k": 1e5}, still) == {}
