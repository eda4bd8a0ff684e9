"""The interface of the two realisations of the contact patch."""

from dataclasses import dataclass
from typing import Any, Protocol

from symbolic.float_array_type import Array

Expression = Any
"""A CasADi expression (SX, MX or DM); CasADi ships no types."""


@dataclass(frozen=True, kw_only=True)
class Signals:
    """Signals of one sample at the patch, after effects on the sensors; CasADi expressions.

    Attributes:
        psi: yaw angle [rad].
        psi_dot: yaw rate [rad/s].
        F_N: vertical load [N].
        dt: time since the last sample, greater than 0: `Model` sees to that [s].
    """

    psi: Expression
    psi_dot: Expression
    F_N: Expression
    dt: Expression


@dataclass(frozen=True, kw_only=True)
class PatchInputs:
    """Inputs of the patch at one sample; all fields are CasADi expressions."""

    speed: Expression  # Yaw rate, for sliding speeds [rad/s].
    dt: Expression  # Time since the last sample, greater than 0 [s].
    F_N: Expression  # Vertical load [N].
    factor: Expression  # Factor on the friction limit that is the same for every bristle [1].
    mu: Expression  # Coefficient of friction [1].
    k: Expression  # Distributed lateral stiffness [N/m^2].
    a: Expression  # Half-length of the contact patch [m].
    e: Expression  # Caster length [m].


def patch_inputs(
    signals: Signals, factor: Expression, theta: Expression, geometry: Expression
) -> PatchInputs:
    """Inputs of the patch: signals at the patch, factor on the limit, (mu, k, ...) and (a, e)."""
    return PatchInputs(
        speed=signals.psi_dot, dt=signals.dt, F_N=signals.F_N, factor=factor,
        mu=theta[0], k=theta[1], a=geometry[0], e=geometry[1],
    )  # fmt: skip


class Patch(Protocol):
    """A realisation of the contact patch: a memory and the rule that advances it."""

    @property
    def memory_size(self) -> int:
        """Length of the memory vector."""

    @property
    def smooth(self) -> bool:
        """Whether the memory is piecewise linear in the turn, or smoother."""

    @property
    def coefficient_size(self) -> int:
        """Length of the vector that `coefficients` returns."""

    def virgin_memory(self) -> Array:
        """The memory of a patch that has never been turned, shape (size,)."""

    def coefficients(self, inputs: PatchInputs) -> Expression:
        """Coefficients of one sample beside memory and turn, shape (coefficient_size,)."""

    def advance(self, memory: Expression, turn: Expression, coefficients: Expression) -> Expression:
        """The memory after a turn [rad], shape (size,)."""

    def effective_friction(self, inputs: PatchInputs) -> Expression:
        """Torque of steady full slide at `inputs.speed` over that of the declared patch, mu = 1 [1]."""

    def torque(self, memory: Expression, coefficients: Expression) -> Expression:
        """M_z after `advance` with the same coefficients [N m]."""
