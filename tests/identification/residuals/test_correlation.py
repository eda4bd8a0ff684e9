import numpy as np

from identification.residuals.correlation import directions_of, new_directions, projected_off

RNG = np.random.default_rng(5)
COLUMNS = RNG.standard_normal((400, 3))


def test_what_is_absorbed_already_adds_no_direction() -> None:
    """Rounding leaves something of it, which points anywhere."""
    absorbed = directions_of(COLUMNS)

    assert np.any(projected_off(COLUMNS @ np.ones((3, 2)), absorbed) != 0)
    assert new_directions(COLUMNS @ np.ones((3, 2)), absorbed).shape == (400, 0)


def test_only_what_is_new_is_new_directions() -> None:
    absorbed = directions_of(COLUMNS[:, :2])
    new = new_directions(COLUMNS, absorbed)

    assert new.shape == (400, 1)
    np.testing.assert_allclose(absorbed.T @ new, 0, atol=1e-14)
    np.testing.assert_allclose(projected_off(COLUMNS, np.hstack([absorbed, new])), 0, atol=1e-12)
