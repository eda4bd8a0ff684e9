"""Gauss-Legendre rules, the only numerical integration on this floor."""

from functools import cache

import numpy as np
from numpy.typing import NDArray


@cache
def gauss_legendre(order: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Nodes and weights on [0, 1], exact for polynomials up to degree 2 * order - 1.

    Args:
        order: number of nodes [1].

    Returns:
        Nodes (order,) and weights (order,), both dimensionless; the weights add up to one.
    """
    nodes, weights = np.polynomial.legendre.leggauss(order)
    return (nodes + 1.0) / 2.0, weights / 2.0
