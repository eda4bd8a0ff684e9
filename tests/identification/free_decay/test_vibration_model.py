"""The free vibration against closed forms, the model of the patch and finite differences."""

import casadi as ca
import numpy as np
import pytest

from identification.free_decay.vibration_model import (
    UNKNOWNS,
    rotational_stiffness,
    simulate_vibration,
    sliding_torque_deficit,
)
from reference_rig import THESIS_TYRE as TYRE
from reference_rig import inertia, make_impact
from symbolic import Model, simulate

GEOMETRY = np.array([TYRE.a, TYRE.e, inertia(TYRE.e)])
SLIP = 1 / (TYRE.mu * 400.0)
K, B_T, PSI, CENTRE = TYRE.k, 1.04, 0.007, 0.002
T = np.arange(900) / 1000


def unknowns(**changes: float) -> np.ndarray:
    usual = {"k": K, "b_t": B_T, "slip": SLIP, "psi": PSI, "psi_dot": 0.01, "centre": CENTRE}
    return np.array([(usual | changes)[name] for name in UNKNOWNS])


def linear(t: np.ndarray, psi_dot: float = 0.01) -> np.ndarray:
    decay = B_T / (2 * GEOMETRY[2])
    omega = np.sqrt(2 * TYRE.a * K * (TYRE.e**2 + TYRE.a**2 / 3) / GEOMETRY[2] - decay**2)
    sine = (psi_dot + decay * (PSI - CENTRE)) / omega * np.sin(omega * t)
    return CENTRE + np.exp(-decay * t) * ((PSI - CENTRE) * np.cos(omega * t) + sine)


@pytest.mark.parametrize(
    "t",
    [T, T[::7], T[::60], np.sort(np.random.default_rng(1).uniform(0, 0.9, 300))],
    ids=["short", "longer", "long", "uneven"],
)
def test_sticking_patch_is_exact_at_any_step(t: np.ndarray) -> None:
    made = simulate_vibration(t, unknowns(slip=0.0), GEOMETRY)

    np.testing.assert_allclose(made.psi, linear(t - t[0]), atol=1e-15)


def test_one_sample_and_no_vibration() -> None:
    made = simulate_vibration(T[:1], unknowns(), GEOMETRY)

    assert made.psi.tolist() == [PSI]
    assert made.sensitivities.tolist() == [[float(name == "psi") for name in UNKNOWNS]]
    assert np.isnan(simulate_vibration(T, unknowns(b_t=20.0), GEOMETRY).psi[-1])


@pytest.mark.usefixtures("interpreted")
@pytest.mark.parametrize("psi", [1e-5, 0.002, 0.01, 0.3])
def test_slip_is_what_the_patch_lacks_of_a_spring(psi: float) -> None:
    path = np.linspace(0, psi, 5)
    signals = np.vstack([path, np.zeros(5), np.full(5, 400.0), np.full(5, 0.01)])
    M_z = simulate(Model(), signals, np.array([TYRE.mu, K]), GEOMETRY[:2]).M_z[-1]
    spring = float(rotational_stiffness(K, TYRE.a, TYRE.e)) * psi

    slipped = float(sliding_torque_deficit(psi, K, SLIP, TYRE.a, TYRE.e))

    assert slipped == pytest.approx(M_z + spring, rel=1e-8, abs=1e-12 * spring)
    assert float(sliding_torque_deficit(-psi, K, SLIP, TYRE.a, TYRE.e)) == -slipped
    assert float(sliding_torque_deficit(psi, K, -SLIP, TYRE.a, TYRE.e)) == -slipped


def test_slip_is_smooth_where_nothing_slides() -> None:
    turn, slip = ca.SX.sym("turn"), ca.SX.sym("slip")
    value = sliding_torque_deficit(turn, K, slip, TYRE.a, TYRE.e)
    by_slip = ca.Function("by_slip", [turn, slip], [ca.jacobian(value, slip)])
    by_turn = ca.Function("by_turn", [turn, slip], [ca.jacobian(value, turn)])

    beside = [float(by_slip(PSI, slip)) for slip in (-1e-7, 0.0, 1e-7)]
    np.testing.assert_allclose(beside, beside[1], rtol=1e-3)
    assert beside[1] > 0
    np.testing.assert_allclose([float(by_turn(turn, SLIP)) for turn in (-1e-9, 0.0, 1e-9)], 0, atol=1e-3)


def test_half_a_cycle_is_a_balance_of_work() -> None:
    undamped = unknowns(b_t=1e-9, psi_dot=0.0, centre=0.0)
    made = simulate_vibration(np.arange(1200) / 10000, undamped, GEOMETRY).psi
    first, last = made[0], made.min()
    reach = np.linspace(0, (first - last) / 2, 101)
    slipped = [float(sliding_torque_deficit(turn, K, SLIP, TYRE.a, TYRE.e)) for turn in reach]

    # From turning point to turning point the work of -K psi + 2 (M_v + K .)((psi - psi_r) / 2) is nil.
    spring = float(rotational_stiffness(K, TYRE.a, TYRE.e)) / 2 * (last**2 - first**2)
    assert spring == pytest.approx(4 * np.trapezoid(slipped, reach), rel=1e-3)


@pytest.mark.parametrize(("swung", "rate"), [(0.004, 1000.0), (0.03, 1000.0), (0.03, 4000.0)])
def test_is_the_rigs(swung: float, rate: float) -> None:
    made = make_impact(2, swing=swung, encoder_step=0.0, bristles=800, duration=0.8, rate=rate)
    first = int(np.argmax(np.abs(made.psi_true)))
    t, psi = made.t[first:], made.psi_true[first:]
    values = unknowns(psi=psi[0], psi_dot=0.0, centre=0.0, slip=1 / (TYRE.mu * made.F_N))

    # Angle and rate at the turning point and the centre are the recording's own.
    for _ in range(8):
        fit = simulate_vibration(t, values, GEOMETRY)
        along = fit.sensitivities[:, 3:]
        values[3:] += np.linalg.solve(along.T @ along, along.T @ (psi - fit.psi))

    assert np.max(np.abs(fit.psi - psi)) < 2e-5 * np.ptp(psi)


@pytest.mark.parametrize("slip", [0.0, SLIP, -SLIP])
def test_sensitivities(slip: float) -> None:
    sizes = np.array([K, B_T, SLIP, PSI, 0.1, PSI])
    values = unknowns(slip=slip)
    made = simulate_vibration(T, values, GEOMETRY).sensitivities

    for column, size in enumerate(sizes):
        step = np.zeros(len(UNKNOWNS))
        step[column] = 1e-6 * size
        ahead, behind = (simulate_vibration(T, values + sign * step, GEOMETRY).psi for sign in (1, -1))
        difference = (ahead - behind) / (2e-6 * size)
        # The samples next to a reversal take turns at being it.
        size = np.abs(difference).max()
        np.testing.assert_allclose(made[:, column], difference, rtol=0, atol=1e-4 * size)
