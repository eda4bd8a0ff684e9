"""The turn that balances patch and carcass: residual of its equation, and the grid at that turn."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from reference_rig import hand_path
from symbolic import EFFECTS, Model
from tests.symbolic.oracles import Array, Path, Tyre, grid_torque, run, signals, straight, wandering_load

pytestmark = pytest.mark.usefixtures("interpreted")
LOAD = 400.0
TYRE = Tyre()
GO = TYRE.slope(LOAD) * TYRE.a
CARCASS = (EFFECTS["carcass_torsion"],)
STIFFNESSES = [
    pytest.param(1000.0, marks=pytest.mark.long),
    163.0,
    pytest.param(40.0, marks=pytest.mark.long),
    10.0,
]
"""From six times the stiffness of the sticking patch down to the least that the effect allows."""
REALISATIONS = pytest.mark.parametrize(
    "model",
    [Model(effects=CARCASS), Model(effects=CARCASS, discretised=True)],
    ids=["zones", "bristles"],
)


def random_turns(seed: int, steps: int) -> Path:
    """Twelve straight turns between random angles, `steps` samples each, under a wandering load."""
    rng = np.random.default_rng(seed)
    psi = GO * straight(0.0, *rng.uniform(-6, 6, 12), steps=steps)
    return Path(psi=psi, F_N=wandering_load(rng, len(psi)), tyre=TYRE)


def by_hand(seed: int) -> Path:
    """A path as a hand steers it, at 100 Hz: at most 0.35 rad/s."""
    drive = hand_path(seed, 8.0, rate=100.0)
    return Path(psi=drive.psi, F_N=drive.F_N, tyre=TYRE)


def solve(model: Model, path: Path, k_t: float) -> tuple[Array, Array]:
    """Patch angle and torque, sample by sample."""
    theta = model.theta({"mu": TYRE.mu, "k": TYRE.k, "carcass_torsion.k_t": k_t})
    geometry = ca.DM([TYRE.a, TYRE.e])
    samples = signals(path.psi, path.F_N)
    memory, made = model.initial(samples[:, 0], theta, geometry), []
    for sample in samples.T:
        memory, M_z = model.step(memory, sample, theta, geometry)
        made.append((float(memory[0]), float(M_z)))
    angle, torque = np.array(made).T
    return angle, torque


def residual(model: Model, path: Path, k_t: float) -> float:
    angle, torque = solve(model, path, k_t)
    return float(np.max(np.abs(angle - path.psi - torque / k_t)))


@REALISATIONS
@pytest.mark.parametrize("k_t", STIFFNESSES)
def test_residual_vanishes_at_the_pace_of_a_hand(model: Model, k_t: float) -> None:
    worst = max(residual(model, by_hand(seed), k_t) for seed in range(3))

    print(f"residual of the compliant turn, k_t = {k_t} N m/rad: {worst:.1e} rad")
    assert worst < 1e-9


@REALISATIONS
@pytest.mark.parametrize("steps", [1, 4])
def test_residual_vanishes_in_coarse_turns_while_the_carcass_is_no_softer_than_the_patch(
    model: Model, steps: int
) -> None:
    assert residual(model, random_turns(0, steps), 1000.0) < 1e-9
    assert residual(model, random_turns(0, steps), 163.0) < 1e-9


@REALISATIONS
@pytest.mark.parametrize(("steps", "seeds"), [(4, 6), (100, 3)], ids=["coarse", "1 rad/s"])
def test_residual_vanishes_in_fast_turns_of_a_soft_carcass(model: Model, steps: int, seeds: int) -> None:
    worst = max(residual(model, random_turns(seed, steps), 40.0) for seed in range(seeds))

    print(f"residual of the compliant turn, {steps} samples a turn, 40 N m/rad: {worst:.1e} rad")
    assert worst < 1e-9


@REALISATIONS
@pytest.mark.parametrize(
    ("path", "k_t"),
    [
        (by_hand(0), 163.0),
        (by_hand(0), 10.0),
        (random_turns(0, 4), 163.0),
        *(pytest.param(by_hand(0), k_t, marks=pytest.mark.long) for k_t in (1000.0, 40.0)),
        *(
            pytest.param(random_turns(0, steps), k_t, marks=pytest.mark.long)
            for steps in (1, 4, 100)
            for k_t in (1000.0, 163.0, 40.0)
            if (steps, k_t) != (4, 163.0)
        ),
    ],
)
def test_rigid_patch_at_the_solved_angle_makes_the_same_torque(
    model: Model, path: Path, k_t: float
) -> None:
    """Bristles move along their slopes in the last step, so that their residual is zero anyhow."""
    angle, torque = solve(model, path, k_t)

    rigid = run(Model(discretised=not model.exact), replace(path, psi=angle)).M_z
    np.testing.assert_allclose(torque, rigid, rtol=0, atol=1e-9 * np.ptp(rigid))


@pytest.mark.parametrize("k_t", STIFFNESSES)
def test_grid_at_the_solved_angle_makes_the_same_torque(k_t: float) -> None:
    path = random_turns(1, steps=100)
    angle, torque = solve(Model(effects=CARCASS), path, k_t)

    (reference,) = grid_torque(Path(psi=angle, F_N=path.F_N, tyre=TYRE))

    assert np.max(np.abs(angle - path.psi)) > 1e-3, "the carcass twists"
    np.testing.assert_allclose(torque, reference, rtol=0, atol=1e-6 * np.ptp(reference))


@REALISATIONS
def test_rigid_carcass_does_not_twist(model: Model) -> None:
    path = random_turns(2, steps=20)

    angle, torque = solve(model, path, np.inf)

    np.testing.assert_allclose(angle, path.psi, rtol=0, atol=1e-15)
    rigid = run(Model(discretised=not model.exact), path).M_z
    np.testing.assert_allclose(torque, rigid, rtol=0, atol=1e-12 * np.ptp(rigid))


def test_compliances_add() -> None:
    twice = Model(effects=CARCASS * 2)
    path = random_turns(3, steps=100)
    theta, geometry = ca.DM([TYRE.mu, TYRE.k, 1 / 400, 1 / 150]), ca.DM([TYRE.a, TYRE.e])
    samples = signals(path.psi, path.F_N)
    memory, torques = twice.initial(samples[:, 0], theta, geometry), []
    for sample in samples.T:
        memory, M_z = twice.step(memory, sample, theta, geometry)
        torques.append(float(M_z))

    _, expected = solve(Model(effects=CARCASS), path, 1 / (1 / 400 + 1 / 150))
    np.testing.assert_allclose(torques, expected, rtol=0, atol=1e-9)
