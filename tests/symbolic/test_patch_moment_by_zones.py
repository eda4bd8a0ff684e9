"""The one integral that the patch needs, and its zone boundaries, against their definitions."""

from collections.abc import Callable
from decimal import Decimal, getcontext

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.integrate import quad

from symbolic import full_slide_level
from symbolic.patch_moment_by_zones import edge_to_boundary_distance, unit_corner_moment
from tests.symbolic.oracles import Tyre, virgin_torque

getcontext().prec = 60
HALF_LENGTH = 0.045
CASTERS = [0.0, 0.009, -0.02, 0.0449, -0.04499]
ANY_CASTER = st.floats(-0.9998, 0.9998).map(lambda share: share * HALF_LENGTH)
ANY_LEVEL = st.floats(-6.0, 5.0).map(lambda power: 10.0**power)


def exact_edge_to_zone_boundary(z: float, a: float, arm: float) -> float:
    """Root w of z w (2 a - w) = arm - w in the textbook form, with 60 digits."""
    if z == 0:
        return arm
    b = 1 + 2 * Decimal(a) * Decimal(z)
    return float((b - (b * b - 4 * Decimal(z) * Decimal(arm)).sqrt()) / (2 * Decimal(z)))


def integrate(integrand: Callable[[float, float], float], z: float, a: float, e: float) -> float:
    """Integral of f(|x - e|, a^2 - x^2) over both ends of the patch where |xi| > z.

    Taken over the distance w = a - |x| from the edge, where nothing cancels.
    """
    total = 0.0
    for arm in (a - e, a + e):
        width = exact_edge_to_zone_boundary(z, a, arm)
        total += quad(lambda w, arm=arm: integrand(arm - w, w * (2 * a - w)), 0, width, epsrel=1e-12)[0]
    return total


@given(z=ANY_LEVEL, e=ANY_CASTER)
@example(z=0.0, e=0.0)
@example(z=0.0, e=0.0449)
@example(z=1e5, e=-0.04499)
def test_unit_moment_is_its_integral(z: float, e: float) -> None:
    expected = integrate(lambda lever, parabola: (lever - z * parabola) * lever, z, HALF_LENGTH, e)

    assert float(unit_corner_moment(z, HALF_LENGTH, e)) == pytest.approx(expected, rel=1e-12, abs=0)


@given(z=st.floats(-9.0, 12.0).map(lambda power: 10.0**power), arm_share=st.floats(1e-6, 2 - 1e-6))
@example(z=1e-9, arm_share=2 - 1e-6)
@example(z=1e12, arm_share=1e-6)
@example(z=40.0, arm_share=1.0)
def test_edge_to_zone_boundary_solves_its_quadratic(z: float, arm_share: float) -> None:
    a, arm = HALF_LENGTH, HALF_LENGTH * arm_share
    root = exact_edge_to_zone_boundary(z, a, arm)

    assert float(edge_to_boundary_distance(z, a, arm)) == pytest.approx(root, rel=2e-15)
    assert float(edge_to_boundary_distance(0, a, arm)) == pytest.approx(arm, rel=1e-15)


@pytest.mark.parametrize("e", CASTERS)
def test_virgin_curve_is_the_closed_form(e: float) -> None:
    tyre, load = Tyre(a=HALF_LENGTH, e=e), 400.0
    a, k, c = tyre.a, tyre.k, float(full_slide_level(load, tyre.a)) * tyre.mu / tyre.k

    turns = c * a * np.logspace(-3, 2.5, 56)
    torques = [
        -k * psi * float(unit_corner_moment(0, a, e) - unit_corner_moment(c / psi, a, e))
        for psi in turns
    ]

    closed = [virgin_torque(psi, load, tyre, Decimal) for psi in turns]
    np.testing.assert_allclose(torques, closed, rtol=1e-12)
