"""The discretised patch against the exact one, the fine grid, and each trait against its law."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from symbolic import BristleTraits, InvalidInputError, Model, Relaxation
from symbolic.bristle_patch import SPAN, BristlePatch
from symbolic.patch_interface import PatchInputs
from tests.symbolic.oracles import (
    LOAD,
    TYRE,
    Array,
    Tyre,
    constant,
    grid_torque,
    random_path,
    run,
    worst,
)

pytestmark = pytest.mark.usefixtures("interpreted")


def last_torque(traits: BristleTraits, *turns: float, speed: float = 0.1, tyre: Tyre = TYRE) -> float:
    """M_z after turns of a patch of 400 bristles, one a sample of 10 ms."""
    patch = BristlePatch(traits=traits, columns=400, rows=12)
    of_tyre = {"mu": tyre.mu, "k": tyre.k, "a": tyre.a, "e": tyre.e}
    inputs = PatchInputs(speed=speed, dt=0.01, F_N=LOAD, factor=1.0, **of_tyre)
    memory, M_z = ca.DM(patch.virgin_memory()), ca.DM(0)
    for turn in turns:
        coefficients = ca.evalf(ca.MX(patch.coefficients(inputs)))
        memory = patch.advance(memory, turn, coefficients)
        M_z = patch.torque(memory, coefficients)
    return float(ca.evalf(ca.MX(M_z)))


def line(tyre: Tyre = TYRE) -> tuple[Array, Array]:
    """Places [m] and pressure parabola [N/m] of a fine line of bristles."""
    x = tyre.a * ((2 * np.arange(100_000) + 1) / 100_000 - 1)
    return x, 3 * LOAD / (4 * tyre.a**3) * (tyre.a**2 - x**2)


def test_eighty_bristles_follow_the_zones() -> None:
    paths = [random_path(seed) for seed in range(20)]

    errors = [worst(run(Model(discretised=True), path).M_z, run(Model(), path).M_z) for path in paths]

    assert max(errors) <= 1.5e-3


@pytest.mark.parametrize(("columns", "allowed"), [(40, 5e-3), (200, 4e-4)])
def test_error_falls_with_the_bristles(columns: int, allowed: float) -> None:
    path = random_path(9)
    (reference,) = grid_torque(path)

    assert worst(run(Model(discretised=True, bristles=columns), path).M_z, reference) <= allowed


def test_shape_moves_the_load() -> None:
    x, pressure = line()
    traits = BristleTraits(shape=(lambda u: 1 + 0.4 * u, lambda u: 1 - 0.1 * u))

    load = pressure * (1 + 0.4 * x / TYRE.a) * (1 - 0.1 * x / TYRE.a)
    expected = -TYRE.mu * np.sum(load * np.abs(x - TYRE.e)) * (x[1] - x[0])
    assert last_torque(traits, 1e4) == pytest.approx(expected, rel=1e-4)


def test_pressure_factor_acts_up_to_the_edge() -> None:
    """The factor 1 / (1 - u^2) makes the pressure even, 3 F_N / (4 a) from edge to edge."""
    traits = BristleTraits(shape=(lambda u: 1 / (1 - u**2),))

    expected = -TYRE.mu * 3 * LOAD / (4 * TYRE.a) * (TYRE.a**2 + TYRE.e**2)
    assert last_torque(traits, 1e4) == pytest.approx(expected, rel=1e-4)


def test_patch_that_outgrows_its_bristles_keeps_the_whole_load() -> None:
    tyre = replace(TYRE, e=0.0)
    slide = -3 / 8 * tyre.mu * LOAD * tyre.a

    for growth in (1.1, SPAN, 2.0):
        traits = BristleTraits(growth=lambda *_, growth=growth: growth)
        expected = min(growth, SPAN) * slide
        assert last_torque(traits, 1e4, tyre=tyre) == pytest.approx(expected, rel=1e-4)


def test_limit_follows_the_local_sliding_speed() -> None:
    x, pressure = line()
    traits = BristleTraits(limits=(lambda v: 1 + 30 * v, lambda v: 1 / (1 + v)))

    for rate in (0.2, -0.7):
        v = np.abs((x - TYRE.e) * rate)
        factor = (1 + 30 * v) / (1 + v)
        slide = np.sum(pressure * factor * np.abs(x - TYRE.e)) * (x[1] - x[0])
        expected = -np.sign(rate) * TYRE.mu * slide
        assert last_torque(traits, 1e4 * rate, speed=rate) == pytest.approx(expected, rel=1e-4)


def test_width_lengthens_the_levers() -> None:
    b, traits = 0.03, BristleTraits(half_width=0.03)
    x, pressure = line()
    y = b * (np.arange(200) + 0.5) / 200
    lever = np.mean(np.hypot(x[::50, None] - TYRE.e, y), axis=1)

    slide = -TYRE.mu * np.sum(pressure[::50] * lever) * 50 * (x[1] - x[0])
    stick = -2 * TYRE.a * TYRE.k * (TYRE.a**2 / 3 + TYRE.e**2 + b**2 / 3)

    assert last_torque(traits, 1e4) == pytest.approx(slide, rel=1e-4)
    assert last_torque(traits, 1e-9) == pytest.approx(1e-9 * stick, rel=1e-3)


def test_relaxation_fades_at_rest_and_shares_the_slip() -> None:
    gain, time, small = 0.6, 0.5, 1e-9
    traits = BristleTraits(relaxation=Relaxation(gain=gain, time=time))
    elastic = last_torque(BristleTraits(), small)
    slide = last_torque(BristleTraits(), 1e4)

    held = gain * (1 - np.exp(-0.01 / time)) / (0.01 / time)
    assert last_torque(traits, small) == pytest.approx((1 + held) * elastic, rel=1e-3)
    faded = last_torque(traits, small, *[0.0] * 100)
    assert faded == pytest.approx((1 + held * np.exp(-1 / time)) * elastic, rel=1e-3)
    assert last_torque(traits, 1e4) == pytest.approx(slide, rel=1e-9)
    rested = last_torque(traits, 1e4, *[0.0] * 100)
    assert rested == pytest.approx(slide * (1 + held * np.exp(-1 / time)) / (1 + held), rel=1e-9)


@pytest.mark.parametrize("counts", [{"columns": 3}, {"rows": 0}])
def test_too_few_bristles_are_refused(counts: dict[str, int]) -> None:
    with pytest.raises(InvalidInputError, match="needs columns >= 4 and rows >= 1"):
        BristlePatch(traits=BristleTraits(), **counts)


def test_patch_at_rest_keeps_its_torque() -> None:
    psi = np.concatenate([np.linspace(0, 0.2, 30), np.full(30, 0.2)])

    M_z = run(Model(discretised=True), constant(psi, replace(TYRE, e=0.0))).M_z

    np.testing.assert_array_equal(M_z[30:], M_z[29])
