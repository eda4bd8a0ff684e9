import numpy as np

from observers import causal_rate, next_rate


def test_a_steady_turn() -> None:
    t = np.arange(200) / 100
    rate = causal_rate(t, 0.3 * t)

    assert rate[0] == 0
    # A first-order filter whose pole is memory / (memory + dt).
    np.testing.assert_allclose(rate, 0.3 * (1 - (3 / 4) ** np.arange(200)), rtol=1e-12)


def test_knows_nothing_of_later_samples() -> None:
    t = np.cumsum(np.random.default_rng(1).uniform(0.005, 0.02, 100))
    psi = np.sin(t)

    np.testing.assert_array_equal(causal_rate(t[:40], psi[:40]), causal_rate(t, psi)[:40])


def test_longer_steps_weigh_more_and_the_shortest_counts() -> None:
    coarse = np.array([0.0, 0.03, 0.06])

    np.testing.assert_allclose(causal_rate(coarse, coarse), [0, 0.5, 0.75])
    rate = next_rate(next_rate(0.2, 0.01, 5e-324), 0.0, 0.01)
    np.testing.assert_allclose(rate, (0.2 + 0.01 / 0.03) * 3 / 4)
