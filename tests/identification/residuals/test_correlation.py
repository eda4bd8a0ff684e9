import numpy as np

from identification.residuals.correlation import additional_basis, orthogonal_part, orthonormal_basis

RNG = np.random.default_rng(5)
COLUMNS = RNG.standard_normal((400, 3))


def test_what_is_absorbed_already_adds_no_direction() -> None:
    """Rounding leaves something of it, which points anywhere."""
    absorbed = orthonormal_basis(COLUMNS)

    assert np.any(orthogonal_part(COLUMNS @ np.ones((3, 2)), absorbed) != 0)
    assert additional_basis(COLUMNS @ np.ones((3, 2)), absorbed).shape == (400, 0)


def test_only_what_is_new_is_new_directions() -> None:
    absorbed = orthonormal_basis(COLUMNS[:, :2])
    new = additional_basis(COLUMNS, absorbed)

    assert new.shape == (400, 1)
    np.testing.assert_allclose(absorbed.T @ new, 0, atol=1e-14)
    np.testing.assert_allclose(orthogonal_part(COLUMNS, np.hstack([absorbed, new])), 0, atol=1e-12)
