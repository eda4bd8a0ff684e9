"""Which direction's friction is told at the end, against bristles whose limits differ by direction."""

import math
from dataclasses import replace

import numpy as np
import pytest

from brushgrip.estimation.friction_by_direction import (
    directional_friction_and_line,
    hidden_by_torque_zero_note,
)
from brushgrip.estimation.observe_recording import model_observer, observe, observer_factory
from brushgrip.inputs.option_choices import ObserverName
from brushgrip.wording.friction_in_words import estimates_summary
from identification import Recording
from observers import DirectionalFriction, Ekf, Status
from observers.quality.when_usable import last_usable
from symbolic import Rig, Tolerances, Tyre
from tests.brushgrip.factories import rising

pytestmark = pytest.mark.usefixtures("interpreted")
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
    told = hidden_by_torque_zero_note(observer, observe(lambda *_: observer, slippery))

    assert told.startswith("by direction, nothing below 0.12 is usable where the torque's zero is not")
    assert "[rig] zero = { tolerance" in told
    assert "leave --by-direction out" in told
    assert hidden_by_torque_zero_note(observer, observe(lambda *_: observer, recording)) == ""
    single = model_observer(Ekf, slippery)
    assert hidden_by_torque_zero_note(single, observe(lambda *_: single, slippery)) == ""
    tolerances = replace(recording.rig.tolerances, zero=0.02)
    declared = replace(slippery, rig=replace(recording.rig, tolerances=tolerances))
    observer = model_observer(Ekf, declared, aligning=DirectionalFriction())
    estimates = observe(lambda *_: observer, declared)
    assert estimates.usable.any()
    assert hidden_by_torque_zero_note(observer, estimates) == ""


@pytest.mark.parametrize("noise", [0.02, 0.05, 0.2])
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_direction_that_is_told_is_the_one_of_mu_eff(noise: float, seed: int) -> None:
    factory = observer_factory(ObserverName.EKF, None, DirectionalFriction())
    for back in (0.086, 0.087, 0.088, 0.09):
        recording = turned(noise, seed, back)
        estimates = observe(factory, recording)
        row, _ = directional_friction_and_line(
            estimates, recording.psi, recording.M_z, DirectionalFriction()
        )
        at = last_usable(estimates)

        assert at is not None
        assert abs(recording.M_z[at]) < 0.1 * estimates.M_slide[at]
        way = str(row["direction"])
        assert estimates.mu_eff[at] == pytest.approx(TRUE[way], rel=0.05)
        assert row["weaker"] == pytest.approx({"positive": 0.4, "negative": 0.0}[way], abs=0.03)
        assert not math.isnan(float(row["mu_eff_positive"]))


def test_friction_of_each_direction_is_of_the_last_ground() -> None:
    seen = rising(*[Status.USED] * 20)
    seen = replace(seen, M_z_predicted=np.where(np.arange(20) < 15, 1.0, -1.0))
    steps, aligning = np.where(np.arange(20) < 15, -0.01, 0.01), DirectionalFriction()
    psi, M_z = np.cumsum(steps), seen.M_z_predicted
    row, line = directional_friction_and_line(seen, psi, M_z, aligning)

    assert line == (
        "mu_eff by direction, last usable: 1.25 ± 0.08 turning to positive psi, at 0.19 s;"
        " 1.18 ± 0.08 turning to negative psi, at 0.14 s"
    )
    assert row["mu_eff_negative"] == pytest.approx(1.184, abs=1e-3)
    assert (row["direction"], row["weaker"]) == ("positive", pytest.approx(1 - 1.184 / 1.25, abs=2e-3))
    assert "(95 % band) turning to positive psi at the end" in estimates_summary(
        seen, (0, ""), way="positive"
    )
    # Exchanged where the angle turns back, mu is not of the direction whose torque is not let off yet.
    later = replace(seen, M_z_predicted=np.where(np.arange(20) < 17, 1.0, -1.0))
    _, line = directional_friction_and_line(later, psi, M_z, replace(aligning, at_reversal=True))
    assert line.endswith("turning to negative psi, at 0.14 s")
    # What was usable on the ground before says nothing of this one.
    reset = np.where(np.arange(20) == 15, int(Status.RESET), 0)
    row, line = directional_friction_and_line(replace(seen, status=reset), psi, M_z, aligning)
    assert line.endswith("; not usable since the ground changed at 0.15 s, turning to negative psi")
    assert "mu_eff_negative" not in row
    assert row["direction"] == "positive"
    assert math.isnan(float(row["weaker"]))
    # A torque about zero tells nothing of a direction but of the one that is told, and a wheel that
    # rests has none.
    small = replace(seen, M_z_predicted=0.4 * seen.M_z_predicted)
    row, line = directional_friction_and_line(small, psi, M_z, aligning)
    told = "1.25 ± 0.08 turning to positive psi, at 0.19 s; never usable turning to negative psi"
    assert line.endswith(f": {told}")
    assert (row["direction"], row["mu_eff_positive"]) == ("positive", seen.mu_eff[-1])
    row, line = directional_friction_and_line(small, np.zeros(20), M_z, aligning)
    assert (list(row), row["direction"], line) == (["direction", "weaker"], "", "")


@pytest.mark.parametrize(
    ("turn", "M_z", "flag", "way"),
    [
        (1e-3, -0.1, Status.USED, "positive"),
        (1e-3, 0.1, Status.USED, "negative"),
        # Noise of the angle is no turn.
        (1e-4, -0.1, Status.USED, "negative"),
        (1e-3, np.nan, Status.USED, "positive"),
        # The sensor's zero has moved.
        (1.0, -0.1, Status.IMPLAUSIBLE, "negative"),
    ],
)
def test_the_direction_is_exchanged_where_the_torque_opposes_the_motion(
    turn: float, M_z: float, flag: Status, way: str
) -> None:
    seen, i = rising(*[Status.USED] * 20), np.arange(20)
    flags = np.where((i > 15) & (i < 18), int(flag), 0)
    seen = replace(seen, M_z_predicted=1.0 * (i < 15), status=flags)
    psi, M_z = np.where(i > 15, turn, 0.0) - 0.01 * np.minimum(i, 14), np.where(i < 15, 1.0, M_z)
    row, _ = directional_friction_and_line(seen, psi, M_z, DirectionalFriction())

    assert row["direction"] == way
