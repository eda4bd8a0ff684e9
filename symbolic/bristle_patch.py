"""The discretised patch: Gauss-Legendre bristles, for effects that break the parabola.

Each bristle is one elastoplastic stop, [Györök 2022], (2.15) and (2.16). Effects enter as
`BristleTraits`: the pressure over x, a spread over the width, a local factor on the friction limit, and
a stress that relaxes. The torque error of the discretisation is 4e-4 of range for 80 bristles in one
row, 2e-3 for 40 in each of 6 rows (1e-4 and 5e-4 rms); with room to grow 9e-4 for 80 (2e-4 rms).
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np

from symbolic.bristle_slip import BristleSlipSolver, clipped, log_creep_factor, slip
from symbolic.errors import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.patch_interface import Expression, PatchInputs
from symbolic.patch_moment_by_zones import full_slide_arm, unit_gauss_legendre

SPAN = 1.25
"""Half-lengths over which a patch that grows has bristles; growth is clamped to it [1]."""
INSIDE = 1 - 1e-9
"""Largest |x| / a at which pressure factors are evaluated; the limit is zero beyond [1]."""


@dataclass(frozen=True, kw_only=True)
class Relaxation:
    """A Maxwell branch beside every bristle spring: its share of stiffness [1] and its time [s]."""

    gain: Expression
    time: Expression


@dataclass(frozen=True, kw_only=True)
class BristleTraits:
    """Deviations of the bristles from the declared patch; each field is neutral by default.

    Attributes:
        shape: factors on the pressure parabola at u = x / a, keeping the total load.
        limits: factors on the friction limit at the speed `|x - e| |psi_dot|` [m/s] at which the wheel
            drives a bristle.
        creep: growth of the limit with the log of each bristle's own sliding speed, see
            `symbolic.bristle_slip` [1]; None for none.
        growth: (load [N], a [m]) -> half-length of the patch over a [1], None for a.
        half_width: half-width of the patch [m], None for a line.
        relaxation: the Maxwell branch, None for none.
    """

    shape: tuple[Callable[[Expression], Expression], ...] = ()
    limits: tuple[Callable[[Expression], Expression], ...] = ()
    creep: Expression | None = None
    growth: Callable[[Expression, Expression], Expression] | None = None
    half_width: Expression | None = None
    relaxation: Relaxation | None = None

    def relative_length(self, F_N: Expression, a: Expression) -> Expression:
        """Half-length of the patch over a [1] under a load [N]; 1 where it does not grow."""
        return 1 if self.growth is None else ca.fmin(SPAN, self.growth(F_N, a))

    def pressure(self, u: Expression, growth: Expression) -> Expression:
        """Load per length over F_N / a [1], at u = x / a where the half-length is growth times a."""
        place = u / growth
        pressure = 0.75 * ca.fmax(0, 1 - place**2)
        for shape in self.shape:
            pressure = pressure * shape(ca.fmax(-INSIDE, ca.fmin(INSIDE, place)))
        # The integral of the pressure over place is 1.
        return pressure / growth


@dataclass(frozen=True, kw_only=True)
class BristlePatch:
    """Bristles at Gauss-Legendre nodes over the length, and over the half-width where there is one.

    `columns` stand over the length, half as many where `rows` over the half-width smooth the sum. The
    memory holds q/a of every bristle and, with relaxation, the stress of its Maxwell branch in the same
    unit. `solver` takes the place of `symbolic.bristle_slip.bristle_slip_solver`.
    """

    traits: BristleTraits
    columns: int = 80
    rows: int = 6
    solver: BristleSlipSolver | None = None
    smooth: ClassVar[bool] = True
    """A bristle's deformation is piecewise linear in the turn, or smoother."""

    def __post_init__(self) -> None:
        """Check the numbers of bristles."""
        if self.columns < 4 or self.rows < 1:
            raise InvalidInputError(
                f"a bristle patch needs columns >= 4 and rows >= 1, got {self.columns} and {self.rows}"
            )

    @property
    def bristle_count(self) -> int:
        """Number of bristles."""
        wide = self.traits.half_width is not None
        return (self.columns // 2) * self.rows if wide else self.columns

    @property
    def memory_size(self) -> int:
        """Length of the memory vector."""
        return self.bristle_count * (1 if self.traits.relaxation is None else 2)

    def virgin_memory(self) -> Array:
        """The virgin patch: zeros of shape (size,)."""
        return np.zeros(self.memory_size)

    @property
    def coefficient_size(self) -> int:
        """Lever / a, limit, torque weight of every bristle; two numbers for relaxation, two for slip."""
        return 3 * self.bristle_count + 4

    def coefficients(self, inputs: PatchInputs) -> Expression:
        """Lever arms, limits at this sample and torque weights; see `Patch.coefficients`."""
        lever, limit, weight = self._levers_limits_weights(inputs)
        relaxation = self.traits.relaxation
        decay: Expression = 0
        branch_gain: Expression = 0
        if relaxation is not None:
            steps = inputs.dt / relaxation.time
            decay = ca.exp(-steps)
            # Share of a strain that is left at the end of a sample over which it grew evenly.
            branch_gain = relaxation.gain * (1 - decay) / steps
        moments = inputs.k * inputs.a * weight * lever
        reach = inputs.dt / inputs.a
        creep = 0 if self.traits.creep is None else self.traits.creep
        return ca.vertcat(lever / inputs.a, limit, moments, decay, branch_gain, reach, creep)

    def advance(self, memory: Expression, turn: Expression, coefficients: Expression) -> Expression:
        """One sample of every bristle, in q / a; see `Patch.advance`."""
        n = self.bristle_count
        lever, limit = coefficients[:n], coefficients[n : 2 * n]
        stretch = -lever * turn
        reach = coefficients[3 * n + 2]
        # Out of the coefficients: theta itself is not an input of `advance`.
        creep = None if self.traits.creep is None else coefficients[3 * n + 3]
        if self.traits.relaxation is None:
            q = memory + stretch
            if creep is None:
                return clipped(q, limit)
            return q - slip(q, limit, 0, reach, creep, self.solver)
        # The stop with a Maxwell branch: sliding relieves spring and branch together.
        decay, branch_gain = coefficients[3 * n], coefficients[3 * n + 1]
        q, m = memory[:n] + stretch, memory[n:] * decay + branch_gain * stretch
        slipped = slip(q + m, limit, branch_gain, reach, creep, self.solver)
        return ca.vertcat(q - slipped, m - branch_gain * slipped)

    def torque(self, memory: Expression, coefficients: Expression) -> Expression:
        """The moment of the bristles and their branches; see `Patch.torque`."""
        n = self.bristle_count
        stress = memory if self.traits.relaxation is None else memory[:n] + memory[n:]
        return ca.dot(stress, coefficients[2 * n : 3 * n])

    def effective_friction(self, inputs: PatchInputs) -> Expression:
        """Every bristle at its limit, against the turn; see `Patch.effective_friction`.

        Spring and Maxwell branch bear the limit between them, so that relaxation does not matter.
        """
        lever, limit, weight = self._levers_limits_weights(inputs)
        if self.traits.creep is not None:
            limit = limit * log_creep_factor(ca.fabs(lever * inputs.speed), self.traits.creep)
        declared = inputs.F_N * full_slide_arm(inputs.a, inputs.e)
        return inputs.k * inputs.a * ca.dot(weight * ca.fabs(lever), limit) / declared

    def _levers_limits_weights(self, inputs: PatchInputs) -> tuple[Expression, Expression, Expression]:
        """Lever arm [m], limit of stress / (k a) [1] and weight [m] of every bristle."""
        u, v, weight = self.nodes_and_weights()
        growth = self.traits.relative_length(inputs.F_N, inputs.a)
        if self.traits.growth is not None:
            # Bristles are where the material is: a patch that grows takes up new ones, undeformed.
            u, weight = SPAN * u, SPAN * weight
        lever = inputs.a * u - inputs.e
        if self.traits.half_width is not None:
            # A bristle at (x, y) moves along its circle about A: one direction, one scalar stop.
            lever = ca.sqrt(lever**2 + (v * self.traits.half_width) ** 2)
        pressure = self.traits.pressure(u, growth)
        limit = inputs.mu * inputs.factor * inputs.F_N / (inputs.k * inputs.a**2) * pressure
        speed = ca.fabs(lever * inputs.speed)
        for factor in self.traits.limits:
            limit = limit * factor(speed)
        return lever, limit, weight * inputs.a

    def nodes_and_weights(self) -> tuple[ca.DM, ca.DM, ca.DM]:
        """Places x / a, y / half_width and weights over u of every bristle."""
        wide = self.traits.half_width is not None
        along, share = unit_gauss_legendre(self.columns // 2 if wide else self.columns)
        across, part = unit_gauss_legendre(self.rows if wide else 1)
        u = np.repeat(2 * along - 1, len(across))
        v = np.tile(across, len(along))
        return ca.DM(u), ca.DM(v), ca.DM(np.outer(2 * share, part).ravel())
