import numpy as np
import pytest
from scipy.optimize import least_squares

from identification import Fit, FitOptions, Recording, fit
from identification.fits.covariance import standard_deviations
from identification.fits.least_squares_problem import torque_range
from identification.fits.loss import LEAST_SQUARES, Huber, Loss, cost, curvature, influence
from symbolic import InvalidInputError, Model
from tests.identification.factories import positions, read_campaign, with_torque

NOISE = 0.004
HUBER = Huber(threshold=1.5 * NOISE)


@pytest.mark.parametrize("loss", [LEAST_SQUARES, Huber(threshold=0.7)])
def test_derivatives_are_slopes(loss: Loss) -> None:
    residuals, step = np.array([-3.0, -0.701, -0.5, 0.0, 0.3, 0.699, 2.0]), 1e-6
    ends = [np.array([0.5 * cost(loss, np.array([r + s])) for r in residuals]) for s in (step, -step)]
    np.testing.assert_allclose((ends[0] - ends[1]) / (2 * step), influence(loss, residuals), atol=1e-8)
    psi = [influence(loss, residuals + s) for s in (step, -step)]
    np.testing.assert_allclose((psi[0] - psi[1]) / (2 * step), curvature(loss, residuals), atol=1e-8)


def test_an_outlier_pulls_no_harder_than_the_threshold_and_what_is_missing_not_at_all() -> None:
    np.testing.assert_allclose(influence(Huber(threshold=2.0), np.array([-9.0, -1.0, 1e6])), [-2, -1, 2])
    np.testing.assert_allclose(influence(LEAST_SQUARES, np.array([-9.0, 4.0])), [-9, 4])
    assert cost(LEAST_SQUARES, np.array([3.0, np.nan, 4.0])) == 25
    assert cost(Huber(threshold=1.0), np.array([3.0, np.nan, 0.5])) == pytest.approx(2 * 3 - 1 + 0.25)


def test_the_same_line_as_with_the_solvers_own_huber() -> None:
    rng = np.random.default_rng(1)
    x = np.linspace(0, 1, 60)
    y = 2 * x + 0.1 * rng.standard_normal(60) + 5 * (rng.random(60) < 0.1)

    def off(line: np.ndarray) -> np.ndarray:
        return line[0] + line[1] * x - y

    own = least_squares(off, [0.0, 0.0], loss=Huber(threshold=0.2))
    built_in = least_squares(off, [0.0, 0.0], loss="huber", f_scale=0.2)
    np.testing.assert_allclose(own.x, built_in.x, atol=1e-6)
    assert own.cost == pytest.approx(built_in.cost)


@pytest.mark.parametrize("threshold", [0.0, -1.0, np.nan, np.inf])
def test_a_threshold_has_to_be_positive(threshold: float) -> None:
    with pytest.raises(InvalidInputError, match="threshold must be a finite number greater than 0"):
        Huber(threshold=threshold)


@pytest.fixture(scope="module")
def clean() -> list[Recording]:
    return read_campaign(None, 4)[1]


@pytest.fixture(scope="module")
def reference(clean: list[Recording]) -> Fit:
    return fit(Model(corners=16), clean)


def with_outliers(recordings: list[Recording], seed: int, share: float = 0.02) -> list[Recording]:
    """Single readings that are off by up to a third of the range."""
    rng = np.random.default_rng(seed)
    spoilt = []
    for r in recordings:
        off = (rng.random(r.t.size) < share) * rng.uniform(-1, 1, r.t.size) / 3
        spoilt.append(with_torque(r, r.M_z + off * torque_range(r)))
    return spoilt


def test_outliers_do_not_move_a_robust_fit(clean: list[Recording], reference: Fit) -> None:
    spread = standard_deviations(reference, clean)
    steps: dict[Loss, list[np.ndarray]] = {LEAST_SQUARES: [], HUBER: []}
    for seed in range(5):
        spoilt = with_outliers(clean, seed)
        for loss, found in steps.items():
            fitted = fit(reference.model, spoilt, reference.values, FitOptions(loss=loss))
            assert fitted.converged
            found.append(np.abs(positions(fitted) - positions(reference)) / spread)

    assert np.max(steps[HUBER]) < 1
    assert np.median(steps[LEAST_SQUARES]) > 1
    assert np.max(steps[LEAST_SQUARES], axis=0).min() > 2


def test_deviations_of_a_robust_fit_are_those_of_noise(clean: list[Recording], reference: Fit) -> None:
    rng = np.random.default_rng(5)
    found, deviations = [], []
    for seed in range(30):
        noise = {r.name: NOISE * torque_range(r) * rng.standard_normal(r.t.size) for r in clean}
        noisy = [with_torque(r, r.M_z + reference.residuals[r.name] + noise[r.name]) for r in clean]
        spoilt = with_outliers(noisy, seed, 0.1)
        fitted = fit(reference.model, spoilt, reference.values, FitOptions(loss=HUBER))
        found.append(positions(fitted))
        deviations.append(standard_deviations(fitted, spoilt))

    np.testing.assert_allclose(np.std(found, axis=0, ddof=1), np.mean(deviations, axis=0), rtol=0.35)
