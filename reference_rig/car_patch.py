"""Contact patches of two steered wheels: a grid of bristles each, with a stop in the plane.

A bristle is a spring between a point of the tread and one of the ground. It sticks while the spring's
force stays within the friction that the pressure above it allows, and slides against that force
otherwise. All points are complex numbers x + i y in the wheel's own axes, from the patch's middle.
"""

from dataclasses import dataclass

import numpy as np

from reference_rig.hooks import Array

COLUMNS, ROWS = 32, 16
"""Bristles along and across."""


@dataclass(frozen=True, kw_only=True)
class CarTyre:
    """A car's tyre standing on the ground."""

    half_length: float = 0.07  # Of the patch [m].
    half_width: float = 0.075  # Of the patch [m].
    k: float = 6e6  # Stiffness of the bristles for one metre of the patch's length [N/m²].
    length_exponent: float = 2.0  # Pressure along the patch ~ 1 - |x/a|^n [1]; 2 is the parabola.
    width_exponent: float = 8.0  # Pressure across it ~ 1 - |y/b|^n [1]; large is even.


def bristle_grid(tyre: CarTyre, columns: int = COLUMNS, rows: int = ROWS) -> tuple[Array, Array]:
    """Places in the patch (complex, shape (columns, rows)) and shares of the load, which sum to one."""
    x, along = _cells(columns, tyre.length_exponent)
    y, across = _cells(rows, tyre.width_exponent)
    share = along[:, None] * across[None, :]
    return tyre.half_length * x[:, None] + 1j * tyre.half_width * y[None, :], share / share.sum()


def _cells(count: int, exponent: float) -> tuple[Array, Array]:
    """Middles of equal cells in [-1, 1], and the integrals of 1 - |x|^n over them."""
    edges = np.linspace(-1, 1, count + 1)
    integral = edges - edges * np.abs(edges) ** exponent / (exponent + 1)
    return 0.5 * (edges[1:] + edges[:-1]), np.diff(integral)


class CarPatches:
    """Both front patches, moved in place."""

    def __init__(self, tyre: CarTyre, columns: int = COLUMNS, rows: int = ROWS) -> None:
        """Lay the bristles out free of stretch."""
        place, share = bristle_grid(tyre, columns, rows)
        self.stiffness = tyre.k * 2 * tyre.half_length / place.size
        """Of one bristle [N/m]."""
        self.place = np.tile(place.ravel(), (2, 1))
        self.stretch = np.zeros_like(self.place)
        """From a bristle's root in the tread to its tip on the ground [m]."""
        self._limit = np.tile(share.ravel() / self.stiffness, (2, 1))
        self._column = 2 * tyre.half_length / columns
        self._rows = rows
        self._rolled = [0.0, 0.0]
        self._turned = np.empty_like(self.place)
        self._size = np.empty(self.place.shape)
        self._bound = np.empty(self.place.shape)
        self._arm = place.ravel().conj()

    def move(
        self, yaw: tuple[float, float], shift: tuple[complex, complex], hold: tuple[float, float]
    ) -> tuple[complex, complex, float, float]:
        """Move both patches over the ground: force on each wheel [N], moment about its middle [N m].

        By the turn of each wheel's axes, left and right [rad], the way of the tread at the patch's
        middle in these axes [m], and friction coefficient times load [N]. Forces are complex, in the
        wheel's axes; moments are positive to the left.
        """
        stretch, turned = self.stretch, self._turned
        # In turning axes a tip at rest moves by -i (place + stretch) d(yaw).
        np.add(self.place, stretch, out=turned)
        for wheel in (0, 1):
            turned[wheel] *= -1j * yaw[wheel]
            turned[wheel] -= shift[wheel]
            np.multiply(self._limit[wheel], hold[wheel], out=self._bound[wheel])
        stretch += turned
        np.abs(stretch, out=self._size)
        self._size += 1e-15
        np.divide(self._bound, self._size, out=self._size)
        np.minimum(self._size, 1.0, out=self._size)
        stretch *= self._size
        left, right = stretch
        force = self.stiffness * stretch.sum(axis=1)
        moment = (
            self.stiffness * float(np.dot(self._arm, left).imag),
            self.stiffness * float(np.dot(self._arm, right).imag),
        )
        return complex(force[0]), complex(force[1]), *moment

    def roll(self, wheel: int, way: float) -> None:
        """Let the tread run through the patch by a way forwards [m]: bristles that enter are free."""
        self._rolled[wheel] += way
        while abs(self._rolled[wheel]) >= self._column:
            forwards = 1 if self._rolled[wheel] > 0 else -1
            self._rolled[wheel] -= forwards * self._column
            moved = np.roll(self.stretch[wheel], forwards * self._rows)
            entering = slice(0, self._rows) if forwards > 0 else slice(-self._rows, None)
            moved[entering] = 0.0
            self.stretch[wheel] = moved

    @property
    def energy(self) -> float:
        """In the springs [J]."""
        return 0.5 * self.stiffness * float(np.sum(np.abs(self.stretch) ** 2))
