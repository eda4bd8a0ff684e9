"""The simulation of [Györök 2022], section 2.2: rows of bristles, a fixed step, in NumPy."""

import numpy as np
from numpy.typing import NDArray

from symbolic import Rig, Tyre

Array = NDArray[np.float64]


class Bristles:
    """Evenly spaced bristles, both edges among them, each a stop: [Györök 2022], (2.15) and (2.16)."""

    def __init__(self, rig: Rig, tyre: Tyre, load: float, count: int) -> None:
        """A virgin patch; the torque (2.3) is summed by the trapezoidal rule."""
        x = np.linspace(-rig.a, rig.a, count)
        self.q, self.lever = np.zeros(count), x - rig.e
        self.limit = 3 * load * (tyre.mu or 0.0) / (4 * rig.a**3 * tyre.k) * (rig.a**2 - x**2)
        weight = np.full(count, 2 * rig.a / (count - 1))
        weight[[0, -1]] /= 2
        self._share, self._lowest = tyre.k * weight * self.lever, -self.limit
        self._move = np.empty(count)

    def turn(self, angle: float) -> float:
        """M_z after a turn [rad]; in place, which in NumPy takes half the time of `clip`."""
        np.multiply(self.lever, angle, out=self._move)
        np.subtract(self.q, self._move, out=self.q)
        np.minimum(self.q, self.limit, out=self.q)
        np.maximum(self.q, self._lowest, out=self.q)
        return float(self._share @ self.q)


def first_order(
    rig: Rig, tyre: Tyre, load: float, torque: Array, step: float, count: int
) -> tuple[Array, Array]:
    """Angle and M_z by the semi-implicit Euler rule; torque at every step, shape (n,)."""
    patch, J_A, b_t = Bristles(rig, tyre, load, count), rig.J_A or 1.0, rig.b_t or 0.0
    psi, M_z = np.zeros(len(torque)), np.zeros(len(torque))
    angle, rate, moment = 0.0, 0.0, 0.0
    for i, M in enumerate(torque[:-1].tolist()):
        rate += step * (M + moment - b_t * rate) / J_A
        angle += step * rate
        moment = patch.turn(step * rate)
        psi[i + 1], M_z[i + 1] = angle, moment
    return psi, M_z


def second_order(
    rig: Rig, tyre: Tyre, load: float, torque: Array, step: float, count: int
) -> tuple[Array, Array]:
    """The same by velocity Verlet: half a kick, a turn, half a kick; one turn a step too."""
    patch, J_A, b_t = Bristles(rig, tyre, load, count), rig.J_A or 1.0, rig.b_t or 0.0
    psi, M_z = np.zeros(len(torque)), np.zeros(len(torque))
    half = 0.5 * step / J_A
    angle, rate, moment = 0.0, 0.0, 0.0
    torques = torque.tolist()
    for i in range(1, len(torques)):
        middle = rate + half * (torques[i - 1] + moment - b_t * rate)
        angle += step * middle
        moment = patch.turn(step * middle)
        rate = (middle + half * (torques[i] + moment)) / (1 + half * b_t)
        psi[i], M_z[i] = angle, moment
    return psi, M_z
