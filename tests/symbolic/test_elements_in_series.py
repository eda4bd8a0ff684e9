"""Carcass and backlash in series: the turn that balances them and the patch."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from reference_rig import hand_path
from symbolic import Model, effects_named
from symbolic.effects.backlash import ROUNDING
from tests.symbolic.oracles import (
    GEOMETRY,
    GO,
    LOAD,
    TYRE,
    Array,
    Path,
    constant,
    grid_torque,
    run,
    signals,
    straight,
    theta_of,
    wandering_load,
)  # fmt: skip

pytestmark = pytest.mark.usefixtures("interpreted")
Values = Mapping[str, float]
GAP, K_T = "backlash.gap", "carcass_torsion.k_t"
SLIDE = 3 / 8 * TYRE.mu * LOAD * TYRE.a
REALISATIONS = pytest.mark.parametrize("discretised", [False, True], ids=["zones", "bristles"])


def model_of(values: Values, discretised: bool) -> Model:
    return Model(effects=effects_named(n.partition(".")[0] for n in values), discretised=discretised)


def turns(seed: int, steps: int) -> Path:
    """Twelve straight turns between random angles, `steps` samples each, under a wandering load."""
    rng = np.random.default_rng(seed)
    psi = GO * straight(0.0, *rng.uniform(-6, 6, 12), steps=steps)
    return Path(psi=psi, F_N=wandering_load(rng, len(psi)), tyre=TYRE)


def by_hand(seed: int) -> Path:
    """A path as a hand steers it, at 100 Hz: at most 0.35 rad/s."""
    drive = hand_path(seed, 8.0, rate=100.0)
    return Path(psi=drive.psi, F_N=drive.F_N, tyre=TYRE)


def solve(model: Model, path: Path, theta: Array) -> tuple[Array, Array]:
    """Patch angle and torque, sample by sample."""
    samples, found = signals(path.psi, path.F_N), []
    memory = model.initial(samples[:, 0], theta, GEOMETRY)
    for sample in samples.T:
        memory, M_z = model.step(memory, sample, theta, GEOMETRY)
        found.append((float(memory[0]), float(M_z)))
    angle, torque = np.array(found).T
    return angle, torque


def twist(values: Values, torque: Array, F_N: Array) -> Array:
    """Turn of the elements: of the carcass, and of a rounded gap in sines and tangents [rad]."""
    gap = values.get(GAP, 0.0) / 2 * np.sin(np.arctan(torque / (F_N * ROUNDING)))
    return torque / values.get(K_T, np.inf) + gap


# From six times the stiffness of the sticking patch down to the least that the effect allows. Coarse
# turns of a carcass that is softer than the patch are the hardest.
QUICK: list[tuple[Values, Path]] = [
    ({K_T: 163.0}, by_hand(0)),
    ({K_T: 10.0}, by_hand(1)),
    ({K_T: 163.0}, turns(0, 1)),
    ({K_T: 40.0}, turns(1, 4)),
    ({GAP: 0.05}, turns(1, 1)),
    ({GAP: 0.005}, turns(4, 4)),
    ({GAP: 0.03, K_T: 120.0}, turns(7, 20)),
]
LONG: list[tuple[Values, Path]] = [
    *(({K_T: k_t}, by_hand(seed)) for k_t in (1000.0, 163.0, 40.0, 10.0) for seed in range(3)),
    *(({K_T: k_t}, turns(0, steps)) for k_t in (1000.0, 163.0) for steps in (1, 4, 100)),
    *(({K_T: 40.0}, turns(seed, steps)) for steps in (4, 100) for seed in range(6)),
    *(({GAP: gap}, turns(steps, steps)) for gap in (0.005, 0.05) for steps in (1, 4, 40)),
]


@REALISATIONS
@pytest.mark.parametrize(
    ("values", "path"), [*QUICK, *(pytest.param(*case, marks=pytest.mark.long) for case in LONG)]
)
def test_turn_balances_elements_and_patch(discretised: bool, values: Values, path: Path) -> None:
    model = model_of(values, discretised)
    angle, torque = solve(model, path, theta_of(model, values))
    there = replace(path, psi=angle)

    off = np.max(np.abs(angle - path.psi - twist(values, torque, path.F_N)))
    assert off < 1e-9
    # Bristles move along their slopes in the last step, so that their residual is zero anyhow.
    rigid = run(Model(discretised=discretised), there).M_z
    np.testing.assert_allclose(torque, rigid, rtol=0, atol=1e-9 * np.ptp(rigid))
    if not discretised:
        (reference,) = grid_torque(there)
        np.testing.assert_allclose(torque, reference, rtol=0, atol=1e-6 * np.ptp(reference))


def test_no_torque_while_the_gap_is_crossed() -> None:
    """Turned into a full slide and back: the patch relaxes, then the wheel turns on freely."""
    gap, out = 0.04, 3 * GO
    path = constant(np.concatenate([np.linspace(0, out, 60), np.linspace(out, -out, 500)[1:]]))
    back = path.psi[60:]

    torque = run(model_of({GAP: gap}, False), path, backlash__gap=gap).M_z[60:]
    rigid = run(Model(), path).M_z[60:]

    quiet, elastic = (np.ptp(back[np.abs(M_z) < 0.02 * SLIDE]) for M_z in (torque, rigid))
    assert quiet - elastic == pytest.approx(gap, rel=0.05)
    # Beyond the gap the loop is the same one, later by the gap.
    late = np.interp(back, back[::-1] - gap, rigid[::-1])
    beyond = torque > 0.1 * SLIDE
    np.testing.assert_allclose(torque[beyond], late[beyond], rtol=0, atol=2e-2 * SLIDE)


@REALISATIONS
@pytest.mark.parametrize("gap", [0.004, 0.03])
def test_derivatives_are_exact(discretised: bool, gap: float) -> None:
    """Against central differences, at every sample: in the gap, at its flanks and in the slide."""
    drive = hand_path(2, 6.0, rate=50.0)
    path = Path(psi=drive.psi, F_N=drive.F_N, tyre=TYRE)
    values = {"carcass_torsion__k_t": 200.0, "backlash__gap": gap}
    model = model_of({K_T: 200.0, GAP: gap}, discretised)

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
    path = constant(np.linspace(0, 1e-4 * GO, 5))

    model, opened = model_of({GAP: 0.0}, discretised), np.eye(3)[:, 2:]
    found = run(model, path, directions=opened, backlash__gap=0.0).sensitivities

    assert np.all(np.isfinite(found))
    assert found[-1] > 0
