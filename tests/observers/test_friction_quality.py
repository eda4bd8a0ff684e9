"""The quality of an estimate, counted by hand on short tracks."""

from dataclasses import replace

import numpy as np
import pytest

from observers import Estimates, friction_quality, friction_spread
from symbolic import InvalidInputError


def track(mu_eff, std, informed=None):
    mu_eff, n = np.array(mu_eff, dtype=float), len(mu_eff)
    std = np.full(n, std, dtype=float)
    known = np.ones(n, dtype=bool) if informed is None else np.array(informed, dtype=bool)
    return Estimates(
        t=10.0 + 0.5 * np.arange(n), mu=mu_eff, mu_std=std, M_z_predicted=np.zeros(n), informed=known,
        usable=known,
        status=np.zeros(n, dtype=int), mu_eff=mu_eff, mu_eff_std=std, M_slide=mu_eff, nis=np.ones(n),
    )  # fmt: skip


def test_it_settles_after_the_last_sample_that_is_further_off_than_a_tenth():
    assert friction_quality(track([2.0, 1.05, 1.2, 0.95, 1.0], 0.1)).settling == pytest.approx(1.5)


def test_an_estimate_that_is_near_from_the_start_settles_at_once():
    assert friction_quality(track([1.05, 0.95, 1.0], 0.1)).settling == 0


def test_only_informed_samples_count_for_the_band():
    quality = friction_quality(track([2.0, 1.1, 0.7, 1.0], 0.1, [False, True, True, True]))
    assert quality.coverage == pytest.approx(2 / 3)
    assert quality.relative_band == pytest.approx(0.1)


def test_a_band_reaches_two_standard_deviations():
    assert friction_quality(track([1.19, 1.0], 0.1)).coverage == 1
    assert friction_quality(track([1.21, 1.0], 0.1)).coverage == pytest.approx(0.5)


def test_without_an_informed_sample_there_is_no_coverage():
    quality = friction_quality(track([1.0, 1.0], 0.5, [False, False]))
    assert quality.coverage is None
    assert quality.relative_band is None


def test_the_drift_is_that_of_the_second_half():
    assert friction_quality(track([5.0, 0.9, 1.1, 1.2, 1.0], 0.1)).drift == pytest.approx(0.2)


def test_estimates_without_a_deviation_are_refused():
    bad = replace(track([1.0, 1.0], 0.1), mu_eff_std=np.full(2, np.nan))
    with pytest.raises(InvalidInputError, match="standard deviation"):
        friction_quality(bad)


def test_the_spread_of_one_ground_is_a_coefficient_of_variation():
    qualities = [friction_quality(track([mu, mu], 0.1)) for mu in (0.9, 1.0, 1.1)]
    assert friction_spread(qualities) == pytest.approx(0.1)
    assert friction_spread(qualities[:1]) is None


def test_a_reference_from_elsewhere_has_its_own_coverage():
    quality = friction_quality(track([1.5, 1.1, 0.7, 1.0], 0.1, [False, True, True, True]), 1.25)
    assert quality.coverage == pytest.approx(2 / 3)
    assert quality.reference_coverage == pytest.approx(1 / 3)
    assert friction_quality(track([1.0, 1.0], 0.1)).reference_coverage is None
    assert friction_quality(track([1.0], 0.5, [False]), 1.0).reference_coverage is None
