"""The consistency of estimates with the final one, counted by hand on short tracks."""

from dataclasses import replace

import numpy as np
import pytest

from observers import Estimates, friction_spread, self_consistency
from tests.refusal import refused


def track(mu_eff, std, informed=None):
    mu_eff, n = np.array(mu_eff, dtype=float), len(mu_eff)
    std = np.full(n, std, dtype=float)
    known = np.ones(n, dtype=bool) if informed is None else np.array(informed, dtype=bool)
    return Estimates(
        t=10.0 + 0.5 * np.arange(n), mu=mu_eff, mu_std=std, M_z_predicted=np.zeros(n), informed=known,
        usable=known,
        status=np.zeros(n, dtype=int), mu_eff=mu_eff, mu_eff_std=std, M_slide=mu_eff, nis=np.ones(n),
        turn=np.ones(n),
    )  # fmt: skip


@pytest.mark.parametrize(
    ("mu_eff", "std", "informed", "expected"),
    [
        # Settled after the last sample that is further off than a tenth.
        ([2.0, 1.05, 1.2, 0.95, 1.0], 0.1, None, {"settling": 1.5}),
        ([1.05, 0.95, 1.0], 0.1, None, {"settling": 0}),
        # Only informed samples count for the band, which reaches two standard deviations.
        ([2.0, 1.1, 0.7, 1.0], 0.1, [0, 1, 1, 1], {"coverage": 2 / 3, "relative_band": 0.1}),
        ([1.19, 1.0], 0.1, None, {"coverage": 1, "reference_coverage": None}),
        ([1.21, 1.0], 0.1, None, {"coverage": 0.5}),
        ([1.0, 1.0], 0.5, [0, 0], {"coverage": None, "relative_band": None}),
        # The drift is that of the second half.
        ([5.0, 0.9, 1.1, 1.2, 1.0], 0.1, None, {"drift": 0.2}),
    ],
)
def test_consistency_of_a_track(mu_eff, std, informed, expected):
    found = self_consistency(track(mu_eff, std, informed))

    assert {name: getattr(found, name) for name in expected} == pytest.approx(expected)


def test_a_reference_from_elsewhere_has_its_own_coverage():
    found = self_consistency(track([1.5, 1.1, 0.7, 1.0], 0.1, [False, True, True, True]), 1.25)

    assert (found.coverage, found.reference_coverage) == pytest.approx((2 / 3, 1 / 3))
    assert self_consistency(track([1.0], 0.5, [False]), 1.0).reference_coverage is None


def test_estimates_without_a_deviation_are_refused():
    bad = replace(track([1.0, 1.0], 0.1), mu_eff_std=np.full(2, np.nan))
    assert "standard deviation" in refused(self_consistency, bad)


def test_the_spread_of_one_ground_is_a_coefficient_of_variation():
    consistencies = [self_consistency(track([mu, mu], 0.1)) for mu in (0.9, 1.0, 1.1)]
    assert friction_spread(consistencies) == pytest.approx(0.1)
    assert friction_spread(consistencies[:1]) is None
