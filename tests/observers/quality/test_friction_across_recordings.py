"""Friction of a ground: a further recording's friction lies in the band as often as it says."""

from itertools import combinations, permutations, product

import numpy as np
import pytest
from scipy.stats import ttest_ind

from observers.quality.friction_across_recordings import ground_friction, kendall_load_test
from tests.refusal import refused


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
        assert "finite mu_eff" in refused(ground_friction, values, own)


def test_more_recordings_that_scatter_alike_narrow_the_band() -> None:
    friction = ground_friction([0.9, 1.0, 1.1], [0.05] * 3)
    # Student's t of five degrees of freedom at 97.5 % is 2.57058.
    six = np.hypot(2.57058 * 0.1 * np.sqrt(7 / 6), 1.96 * 0.05)
    assert friction.further_half_width(6) == pytest.approx(six, rel=1e-5)
    assert friction.further_half_width(3) == pytest.approx(friction.further)
    assert np.isnan(ground_friction([0.9, 1.1], [0.05] * 2).further_half_width(6))


@pytest.mark.parametrize("seed", range(20))
def test_the_ratio_of_grounds_has_the_band_of_welchs_test(seed: int) -> None:
    draw = np.random.default_rng(seed)
    one, other = 1 + 0.1 * draw.normal(size=4), 1.15 + 0.03 * draw.normal(size=6)
    first, second = (ground_friction(v.tolist(), [0.05] * v.size) for v in (one, other))
    for comparisons in (1, 3):
        ratio, half = first.ratio_to(second, comparisons)
        welch = ttest_ind(one, ratio * other, equal_var=False)
        interval = welch.confidence_interval(1 - 0.05 / comparisons)
        assert ratio == pytest.approx(one.mean() / other.mean())
        assert half * other.mean() == pytest.approx(interval.high)
    scaled = [ground_friction((0.7 * v).tolist(), [0.05] * v.size) for v in (one, other)]
    assert scaled[0].ratio_to(scaled[1]) == pytest.approx(first.ratio_to(second)), (
        "a shared factor cancels"
    )


def test_the_band_of_a_ratio_holds_it_as_often_as_it_says() -> None:
    draw, held = np.random.default_rng(3), []
    for _ in range(2000):
        one, other = 1.2 + 0.08 * draw.normal(size=3), 1 + 0.04 * draw.normal(size=3)
        ratio, half = ground_friction(one.tolist(), [0.0] * 3).ratio_to(
            ground_friction(other.tolist(), [0.0] * 3)
        )
        held.append(abs(ratio - 1.2) <= half)
    assert 0.94 <= np.mean(held) <= 0.98
    like = ground_friction([1.0] * 3, [0.0] * 3)
    assert like.ratio_to(like) == (1.0, 0.0)


def test_an_order_is_as_likely_as_among_all_orders() -> None:
    """Against every order of three and of four recordings."""

    def inverted(orders: tuple[tuple[int, ...], ...]) -> int:
        return sum(a > b for own in orders for a, b in combinations(own, 2))

    every = list(product(permutations(range(3)), permutations(range(4))))
    counts = np.array([inverted(orders) for orders in every])
    for orders, falls in zip(every[::7], counts[::7], strict=True):
        fewer = min(falls, 9 - falls)  # Of nine pairs.
        chance = min(1.0, 2 * np.mean(counts <= fewer))
        grounds = [[(100.0 + i, 1.0 + 0.1 * mu) for i, mu in enumerate(own)] for own in orders]
        assert kendall_load_test(grounds) == (pytest.approx(chance), falls > 4.5)
    # One load is no order, whatever the friction.
    assert kendall_load_test([[(400.0, 1.0 + 0.1 * i) for i in range(6)]])[0] == 1.0
    assert kendall_load_test([])[0] == 1.0
