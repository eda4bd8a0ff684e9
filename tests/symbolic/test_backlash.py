"""A gap in series: crossed at no torque, the grid at the solved angle, exact derivatives."""

import casadi as ca
import numpy as np
import pytest

from reference_rig import RigTyre, build_effects, hand_path, simulate_bristles
from symbolic import EFFECTS, Model
from symbolic.effects.backlash import ROUNDING
from tests.symbolic.oracles import Array, Path, Tyre, grid_torque, run, signals, straight, wandering_load

pytestmark = pytest.mark.usefixtures("interpreted")
TYRE = Tyre()
LOAD = 400.0
GO = TYRE.slope(LOAD) * TYRE.a
BACKLASH = (EFFECTS["backlash"],)
BOTH = (EFFECTS["carcass_torsion"], EFFECTS["backlash"])
REALISATIONS = pytest.mark.parametrize("discretised", [False, True], ids=["zones", "bristles"])


def turns(seed: int, steps: int) -> Path:
    """Eight straight turns between random angles under a wandering load."""
    rng = np.random.default_rng(seed)
    psi = GO * straight(0.0, *rng.uniform(-6, 6, 8), steps=steps)
    return Path(psi=psi, F_N=wandering_load(rng, len(psi)), tyre=TYRE)


def solve(model: Model, path: Path, **values: float) -> tuple[Array, Array]:
    """Patch angle and torque, sample by sample."""
    named = {name.replace("__", "."): value for name, value in values.items()}
    theta, geometry = model.theta({"mu": TYRE.mu, "k": TYRE.k} | named), ca.DM([TYRE.a, TYRE.e])
    samples = signals(path.psi, path.F_N)
    memory, found = model.initial(samples[:, 0], theta, geometry), []
    for sample in samples.T:
        memory, M_z = model.step(memory, sample, theta, geometry)
        found.append((float(memory[0]), float(M_z)))
    angle, torque = np.array(found).T
    return angle, torque


def crossed(torque: Array, F_N: Array, gap: float) -> Array:
    """What of a rounded gap is crossed, in sines and tangents [rad]."""
    return gap / 2 * np.sin(np.arctan(torque / (F_N * ROUNDING)))


@REALISATIONS
@pytest.mark.parametrize("steps", [1, 4, 40])
@pytest.mark.parametrize("gap", [0.005, 0.05])
def test_turn_balances_gap_and_patch(discretised: bool, steps: int, gap: float) -> None:
    path = turns(steps, steps)
    angle, torque = solve(Model(effects=BACKLASH, discretised=discretised), path, backlash__gap=gap)

    off = np.max(np.abs(angle - path.psi - crossed(torque, path.F_N, gap)))
    print(f"residual of the turn behind a gap of {gap} rad, {steps} samples a turn: {off:.1e} rad")
    assert off < 1e-10


def test_gap_and_carcass_add() -> None:
    path, gap, k_t = turns(7, 20), 0.03, 120.0
    angle, torque = solve(Model(effects=BOTH), path, backlash__gap=gap, carcass_torsion__k_t=k_t)

    twist = crossed(torque, path.F_N, gap) + torque / k_t
    np.testing.assert_allclose(angle - path.psi, twist, rtol=0, atol=1e-9)


def test_grid_at_the_solved_angle_makes_the_same_torque() -> None:
    path = turns(1, 40)
    angle, torque = solve(Model(effects=BACKLASH), path, backlash__gap=0.03)

    (reference,) = grid_torque(Path(psi=angle, F_N=path.F_N, tyre=TYRE))

    np.testing.assert_allclose(torque, reference, rtol=0, atol=1e-6 * np.ptp(reference))


def test_no_torque_while_the_gap_is_crossed() -> None:
    """Turned into a full slide and back: the patch relaxes, then the wheel turns on freely."""
    gap, out = 0.04, 3 * GO
    psi = np.concatenate([np.linspace(0, out, 60), np.linspace(out, -out, 500)[1:]])
    path = Path(psi=psi, F_N=np.full(psi.size, LOAD), tyre=TYRE)
    back = psi[60:]

    torque = run(Model(effects=BACKLASH), path, backlash__gap=gap).M_z[60:]
    rigid = run(Model(), path).M_z[60:]

    slide = 3 / 8 * TYRE.mu * LOAD * TYRE.a
    quiet, elastic = (np.ptp(back[np.abs(M_z) < 0.02 * slide]) for M_z in (torque, rigid))
    assert quiet - elastic == pytest.approx(gap, rel=0.05)
    # Beyond the gap the loop is the same one, later by the gap.
    late = np.interp(back, back[::-1] - gap, rigid[::-1])
    beyond = torque > 0.1 * slide
    np.testing.assert_allclose(torque[beyond], late[beyond], rtol=0, atol=2e-2 * slide)


def test_rounding_nears_hard_flanks() -> None:
    """The rig's gap has hard flanks: the difference is that of the rounding, where a flank is met."""
    drive, tyre = hand_path(3, 10.0, rate=100.0), RigTyre()
    hard = simulate_bristles(drive, tyre, build_effects({"backlash": {"gap": 0.03}})).M_z
    path = Path(psi=drive.psi, F_N=drive.F_N, tyre=Tyre(a=tyre.a, e=tyre.e, k=tyre.k, mu=tyre.mu))

    rounded = run(Model(effects=BACKLASH), path, backlash__gap=0.03).M_z

    error = (rounded - hard) / np.ptp(hard)
    assert np.sqrt(np.mean(error**2)) < 1e-3
    assert np.max(np.abs(error)) < 8e-3


@REALISATIONS
@pytest.mark.parametrize("gap", [0.004, 0.03])
def test_derivatives_are_exact(discretised: bool, gap: float) -> None:
    """Against central differences, at every sample: in the gap, at its flanks and in the slide."""
    drive = hand_path(2, 6.0, rate=50.0)
    path = Path(psi=drive.psi, F_N=drive.F_N, tyre=TYRE)
    model = Model(effects=BOTH, discretised=discretised)
    values = {"backlash__gap": gap, "carcass_torsion__k_t": 200.0}

    found = run(model, path, directions=np.eye(4), **values).sensitivities[:, 3]

    h = 1e-7
    ends = [run(model, path, **(values | {"backlash__gap": gap + s * h})).M_z for s in (1, -1)]
    expected = (ends[0] - ends[1]) / (2 * h)
    size = np.max(np.abs(expected))
    assert np.quantile(np.abs(found - expected), 0.98) < 1e-4 * size, "but for samples at a kink"
    assert np.max(np.abs(found)) < 2 * size


@REALISATIONS
def test_closed_gap_has_a_derivative(discretised: bool) -> None:
    """So that a search can open it."""
    small = 1e-4 * GO
    path = Path(psi=np.linspace(0, small, 5), F_N=np.full(5, LOAD), tyre=TYRE)
    model = Model(effects=BACKLASH, discretised=discretised)

    found = run(model, path, directions=np.eye(3)[:, 2:], backlash__gap=0.0)

    assert np.all(np.isfinite(found.sensitivities))
    assert found.sensitivities[-1] > 0
