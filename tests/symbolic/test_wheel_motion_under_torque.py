from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from reference_rig import RigTyre, Wheel, simulate_steering
from symbolic import (
    InvalidInputError,
    Rig,
    TorqueProfile,
    Tyre,
    WheelMotion,
    lateral_deformation,
    simulate_motion,
    zone_boundaries,
)

LOAD = 180.0
RIG, TYRE = Rig(a=0.02, e=0.01, J_A=0.1, b_t=0.4827), Tyre(k=6e4, mu=0.5)
NESTED = TorqueProfile(t=(0.0, 1.2, 2.2, 5.1), M=(0.15, 0.42, 0.02, 0.5))
"""Two turns back, the second inside the first loop, which then closes: 3, 5, 7 and 3 zones."""
LOOSE = Rig(a=0.045, e=-0.012, J_A=0.15, b_t=0.3)
STIFF = Tyre(k=2.4e6, mu=1.3)
RINGING = TorqueProfile(t=(0.0, 0.1, 0.6, 0.7, 2.0), M=(0.0, 11.0, -7.0, 3.0, 3.0))
"""Fast against the wheel's own 30 Hz: it swings after every corner, so loops nest and close often."""


def against_rig(
    rig: Rig, tyre: Tyre, load: float, profile: TorqueProfile, step: float, bristles: int = 2000
) -> float:
    """The largest difference of M_z from bristles in small steps, in shares of the range."""
    t = np.arange(round(profile.t[-1] / step) + 1) * step
    assert rig.J_A is not None
    assert rig.b_t is not None
    assert tyre.mu is not None
    load_and_ground = np.full_like(t, load), np.full_like(t, tyre.mu)
    of_rig = {"tyre": RigTyre(a=rig.a, e=rig.e, k=tyre.k), "wheel": Wheel(J_A=rig.J_A, b_t=rig.b_t)}
    other = simulate_steering(
        profile.torque_at(t), *load_and_ground, step=step, bristles=bristles, **of_rig
    )
    ours = simulate_motion(rig, tyre, profile, load, duration=t[-1], rate=1 / step)
    return float(np.max(np.abs(ours.M_z - other.M_z)) / np.ptp(other.M_z))


def test_agrees_with_the_reference_rig() -> None:
    assert against_rig(RIG, TYRE, LOAD, NESTED, 1e-3) < 1e-5


def test_agrees_where_the_wheel_swings() -> None:
    coarse, fine = (against_rig(LOOSE, STIFF, 400.0, RINGING, step) for step in (2e-3, 5e-4))

    # The rig's step is what is left: second order, down to its bristles' 4e-6.
    assert fine < 5e-5
    assert fine < 0.1 * coarse


@pytest.mark.parametrize("seed", range(12))
def test_random_motions_agree_with_the_rig(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, mu, load = rng.uniform(0.02, 0.06), rng.uniform(0.3, 2.0), rng.uniform(100.0, 600.0)
    own = {"e": a * rng.uniform(-0.8, 0.8), "J_A": rng.uniform(0.05, 0.4)}
    rig = Rig(a=a, **own, b_t=rng.choice([0.0, 0.05, 2.0]))
    legs = int(rng.integers(2, 9))
    torques = 0.375 * mu * load * a * rng.uniform(-1.1, 1.1, legs + 1)
    torques[0] *= rng.integers(0, 2)
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.02, 0.5, legs))]).round(4)
    profile = TorqueProfile(t=tuple(times.tolist()), M=tuple(torques.tolist()))

    tyre = Tyre(k=10 ** rng.uniform(4.7, 6.5), mu=mu)
    assert against_rig(rig, tyre, load, profile, 2e-4, bristles=1000) < 5e-4


def test_nested_turns_open_and_close_zones() -> None:
    motion = simulate_motion(RIG, TYRE, NESTED, LOAD)
    changes = motion.zone_count[np.flatnonzero(np.diff(motion.zone_count, prepend=0))]

    assert changes.tolist() == [1, 3, 5, 7, 3]


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_error_falls_with_the_tolerance(tolerance: float) -> None:
    exact = simulate_motion(RIG, TYRE, NESTED, LOAD, tolerance=1e-11)
    found = simulate_motion(RIG, TYRE, NESTED, LOAD, tolerance=tolerance)

    error = np.max(np.abs(found.M_z - exact.M_z)) / np.ptp(exact.M_z)
    assert 0.01 * tolerance < error < 2 * tolerance


@pytest.mark.parametrize(
    ("rig", "tyre", "load", "profile"), [(RIG, TYRE, LOAD, NESTED), (LOOSE, STIFF, 400.0, RINGING)]
)
def test_energy_is_kept(rig: Rig, tyre: Tyre, load: float, profile: TorqueProfile) -> None:
    motion = simulate_motion(rig, tyre, profile, load, rate=20_000.0)
    torques = (motion.M, (rig.b_t or 0.0) * motion.psi_dot, -motion.M_z)
    given, damped, patch = (work(motion, torque) for torque in torques)
    kinetic = 0.5 * (rig.J_A or 0.0) * motion.psi_dot**2

    assert np.max(np.abs(given - damped - patch - kinetic)) < 1e-6 * np.max(given)
    for i in range(0, len(motion.t), 2000):
        x = rig.a * (np.arange(-1999, 2000, 2) / 2000)
        q = lateral_deformation(x, float(motion.psi[i]), motion.memory[i], load, rig, tyre)
        stored = 0.5 * tyre.k * np.sum(q**2) * (2 * rig.a / 2000)
        # What the patch took and did not store has gone into friction, which never gives it back.
        assert patch[i] >= stored - 1e-6 * np.max(given)


def work(motion: WheelMotion, torque: np.ndarray) -> np.ndarray:
    """Work of a torque up to every sample [N m]."""
    power = torque * motion.psi_dot
    return np.concatenate([[0.0], np.cumsum(0.5 * np.diff(motion.t) * (power[1:] + power[:-1]))])


def test_deformation_makes_the_torque_and_its_kinks_are_the_boundaries() -> None:
    motion = simulate_motion(RIG, TYRE, NESTED, LOAD)
    x = RIG.a * (np.arange(-9999, 10000, 2) / 10000)
    for i in (500, 1750, 3000, 5100):
        q = lateral_deformation(x, float(motion.psi[i]), motion.memory[i], LOAD, RIG, TYRE)
        summed = TYRE.k * float(q @ (x - RIG.e)) * (2 * RIG.a / 10000)

        assert summed == pytest.approx(motion.M_z[i], abs=1e-6 * np.ptp(motion.M_z))
    x = np.linspace(-RIG.a, RIG.a, 40_001)
    for i in (500, 1750, 3000, 5100):
        psi, memory = float(motion.psi[i]), motion.memory[i]
        q = lateral_deformation(x, psi, memory, LOAD, RIG, TYRE)
        # Within a zone q is a parabola, whose third differences vanish.
        kinks = x[1:-2][np.abs(np.diff(q, 3)) > 1e-10]
        expected = zone_boundaries(psi, memory, LOAD, RIG, TYRE)

        assert len(expected) == motion.zone_count[i] - 1
        assert np.max(np.min(np.abs(expected[:, None] - kinks[None, :]), axis=1)) < 3e-6
        assert np.max(np.min(np.abs(expected[:, None] - kinks[None, :]), axis=0)) < 3e-6


def test_rate_of_the_result_does_not_matter() -> None:
    fine = simulate_motion(RIG, TYRE, NESTED, LOAD, rate=1000.0)
    coarse = simulate_motion(RIG, TYRE, NESTED, LOAD, rate=10.0)

    np.testing.assert_array_equal(coarse.psi, fine.psi[::100])
    assert coarse.steps == fine.steps


def test_no_torque_no_motion() -> None:
    motion = simulate_motion(RIG, TYRE, TorqueProfile(t=(0.0,), M=(0.0,)), LOAD, duration=2.0)

    assert not np.any(motion.psi)
    assert set(motion.zone_count) == {1}


def test_comes_to_rest_and_stays() -> None:
    # The swings die away into the tolerance of the steps; turning points must not pile up there.
    held = TorqueProfile(t=(0.0, 0.05), M=(0.0, 4.0))
    motion = simulate_motion(replace(LOOSE, b_t=1.5), STIFF, held, 400.0, duration=60.0)

    late = motion.t > 50
    assert np.ptp(motion.psi[late]) < 1e-5 * motion.psi[-1]
    assert np.max(np.abs(motion.M_z[late] + 4.0)) < 4e-5
    assert max(len(memory.psi) for memory in motion.memory) < 200
    assert motion.steps < 20_000


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rig": replace(RIG, J_A=None)}, "J_A and b_t"),
        ({"tyre": replace(TYRE, mu=None)}, "tyre's mu"),
        ({"load": 0.0}, "the load must be"),
        ({"duration": float("nan")}, "duration must be"),
        ({"rate": 0.0}, "rate must be"),
        ({"tolerance": -1.0}, "tolerance must be"),
    ],
)
def test_bad_input(change: dict[str, object], message: str) -> None:
    given = {"rig": RIG, "tyre": TYRE, "profile": NESTED, "load": LOAD} | change
    with pytest.raises(InvalidInputError, match=message):
        simulate_motion(**given)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("t", "M", "message"),
    [
        ((0.0, 1.0), (0.0,), "as many torques"),
        ((), (), "as many torques"),
        ((0.0, 0.0), (0.0, 1.0), "increase from 0"),
        ((1.0, 2.0), (0.0, 1.0), "increase from 0"),
        ((0.0, 1.0), (0.0, float("inf")), "finite"),
    ],
)
def test_bad_profile(t: tuple[float, ...], M: tuple[float, ...], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        TorqueProfile(t=t, M=M)


@pytest.mark.measured
@pytest.mark.parametrize(("name", "mu", "scale"), [("05", 0.5, 1.0), ("18", 1.8, 3.0)])
def test_published_simulation(name: str, mu: float, scale: float, simulation_dir: Path) -> None:
    """The steering torque is not in the files; these round numbers are what psi and M_z leave of it."""
    table = np.genfromtxt(simulation_dir / f"sim_mu_{name}.csv", delimiter=",")[1:]
    t, psi, late = table[:, 0], table[:, 1], table[:, 3]
    torques = (0.4 * scale, 0.8 * scale, -0.9 * scale, 0.2 * scale)
    profile = TorqueProfile(t=(0.0, 1.99, 3.99, 4.99), M=torques)
    rig = Rig(a=0.04, e=0.01, J_A=0.1, b_t=0.4827)
    motion = simulate_motion(rig, Tyre(k=6e4, mu=mu), profile, LOAD, duration=t[-1], rate=100.0)

    # The 201 bristles of the published simulation account for most of it; its torque is a sample late.
    assert np.max(np.abs(motion.psi - psi)) < 1.5e-4 * np.ptp(psi)
    assert np.max(np.abs(motion.M_z[:-1] + late[1:])) < 3e-4 * np.ptp(late)
