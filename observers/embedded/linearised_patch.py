"""A patch whose torque and slopes are inputs, for a filter whose patch is advanced in C."""

from dataclasses import dataclass

import casadi as ca

from observers.layout import Layout
from symbolic import DECLARED, GEOMETRY, SIGNALS

MEMORY = Layout(tuple((name, 1, 1) for name in ("M_z", "by_mu", "by_k", "mu", "k")))
"""Memory of a `LinearisedPatch`: M_z [N m], its derivatives by mu and k, and mu [1] and k [N/m^2]."""


@dataclass(frozen=True)
class LinearisedPatch:
    """The torque of the declared model, linear about the point in its memory; a `PatchModel`.

    Attributes:
        stiff: k is a state; otherwise the derivative by it does not matter.
    """

    stiff: bool

    @property
    def memory_size(self) -> int:
        """Length of the memory."""
        return MEMORY.size

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Those of the declared model."""
        return tuple(parameter.name for parameter in DECLARED)

    @property
    def initial(self) -> ca.Function:
        """(signals, theta, geometry) -> zeros: the memory is an input of every step."""
        inputs = self._symbols()[1:]
        return ca.Function("start", inputs, [ca.MX(ca.DM.zeros(MEMORY.size))])

    @property
    def advance(self) -> ca.Function:
        """The memory as it is: (memory, signals, theta, geometry) -> (memory_next, seen)."""
        memory, signals, *_ = inputs = self._symbols()
        return ca.Function("advance", inputs, [memory, signals])

    @property
    def torque(self) -> ca.Function:
        """The torque to first order: (memory, seen, theta, geometry) -> M_z."""
        memory, _, theta, _ = inputs = self._symbols()
        at = MEMORY.split(memory)
        values = dict(zip(self.coordinates, ca.vertsplit(theta), strict=True))
        M_z = at["M_z"] + at["by_mu"] * (values["mu"] - at["mu"])
        return ca.Function(
            "torque", inputs, [M_z + at["by_k"] * (values["k"] - at["k"]) if self.stiff else M_z]
        )

    def memory_depends_on(self, coordinate: str) -> bool:
        """False: the memory of the exact patch depends on no parameter."""
        del coordinate
        return False

    def _symbols(self) -> list[ca.MX]:
        sizes = (MEMORY.size, len(SIGNALS), len(self.coordinates), len(GEOMETRY))
        return [ca.MX.sym(f"in{i}", size) for i, size in enumerate(sizes)]
