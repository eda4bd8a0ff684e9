"""Friction of a ground: a further recording's friction lies in the band as often as it says."""

import numpy as np
import pytest

from observers.quality.ground_friction import ground_friction
from symbolic import InvalidInputError


@pytest.mark.parametrize("n", [3, 4, 20])
@pytest.mark.parametrize("scatter", [0.0, 0.05, 0.15])
@pytest.mark.parametrize("own", [0.01, 0.1])
@pytest.mark.parametrize("common", [0.0, 1.0])
@pytest.mark.long
def test_the_band_holds_a_further_recording(n: int, scatter: float, own: float, common: float) -> None:
    # Each recording's error has a variance of own^2, of which a share is the same for all.
    draw = np.random.default_rng(7)
    held, runs = 0, 1500
    for _ in range(runs):
        shared = draw.normal() * own * np.sqrt(common)
        single = draw.normal(size=n) * own * np.sqrt(1 - common)
        seen = 1 + scatter * draw.normal(size=n) + shared + single
        friction = ground_friction(seen.tolist(), [own] * n)
        assert friction.further is not None
        held += abs(1 + scatter * draw.normal() - friction.mu_eff) <= friction.further
    assert held / runs >= 0.95 - 3 * np.sqrt(0.05 * 0.95 / runs)


def test_the_band_is_that_of_students_t() -> None:
    # t of two degrees of freedom at 97.5 % is 4.30265 in every table.
    friction = ground_friction([0.9, 1.0, 1.1], [0.0, 0.0, 0.0])
    assert friction.further == pytest.approx(4.30265 * 0.1 * np.sqrt(4 / 3), rel=1e-5)
    alike = ground_friction([1.0, 1.0, 1.0], [0.02, 0.02, 0.02])
    assert alike.further == pytest.approx(1.96 * 0.02)


def test_fewer_than_three_recordings_have_no_band() -> None:
    assert ground_friction([0.9, 1.1], [0.1, 0.1]).further is None
    assert ground_friction([0.9], [0.1]).scatter is None
    for values, own in (([], []), ([1.0], [np.nan]), ([1.0, 1.1], [0.1])):
        with pytest.raises(InvalidInputError, match="finite mu_eff"):
            ground_friction(values, own)
