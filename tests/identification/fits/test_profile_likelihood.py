from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from identification import Fit, FitOptions, Recording, Values, fit, initial_guess
from identification.fits import profile_likelihood as profiling
from identification.fits.covariance import standard_deviations
from identification.fits.loss import Huber
from identification.fits.profile_likelihood import (
    CASTER,
    HALF_LENGTH,
    LIMIT,
    ProfileAxis,
    ProfiledParameter,
    profile,
)
from reference_rig import RigTyre, make_recording
from rig_recordings import as_read
from symbolic import InvalidInputError, Model, Rig
from tests.identification.factories import read_campaign

MODEL = Model(corners=16)


@pytest.fixture(scope="module")
def fitted() -> tuple[Fit, list[Recording]]:
    recordings = read_campaign(None, 1)[1]
    return fit(MODEL, recordings, initial_guess(MODEL, recordings)), recordings


def test_limit_is_the_quantile() -> None:
    assert pytest.approx(chi2(1).ppf(0.95)) == LIMIT


@pytest.mark.parametrize("loss", [None, Huber(threshold=0.006)])
def test_the_interval_of_white_noise_is_that_of_the_deviation(fitted, loss: Huber | None) -> None:
    _, recordings = fitted
    options = FitOptions(loss=loss) if loss else FitOptions()
    best = fit(MODEL, recordings, fitted[0].values, options)
    k, spread = best.values.tyre["k"], standard_deviations(best, recordings)[0]
    grid = k + spread * np.array([-3.3, -1.5, 0.4, 2.1, 3.5])
    made = profile(MODEL, recordings, best.values, ProfiledParameter(name="k"), grid, options)

    assert made.converged
    assert made.best == pytest.approx(k, abs=0.05 * spread)
    ends = (np.array(made.interval, dtype=float) - k) / spread
    np.testing.assert_allclose(ends, [-1.96, 1.96], rtol=0.2)
    assert set(made.paths) == {"mu"}


def test_one_recordings_friction(fitted) -> None:
    best, recordings = fitted
    name = recordings[1].name
    mu, spread = best.values.own[name]["mu"], standard_deviations(best, recordings)[2]
    axis = ProfiledParameter(name="mu", recording=name)
    made = profile(MODEL, recordings, best.values, axis, mu + spread * np.linspace(-4, 4, 5))

    ends = (np.array(made.interval, dtype=float) - mu) / spread
    np.testing.assert_allclose(ends, [-1.96, 1.96], rtol=0.2)
    assert made.name == f"mu [{name}]"
    # The other recording's friction hardly notices.
    assert np.ptp(made.paths["mu"]) < 0.2 * spread


def test_without_caster_only_mu_a_is_told() -> None:
    # M_z = mu F_N a f(psi k a^2 / (mu F_N)) where e = 0.
    recordings = [as_read(make_recording(3, e=0.0, duration=8.0), RigTyre(e=0.0))]
    start = initial_guess(MODEL, recordings)
    made = profile(MODEL, recordings, start, HALF_LENGTH, [0.8, 1.0, 1.3], FitOptions(tolerance=1e-8))

    np.testing.assert_allclose(made.deviance, 0, atol=0.01)
    assert made.interval == (None, None)
    mu, k = made.paths["mu"], made.paths["k"]
    np.testing.assert_allclose(mu * made.grid, mu[1], rtol=1e-4)
    np.testing.assert_allclose(k * made.grid**3, k[1], rtol=1e-3)
    assert made.units == {"mu": "1", "k": "N/m^2"}


def test_the_caster_that_was_declared_wrongly_is_found(fitted) -> None:
    best, recordings = fitted
    wrong = [replace(r, rig=Rig(a=r.rig.a, e=r.rig.e + 0.002)) for r in recordings]
    made = profile(MODEL, wrong, best.values, CASTER, [-0.006, -0.003, 0.0, 0.002])
    low, high = made.interval

    assert low is not None
    assert high is not None
    assert made.best == pytest.approx(-0.002, abs=0.0007)
    assert low < -0.002 < high
    assert high - low < 0.003


def test_a_profile_is_open_where_the_grid_ends_too_soon(fitted) -> None:
    best, recordings = fitted
    k, spread = best.values.tyre["k"], standard_deviations(best, recordings)[0]
    grid = k + spread * np.array([-4.0, -2.0, -1.0])
    made = profile(MODEL, recordings, best.values, ProfiledParameter(name="k"), grid)

    assert made.interval[0] is not None
    assert made.interval[1] is None
    assert made.best == made.grid[-1]


def test_every_fit_begins_where_its_neighbour_ended(fitted, monkeypatch: pytest.MonkeyPatch) -> None:
    best, recordings = fitted
    begun: dict[float, Values] = {}

    def watched(model: Model, given: list[Recording], start: Values, options: FitOptions) -> Fit:
        begun[start.tyre["k"]] = start
        return fit(model, given, start, options)

    monkeypatch.setattr(profiling, "fit", watched)
    k = best.values.tyre["k"]
    grid = k * np.array([0.8, 0.9, 1.0, 1.1, 1.2])
    made = profile(MODEL, recordings, best.values, ProfiledParameter(name="k"), grid)

    friction = dict(zip(made.grid.tolist(), made.paths["mu"].tolist(), strict=True))
    for value, neighbour in ((0.8, 0.9), (0.9, 1.0), (1.1, 1.0), (1.2, 1.1)):
        start = begun[k * value]
        mean = np.mean([own["mu"] for own in start.own.values()])
        assert mean == pytest.approx(friction[k * neighbour], rel=1e-9)
    assert np.ptp(list(friction.values())) > 1e-4


@pytest.mark.parametrize(
    ("axis", "grid", "match"),
    [
        (
            ProfiledParameter(name="k"),
            [1e6, 2e6],
            "the grid of k must be at least three increasing values",
        ),
        (ProfiledParameter(name="k"), [1e6, 3e6, 2e6], "increasing"),
        (ProfiledParameter(name="k"), [1e6, np.nan, 2e6], "increasing"),
        (ProfiledParameter(name="k"), [1.0, 1e6, 2e6], "parameter k must lie in"),
        (ProfiledParameter(name="what"), [1, 2, 3], "unknown parameter 'what'; the model has mu, k"),
        (ProfiledParameter(name="mu"), [1, 2, 3], "mu is no parameter of all recordings"),
        (ProfiledParameter(name="mu", recording="x"), [1, 2, 3], "mu is no parameter of 'x'"),
        (HALF_LENGTH, [0.01, 0.5, 1], "a must lie between 0.001 and 1 m"),
    ],
)
def test_what_cannot_be_profiled(fitted, axis: ProfileAxis, grid: list[float], match: str) -> None:
    best, recordings = fitted
    with pytest.raises(InvalidInputError, match=match):
        profile(MODEL, recordings, best.values, axis, grid)
