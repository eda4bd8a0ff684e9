"""Slip in one sample: the plain stop, and friction that grows with each bristle's own sliding speed."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import brentq

from symbolic.bristle_slip import REFERENCE_SPEED, REST_SPEED, slip

Array = NDArray[np.float64]
STRESS = np.array([-3.0, -1.0, -0.5, 0.0, 0.4, 0.99, 1.0, 1.01, 1.3, 2.0, 8.0, 300.0])
LIMIT = np.linspace(0.02, 1.1, STRESS.size)[::-1].copy()


def slipped(stress: Array, limit: Array, branch_gain: float, reach: float, c: float | None) -> Array:
    s = ca.MX.sym("s", stress.size)
    slips = ca.Function("slip", [s], [slip(s, ca.DM(limit), branch_gain, reach, c)])
    return np.asarray(slips(stress)).ravel()


def balanced(stress: float, limit: float, branch_gain: float, reach: float, c: float) -> float:
    """The slip at which friction bears the rest of the stress, by bisection."""

    def beyond(slid: float) -> float:
        speed = max(slid / reach, REST_SPEED)
        return abs(stress) - (1 + branch_gain) * slid - limit * (1 + c * np.log(speed / REFERENCE_SPEED))

    if beyond(0.0) <= 0:
        return 0.0
    return float(np.sign(stress) * brentq(beyond, 0.0, abs(stress), xtol=1e-15, rtol=1e-14))


@pytest.mark.parametrize("branch_gain", [0.0, 0.7])
def test_without_a_law_what_exceeds_the_limit_slips(branch_gain: float) -> None:
    slips = slipped(STRESS, LIMIT, branch_gain, 0.2, None)

    expected = np.sign(STRESS) * np.maximum(0, np.abs(STRESS) - LIMIT) / (1 + branch_gain)
    np.testing.assert_allclose(slips, expected, rtol=0, atol=1e-15)


@given(
    branch_gain=st.floats(0.0, 2.0),
    reach=st.floats(-4.0, 0.7).map(lambda power: 10.0**power),
    c=st.floats(0.0, 0.3),
)
@example(branch_gain=0.0, reach=1e-4, c=0.0)
@example(branch_gain=0.7, reach=5.0, c=0.3)
@example(branch_gain=0.0, reach=0.02, c=0.01)
def test_with_a_law_friction_and_stress_balance(branch_gain: float, reach: float, c: float) -> None:
    slips = slipped(STRESS, LIMIT, branch_gain, reach, c)

    rows = zip(STRESS, LIMIT, strict=True)
    expected = [balanced(stress, limit, branch_gain, reach, c) for stress, limit in rows]
    np.testing.assert_allclose(slips, expected, rtol=1e-12, atol=1e-13 * STRESS.max())


@pytest.mark.parametrize("beyond", [0.75, 1.3e-5], ids=["sliding", "creeping to rest"])
@pytest.mark.parametrize("name", ["stress", "limit", "branch_gain", "c", "reach"])
def test_derivatives_are_those_of_the_balance(name: str, beyond: float) -> None:
    """Against differences of the bisection, away from the two corners at rest."""
    at = {"limit": 0.9, "branch_gain": 0.3, "reach": 0.2, "c": 0.12}
    at["stress"] = at["limit"] * (1 + at["c"] * np.log(REST_SPEED / REFERENCE_SPEED)) + beyond
    symbols = {n: ca.MX.sym(n) for n in ("stress", "limit", "branch_gain", "reach", "c")}
    slips = slip(*symbols.values())
    slope = ca.Function("slope", list(symbols.values()), [ca.jacobian(slips, symbols[name])])

    h = 1e-6 * at[name]
    up, down = (balanced(**{**at, name: at[name] + step}) for step in (h, -h))
    slope_there = float(slope(*(at[n] for n in symbols)))
    assert slope_there == pytest.approx((up - down) / (2 * h), rel=1e-6, abs=1e-8)
