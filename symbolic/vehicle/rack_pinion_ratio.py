"""A steering ratio that varies: the rack's way by the angle of the pinion, and the other way round.

The pairs of a vehicle are joined by a monotone cubic ([Fritsch 1980]), mirrored to the right and
straight beyond the last one. So the gain ds / d delta, by which a torque becomes a force, has no jump.
"""

from functools import cache

import casadi as ca
import numpy as np

from symbolic.float_array import Array
from symbolic.patch_interface import Expression
from symbolic.vehicle.vehicle import Pairs, Vehicle


def rack_of_pinion(vehicle: Vehicle, pinion: Expression) -> tuple[Expression, Expression]:
    """Way of the rack [m] and gain [m/rad] at an angle of the pinion [rad]."""
    if not vehicle.rack_by_handwheel:
        return vehicle.rack_gain * pinion, vehicle.rack_gain
    functions, choose = (ca, ca.if_else) if isinstance(pinion, ca.SX) else (np, np.where)
    size, pieces = functions.fabs(pinion), _pieces(vehicle.rack_by_handwheel)
    way, gain = _on_piece(size, *pieces[0])
    for piece in pieces[1:]:
        here = _on_piece(size, *piece)
        way, gain = (
            choose(size > piece[0], one, last) for one, last in zip(here, (way, gain), strict=True)
        )
    return choose(pinion < 0, -way, way), gain


def pinion_of_rack(vehicle: Vehicle, s: Array) -> Array:
    """Angle of the pinion [rad] at a way of the rack [m]."""
    if not vehicle.rack_by_handwheel:
        return s / vehicle.rack_gain
    end = vehicle.rack_by_handwheel[-1][0]
    angles = np.append(np.linspace(0.0, end, 2001), end + 100.0)
    inverse: Array = np.sign(s) * np.interp(np.abs(s), rack_of_pinion(vehicle, angles)[0], angles)
    return inverse


def _on_piece(
    angle: Expression, begin: float, cubic: float, square: float, slope: float, way: float
) -> tuple[Expression, Expression]:
    u = angle - begin
    return ((cubic * u + square) * u + slope) * u + way, (3 * cubic * u + 2 * square) * u + slope


@cache
def _pieces(pairs: Pairs) -> tuple[tuple[float, ...], ...]:
    """Where each piece begins [rad], and its coefficients from the cubic one on."""
    from scipy.interpolate import PchipInterpolator

    from_middle = np.array([(0.0, 0.0), *pairs])
    beyond = 2 * from_middle[-1] - from_middle[-2]
    knots, ways = np.vstack([-from_middle[1], from_middle, beyond]).T
    coefficients = PchipInterpolator(knots, ways).c.T[1:].tolist()
    return tuple((knot, *piece) for knot, piece in zip(knots[1:-1].tolist(), coefficients, strict=True))
