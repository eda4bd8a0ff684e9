"""Which direction's friction is told at the end, against bristles whose limits differ by direction."""

import math
from dataclasses import replace

import numpy as np
import pytest

from brushgrip.estimation.friction_by_direction import friction_of_directions, hidden_by_zero
from brushgrip.estimation.observe_recording import model_observer, observe, observer_factory
from brushgrip.inputs.option_choices import ObserverName
from brushgrip.wording.friction_in_words import last_usable
from identification import Recording
from observers import DirectionalFriction, Ekf
from symbolic import Rig, Tolerances, Tyre

A, K, F_N, RATE, PERIOD = 0.045, 2.4e6, 500.0, 0.15, 0.01
TRUE = {"positive": 1.0, "negative": 0.6}


def turned(noise: float, seed: int, back: float, friction: float = 1.0) -> Recording:
    """To and fro by 0.2 rad, then back so far that the torque is let off, and a rest.

    Friction is that times `TRUE`.
    """
    corners = np.array([0.0, 0.2, -0.2, 0.2, -0.2, 0.2, 0.2 - back])
    ends = np.cumsum(np.abs(np.diff(corners, prepend=0.0))) / RATE
    t = np.arange(0.0, ends[-1] + 0.3, PERIOD)
    psi = np.interp(t, ends, corners)
    x = np.linspace(-A, A, 201)[1:-1]
    limit = friction * 0.75 * F_N / (A * K) * (1 - (x / A) ** 2)
    stress, M_z = np.zeros(x.size), []
    for turn in np.diff(psi, prepend=0.0):
        # Each half of the patch is dragged one way, and back when the wheel turns back.
        forth, fro = TRUE["positive"] * limit, TRUE["negative"] * limit
        twist = np.clip(np.sign(x) * stress + np.abs(x) * turn, -fro, forth)
        stress = np.sign(x) * twist
        M_z.append(-K * np.sum(stress * x) * (x[1] - x[0]))
    rng = np.random.default_rng(seed)
    rig = Rig(a=A, e=0.0, tolerances=Tolerances(a=0.0, e=0.0, load=0.005, k=1e5), noise=noise)
    return Recording(
        name="run", t=t, psi=psi, psi_dot=np.gradient(psi, t), F_N=np.full(t.size, F_N), rig=rig,
        tyre=Tyre(k=K), M_z=np.array(M_z) + noise * rng.standard_normal(t.size),
    )  # fmt: skip


def test_a_zero_that_is_not_declared_hides_low_friction() -> None:
    """Full slide at mu = 1 is 8.4 N m: 3 % are a quarter of mu = 0.12."""
    recording = turned(0.02, 0, 0.09)
    slippery = turned(0.02, 0, 0.09, friction=0.08)
    observer = model_observer(Ekf, slippery, aligning=DirectionalFriction())
    told = hidden_by_zero(observer, observe(lambda *_: observer, slippery))

    assert told.startswith("by direction, nothing below 0.12 is usable where the torque's zero is not")
    assert "[rig] zero = { tolerance" in told
    assert "leave --by-direction out" in told
    assert hidden_by_zero(observer, observe(lambda *_: observer, recording)) == ""
    single = model_observer(Ekf, slippery)
    assert hidden_by_zero(single, observe(lambda *_: single, slippery)) == ""
    tolerances = replace(recording.rig.tolerances, zero=0.02)
    declared = replace(slippery, rig=replace(recording.rig, tolerances=tolerances))
    observer = model_observer(Ekf, declared, aligning=DirectionalFriction())
    estimates = observe(lambda *_: observer, declared)
    assert estimates.usable.any()
    assert hidden_by_zero(observer, estimates) == ""


@pytest.mark.parametrize("noise", [0.02, 0.05, 0.2])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_direction_that_is_told_is_the_one_of_mu_eff(noise: float, seed: int) -> None:
    factory = observer_factory(ObserverName.EKF, None, DirectionalFriction())
    for back in (0.086, 0.087, 0.088, 0.09):
        recording = turned(noise, seed, back)
        estimates = observe(factory, recording)
        row, _ = friction_of_directions(estimates, recording.psi, recording.M_z, DirectionalFriction())
        at = last_usable(estimates)

        assert at is not None
        assert abs(recording.M_z[at]) < 0.1 * estimates.M_slide[at]
        way = str(row["direction"])
        assert estimates.mu_eff[at] == pytest.approx(TRUE[way], rel=0.05)
        assert row["weaker"] == pytest.approx({"positive": 0.4, "negative": 0.0}[way], abs=0.03)
        assert not math.isnan(float(row["mu_eff_positive"]))
