"""Slip in one sample: the plain stop, and friction that grows with each bristle's own sliding speed."""

import casadi as ca
import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from symbolic.slip import REFERENCE_SPEED, REST_SPEED, slip

Array = NDArray[np.float64]
STRESS = np.array([-3.0, -1.0, -0.5, 0.0, 0.4, 0.99, 1.0, 1.01, 1.3, 2.0, 8.0, 300.0])
LIMIT = np.linspace(0.02, 1.1, STRESS.size)[::-1].copy()


def slipped(stress: Array, limit: Array, held: float, reach: float, c: float | None) -> Array:
    s = ca.MX.sym("s", stress.size)
    made = ca.Function("slip", [s], [slip(s, ca.DM(limit), held, reach, c)])
    return np.asarray(made(stress)).ravel()


def balanced(stress: float, limit: float, held: float, reach: float, c: float) -> float:
    """The slip at which friction bears the rest of the stress, by bisection."""

    def beyond(slid: float) -> float:
        speed = max(slid / reach, REST_SPEED)
        return abs(stress) - (1 + held) * slid - limit * (1 + c * np.log(speed / REFERENCE_SPEED))

    if beyond(0.0) <= 0:
        return 0.0
    return float(np.sign(stress) * brentq(beyond, 0.0, abs(stress), xtol=1e-15, rtol=1e-14))


@pytest.mark.parametrize("held", [0.0, 0.7])
def test_without_a_law_what_exceeds_the_limit_slips(held: float) -> None:
    made = slipped(STRESS, LIMIT, held, 0.2, None)

    expected = np.sign(STRESS) * np.maximum(0, np.abs(STRESS) - LIMIT) / (1 + held)
    np.testing.assert_allclose(made, expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("held", [0.0, 0.7])
@pytest.mark.parametrize("reach", [1e-4, 0.02, 0.2, 5.0])
@pytest.mark.parametrize("c", [0.0, 0.01, 0.15, 0.3])
def test_with_a_law_friction_and_stress_balance(held: float, reach: float, c: float) -> None:
    made = slipped(STRESS, LIMIT, held, reach, c)

    rows = zip(STRESS, LIMIT, strict=True)
    expected = [balanced(stress, limit, held, reach, c) for stress, limit in rows]
    np.testing.assert_allclose(made, expected, rtol=1e-12, atol=1e-13 * STRESS.max())


@pytest.mark.parametrize("beyond", [0.75, 1.3e-5], ids=["sliding", "creeping to rest"])
@pytest.mark.parametrize("name", ["stress", "limit", "held", "c", "reach"])
def test_derivatives_are_those_of_the_balance(name: str, beyond: float) -> None:
    """Against differences of the bisection, away from the two corners at rest."""
    at = {"limit": 0.9, "held": 0.3, "reach": 0.2, "c": 0.12}
    at["stress"] = at["limit"] * (1 + at["c"] * np.log(REST_SPEED / REFERENCE_SPEED)) + beyond
    symbols = {n: ca.MX.sym(n) for n in ("stress", "limit", "held", "reach", "c")}
    made = slip(*symbols.values())
    slope = ca.Function("slope", list(symbols.values()), [ca.jacobian(made, symbols[name])])

    h = 1e-6 * at[name]
    up, down = (balanced(**{**at, name: at[name] + step}) for step in (h, -h))
    made_slope = float(slope(*(at[n] for n in symbols)))
    assert made_slope == pytest.approx((up - down) / (2 * h), rel=1e-6, abs=1e-8)
