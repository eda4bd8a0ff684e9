"""What a tuning takes, what it makes of it, and Huber's share."""

from dataclasses import replace
from math import inf, nan
from typing import Any

import casadi as ca
import numpy as np
import pytest

from observers import Ekf, Mhe, Tuning
from observers.quality.outlier_or_ground_change import huber_weight
from observers.tuning import TUNING_FIELDS
from symbolic import InvalidInputError
from tests.observers.conftest import K, make
from tests.refusal import refused

POSITIVE = (
    "mu_std", "least", "zero_time", "noise", "error", "psi_noise", "psi_dot_std",
    "gate", "alarm", "explained", "psi_limit", "psi_rate_limit", "F_N_limit", "torque_limit",
    "rezero_time",
)  # fmt: skip
UNLIMITED = ("zero_time", "error", "gate", "alarm", "explained", *POSITIVE[-5:])
NOT_NEGATIVE = (
    *("mu_walk", "mu_floor", "error_travel", "zero_std", "zero_walk", "stiffness_walk"),
    "stiffness_std",
)


@pytest.mark.parametrize("name", POSITIVE)
@pytest.mark.parametrize("value", [0.0, -1.0, nan])
def test_must_be_positive(name: str, value: float) -> None:
    assert f"{name} must be greater than 0" in refused(Tuning, **{name: value})


@pytest.mark.parametrize("name", NOT_NEGATIVE)
@pytest.mark.parametrize("value", [-1.0, nan])
def test_must_not_be_negative(name: str, value: float) -> None:
    assert f"{name} must be at least 0" in refused(Tuning, **{name: value})
    assert getattr(Tuning(**{name: 0.0}), name) == 0


@pytest.mark.parametrize("name", sorted({*POSITIVE, *NOT_NEGATIVE} - {"least", *UNLIMITED}))
def test_only_limits_may_be_infinite(name: str) -> None:
    assert f"{name} must be finite" in refused(Tuning, **{name: inf})


@pytest.mark.parametrize("name", UNLIMITED)
def test_infinite_limits_are_none(name: str) -> None:
    assert getattr(Tuning(**{name: inf}), name) == inf
    assert max(Tuning(**{name: inf}).sensor_limits) <= 1e9


@pytest.mark.parametrize(
    "change",
    [
        {"mu": 4.0}, {"mu": 0.02}, {"mu": nan}, {"mu": inf}, {"least": 1.0}, {"greatest": 1.0},
        {"greatest": nan},
    ],
    ids=str,
)  # fmt: skip
def test_mu_lies_between_its_bounds(change: dict[str, float]) -> None:
    assert "between least and greatest" in refused(Tuning, **change)


@pytest.mark.parametrize("value", [0, -1, 2.5, nan])
def test_counts_are_whole(value: float) -> None:
    assert "reset_after must be a whole number" in refused(Tuning, reset_after=value)
    for kind, name in ((Ekf, "iterations"), (Mhe, "iterations"), (Mhe, "window")):
        with pytest.raises(InvalidInputError, match=f"{name} must be a whole number of at least 1"):
            make(kind, **{name: value})


@pytest.mark.parametrize("kind", [Ekf, Mhe])
def test_parameters_of_the_model_are_checked_at_once(kind: Any) -> None:
    for message, values in (
        ("'k' is missing", {}),
        ("parameter k must lie in", {"k": -K}),
        ("unknown parameter 'c'", {"k": K, "c": 1.0}),
        ("delay", {"k": K, "sensor_delay.delay": 0.01}),
    ):
        with pytest.raises(InvalidInputError, match=message):
            make(kind, values=values)


def test_vector_is_the_fields_in_order() -> None:
    tuning = replace(Tuning(), noise=0.3, reset_after=7)

    assert len(TUNING_FIELDS) == tuning.vector.size
    for name, value in zip(TUNING_FIELDS, tuning.vector, strict=True):
        assert value == getattr(tuning, name)


def test_huber_weight_is_that_of_its_cost() -> None:
    # rho = r^2 within the ordinary size s, 2 s |r| - s^2 beyond it; the weight is rho' / (2 r).
    residual = np.concatenate([-np.logspace(3, -6, 40), [0.0], np.logspace(-6, 3, 40)])
    symbol, ordinary, left_open = (ca.SX.sym(name) for name in ("r", "s", "p"))
    symbols = [symbol, ordinary, left_open]
    share = ca.Function("share", symbols, [huber_weight(*symbols)])

    for size, wider in ((0.5, 0.0), (0.3, 0.4), (inf, 0.0)):
        made = np.array([float(share(r, size**2, wider**2)) for r in residual])
        limit = min(np.hypot(size, wider), 1e6)

        def rho(r: np.ndarray, limit: float = limit) -> np.ndarray:
            return np.where(np.abs(r) <= limit, r**2, 2 * limit * np.abs(r) - limit**2)

        step = 1e-4 * np.maximum(np.abs(residual), 1e-9)
        far = np.abs(np.abs(residual) - limit) > 2 * step
        slope = (rho(residual + step) - rho(residual - step)) / (2 * step)
        expected = np.divide(slope, 2 * residual, out=np.ones_like(slope), where=residual != 0)
        np.testing.assert_allclose(made[far], expected[far], rtol=1e-5)
        assert (made <= 1).all()
        assert made[residual == 0] == 1
