"""What the two realisations of the contact patch have in common."""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Expression = Any
"""A casadi expression (SX, MX or DM); casadi ships no types."""


@dataclass(frozen=True, kw_only=True)
class PatchInputs:
    """Everything one sample does to the patch; all fields are casadi expressions.

    Attributes:
        speed: yaw rate, for sliding speeds [rad/s].
        dt: time since the last sample, greater than 0 [s].
        F_N: vertical load [N].
        factor: factor on the friction limit that is the same for every bristle [1].
        mu: coefficient of friction [1].
        k: distributed lateral stiffness [N/m^2].
        a: half-length of the contact patch [m].
        e: caster length [m].
    """

    speed: Expression
    dt: Expression
    F_N: Expression
    factor: Expression
    mu: Expression
    k: Expression
    a: Expression
    e: Expression


class Patch(Protocol):
    """A realisation of the contact patch: a memory and the rule that advances it."""

    @property
    def size(self) -> int:
        """Length of the memory vector."""

    @property
    def smooth(self) -> bool:
        """Whether the memory may be moved along its slope by the turn, as far as rounding goes."""

    @property
    def drive_size(self) -> int:
        """Length of what `drive` makes."""

    def initial(self) -> NDArray[np.float64]:
        """The memory of a patch that has never been turned, shape (size,)."""

    def drive(self, inputs: PatchInputs) -> Expression:
        """All that one sample needs besides memory and turn, shape (drive_size,)."""

    def advance(self, memory: Expression, turn: Expression, drive: Expression) -> Expression:
        """The memory after a turn [rad], shape (size,)."""

    def torque(self, memory: Expression, drive: Expression) -> Expression:
        """The aligning torque M_z of a patch that has just been advanced with this drive [N m]."""
