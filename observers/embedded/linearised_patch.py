"""A model whose torque is handed in: what an observer needs of a patch that is computed elsewhere."""

from dataclasses import dataclass

import casadi as ca

from symbolic import DECLARED, SIGNALS


@dataclass(frozen=True)
class HandedTorque:
    """Stands for the declared model in an observer's step; its memory is a torque with its slopes.

    The memory holds M_z [N m] at mu and k, its derivatives by both, and that mu [1] and k [N/m^2].

    Attributes:
        stiff: k is a state; otherwise the derivative by it does not matter.
    """

    stiff: bool

    @property
    def memory_size(self) -> int:
        """Length of the memory."""
        return 5

    @property
    def parameters(self) -> tuple[tuple[None, object], ...]:
        """Those of the declared model."""
        return tuple((None, parameter) for parameter in DECLARED)

    @property
    def advance(self) -> ca.Function:
        """What was handed in: (memory, signals, theta, geometry) -> (memory_next, seen)."""
        memory, signals, *_ = inputs = self._symbols()
        return ca.Function("advance", inputs, [memory, signals])

    @property
    def torque(self) -> ca.Function:
        """The torque, linear about where it was taken: (memory, seen, theta, geometry) -> M_z."""
        memory, _, theta, _ = inputs = self._symbols()
        M_z, by_mu, by_k, mu, k = ca.vertsplit(memory)
        M_z = M_z + by_mu * (theta[0] - mu)
        return ca.Function("torque", inputs, [M_z + by_k * (theta[1] - k) if self.stiff else M_z])

    def memory_depends_on(self, coordinate: str) -> bool:
        """False: the exact patch remembers angles and loads, no parameter."""
        del coordinate
        return False

    def _symbols(self) -> list[ca.MX]:
        sizes = (self.memory_size, len(SIGNALS), len(self.parameters), 2)
        return [ca.MX.sym(f"in{i}", size) for i, size in enumerate(sizes)]
