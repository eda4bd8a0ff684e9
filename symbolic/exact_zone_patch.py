"""The exact patch: a polyline of zone corners, for any history of angle, load and friction.

`symbolic.patch_moment_by_zones` shows that the deformation is a polyline r(xi) on xi >= 0. Its corners
are the memory of turning points. They are kept in the units r k / mu and xi k / mu: in these a sample
shears the polyline by the turn and clips it at 3 F_N / (4 a^3), which holds neither mu nor k. The memory
therefore does not depend on the parameters to be estimated, under any load.
"""

from dataclasses import dataclass
from typing import ClassVar

import casadi as ca
import numpy as np

from symbolic.errors import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.named_and_buffered_functions import named_function
from symbolic.patch_interface import Expression, PatchInputs
from symbolic.patch_moment_by_zones import full_slide_level, unit_corner_moment

NEAR = 1e-7
"""Segments narrower than this share of their distance carry no torque [1]."""
FAR = 1e15
"""Zones beyond are too narrow to carry torque, and single precision could not square them [1/m]."""
MIN_ZONE_TURN = 1e-12
"""Smallest turn that opens a zone; smaller ones are rounding [rad]."""


@dataclass(frozen=True, kw_only=True)
class ZonePatch:
    """Zone corners of the declared parabolic patch; exact while at most `corners` are in use.

    The memory is (xi_1 ... xi_n, r_1 ... r_n), innermost and oldest corner first; unused places repeat
    the last corner in use, so that they carry no zone. When all places are taken, the corner whose
    removal changes the torque least goes first.
    """

    corners: int = 32  # Capacity n; 2 n + 1 zones in x [1].
    smooth: ClassVar[bool] = False
    """A corner of a small turn runs to infinity, and its slope faster."""
    coefficient_size: ClassVar[int] = 5
    """Limit of r k / mu [N/m^3], mu / k [m^2/N], k [N/m^2], a and e [m]."""

    def __post_init__(self) -> None:
        """Check the capacity."""
        if self.corners < 4:
            raise InvalidInputError(f"corners must be at least 4, got {self.corners}")

    @property
    def memory_size(self) -> int:
        """Length of the memory vector, twice the corners."""
        return 2 * self.corners

    def virgin_memory(self) -> Array:
        """The virgin patch, r = 0 everywhere: zeros of shape (size,)."""
        return np.zeros(self.memory_size)

    def coefficients(self, inputs: PatchInputs) -> Expression:
        """The limit at this sample and the constants of the torque; see `Patch.coefficients`."""
        level = full_slide_level(inputs.F_N, inputs.a) * inputs.factor
        return ca.vertcat(level, inputs.mu / inputs.k, inputs.k, inputs.a, inputs.e)

    def advance(self, memory: Expression, turn: Expression, coefficients: Expression) -> Expression:
        """One sample: shear by the turn, clip at the limit; see `Patch.advance`."""
        level, scale, _, a, _ = ca.vertsplit(coefficients)
        xi, r = drop_least_corner_if_full(memory[: self.corners], memory[self.corners :], scale, a)
        xi, r = clip_polyline(xi, r - xi * turn, turn, level)
        return ca.vertcat(xi, r)

    def torque(self, memory: Expression, coefficients: Expression) -> Expression:
        """The moment of the polyline; see `Patch.torque`."""
        _, scale, k, a, e = ca.vertsplit(coefficients)
        return polyline_moment(memory[: self.corners], memory[self.corners :], scale, k, a, e)

    def effective_friction(self, inputs: PatchInputs) -> Expression:
        """That of the declared patch is mu; see `Patch.effective_friction`."""
        return inputs.mu * inputs.factor


def clip_polyline(
    xi: Expression, r: Expression, turn: Expression, level: Expression
) -> tuple[Expression, Expression]:
    """Clip the sheared polyline to [-level, level] and list its corners again.

    A corner inside the limits stays. One beyond is replaced by the points at which its two segments
    cross the limit. The tail beyond the last corner has slope -turn and crosses up to two limits.
    """
    n = xi.shape[0]
    xi_in, r_in = ca.vertcat(0, xi[:-1]), ca.vertcat(0, r[:-1])
    xi_out, r_out = ca.vertcat(xi[1:], xi[-1]), ca.vertcat(r[1:], r[-1])
    side = ca.if_else(r >= 0, 1.0, -1.0)
    limit = side * level
    beyond = side * r > level
    crosses_in = ca.logic_and(beyond, side * r_in < level)
    crosses_out = ca.logic_and(beyond, side * r_out < level)
    first = xi + _ratio_or_zero(limit - r, r_in - r, crosses_in) * (xi_in - xi)
    second = xi + _ratio_or_zero(limit - r, r_out - r, crosses_out) * (xi_out - xi)
    kept = ca.if_else(beyond, crosses_in, xi > xi_in)
    value = ca.if_else(beyond, limit, r)
    xi_tail, r_tail, keep_tail = _tail_crossings_function()(xi[-1], r[-1], turn, level)
    xi_all = ca.vertcat(_interleave(first, second), xi_tail)
    r_all = ca.vertcat(_interleave(value, limit), r_tail)
    keep = ca.vertcat(_interleave(kept, crosses_out), keep_tail)
    xi_next, r_next = _first_kept_entries(n, keep, xi_all, r_all)
    return xi_next, r_next


def _interleave(first: Expression, second: Expression) -> Expression:
    return ca.vec(ca.horzcat(first, second).T)


def _tail_crossings_function() -> ca.Function:
    """Crossings of the tail, of slope -turn, with the limits: the one it lies beyond, then the other."""
    symbols = {name: ca.SX.sym(name) for name in ("xi", "r", "turn", "level")}
    xi, r, turn, level = symbols.values()
    heading = ca.if_else(turn >= 0, -1, 1)
    moves = ca.fabs(turn) > MIN_ZONE_TURN
    beyond = ca.logic_and(moves, -heading * r > level)
    reaches = ca.logic_and(moves, heading * r < level)
    slope = ca.if_else(moves, ca.fabs(turn), 1)
    near = xi + ca.if_else(beyond, (-heading * r - level) / slope, 0)
    far = xi + ca.if_else(reaches, (level - heading * r) / slope, 0)
    crossings = {
        "xi_new": ca.vertcat(near, far),
        "r_new": ca.vertcat(-heading * level, heading * level),
        "keep": ca.vertcat(beyond, reaches),
    }
    return named_function("clip_tail", symbols, crossings)


def _ratio_or_zero(numerator: Expression, denominator: Expression, valid: Expression) -> Expression:
    """Numerator / denominator where valid, else 0, with no division by zero on either branch."""
    return ca.if_else(valid, numerator, 0) / ca.if_else(valid, denominator, 1)


def _first_kept_entries(n: int, keep: Expression, *columns: Expression) -> list[Expression]:
    """The first n kept entries of each column; unused places repeat the last kept one, or zero."""
    order = _kept_indices_function(keep.numel(), n)(keep)
    return [ca.MX(ca.vertcat(0, column)).nz[order] for column in columns]


def _kept_indices_function(candidates: int, n: int) -> ca.Function:
    """Which of 0, candidate 1, candidate 2 ... stands in each of n places; it has no derivative."""
    keep = ca.MX.sym("keep", candidates)
    numbers = ca.MX(ca.DM(range(1, candidates + 1)))
    values = ca.SX.sym("values", candidates)
    running_sum = named_function("running_sum", {"values": values}, {"sums": ca.cumsum(values)})
    place = ca.fmin(ca.if_else(keep, running_sum(keep) - 1, n), n)
    order = ca.repmat(ca.mmax(keep * numbers), n + 1, 1)
    order.nz[place] = numbers
    options = {"is_diff_in": [False], "is_diff_out": [False]}
    return named_function("order", {"keep": keep}, {"order": order[:n]}, **options)


def polyline_moment(
    xi: Expression, r: Expression, scale: Expression, k: Expression, a: Expression, e: Expression
) -> Expression:
    """M_z of the polyline: the sum of segment slopes times differences of G [N m].

    [Györök 2022], (2.3).
    """
    xi_in, r_in = ca.vertcat(0, xi[:-1]), ca.vertcat(0, r[:-1])
    width = xi - xi_in
    slope = _ratio_or_zero(r - r_in, width, width > NEAR * xi)
    moment = unit_corner_moment(ca.fmin(scale * ca.vertcat(0, xi), FAR), a, e)
    return k * ca.dot(slope, moment[:-1] - moment[1:])


def drop_least_corner_if_full(
    xi: Expression, r: Expression, scale: Expression, a: Expression
) -> tuple[Expression, Expression]:
    """Drop the corner with the least weight in the torque where fewer than three places are free.

    The weight of a corner is the area that cutting it off takes from the polyline, times the weight
    z / (1 + z^2)^(5/2), z = a xi, with which r enters M_z.
    """
    n = xi.shape[0]
    xi_kept, r_kept = _first_kept_entries(n, _corners_to_keep_function(n)(xi, r, scale * a), xi, r)
    return xi_kept, r_kept


def _corners_to_keep_function(n: int) -> ca.Function:
    xi, r, unit = ca.MX.sym("xi", n), ca.MX.sym("r", n), ca.MX.sym("unit")
    xi_in, r_in = ca.vertcat(0, xi[:-1]), ca.vertcat(0, r[:-1])
    xi_out, r_out = ca.vertcat(xi[1:], xi[-1]), ca.vertcat(r[1:], r[-1])
    used = xi > xi_in
    inner = ca.logic_and(used, xi_out > xi)
    span = ca.if_else(inner, xi_out - xi_in, 1)
    chord = r_in + (r_out - r_in) * (xi - xi_in) / span
    z = unit * xi
    weight = ca.fabs(r - chord) * span * z / (1 + z * z) ** 2.5
    weight = ca.if_else(inner, weight, ca.inf)
    full = ca.sum1(used) > n - 3
    goes = ca.logic_and(full, weight <= ca.mmin(weight))
    keep = ca.logic_and(used, ca.logic_not(ca.logic_and(goes, inner)))
    options = {"is_diff_in": [False] * 3, "is_diff_out": [False]}
    return named_function("worth_keeping", {"xi": xi, "r": r, "unit": unit}, {"keep": keep}, **options)
