"""Symmetric matrices of least squares with unknowns that all recordings share and unknowns of each one.

No two recordings have own unknowns in common, so the matrix is an arrowhead: a block for what is shared,
small blocks for what belongs to one recording, and what couples the two. Eliminating the small blocks
costs as much per recording as that recording alone.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Split:
    """A vector in two parts.

    Attributes:
        shared: shape (m,).
        own: of n recordings, shape (n, p).
    """

    shared: Array
    own: Array

    def __add__(self, other: "Split") -> "Split":
        """The sum."""
        return Split(shared=self.shared + other.shared, own=self.own + other.own)

    def __mul__(self, factor: float) -> "Split":
        """A multiple."""
        return Split(shared=self.shared * factor, own=self.own * factor)

    def dot(self, other: "Split") -> float:
        """The inner product."""
        return float(self.shared @ other.shared + (self.own * other.own).sum())


@dataclass(frozen=True, kw_only=True, eq=False)
class Arrow:
    """A symmetric positive definite arrowhead matrix.

    Attributes:
        shared: block of what is shared, shape (m, m).
        cross: what couples it with each recording's own, shape (n, m, p).
        own: block of each recording, shape (n, p, p).
    """

    shared: Array
    cross: Array
    own: Array

    def reduction(self) -> Array:
        """What a recording's own part counts for in the shared one, cross times own^-1, (n, m, p)."""
        solved = np.linalg.solve(self.own, self.cross.transpose(0, 2, 1))
        return np.asarray(solved.transpose(0, 2, 1), dtype=np.float64)

    def reduced(self) -> Array:
        """The matrix of what is shared once all else is eliminated (Schur complement), (m, m)."""
        made: Array = self.shared - np.einsum("nip,njp->ij", self.reduction(), self.cross)
        return made

    def solve(self, right: Split) -> Split:
        """The vector that this matrix makes `right` of."""
        reduction = self.reduction()
        reduced = self.shared - np.einsum("nip,njp->ij", reduction, self.cross)
        given = right.shared - np.einsum("nip,np->i", reduction, right.own)
        shared = np.linalg.solve(reduced, given)
        left = right.own - np.einsum("nip,i->np", self.cross, shared)
        return Split(shared=shared, own=np.linalg.solve(self.own, left[..., None])[..., 0])

    def damped(self, share: float) -> "Arrow":
        """The matrix with its diagonal greater by a share of itself."""
        shared = self.shared + share * np.diag(np.diag(self.shared))
        own = self.own * (1 + share * np.eye(self.own.shape[-1]))
        return Arrow(shared=shared, cross=self.cross, own=own)
