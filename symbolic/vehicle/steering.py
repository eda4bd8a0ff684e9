r"""The steering by virtual work: rack and pinion, mean angle of the front wheels, lever, jacking.

            left wheel            right wheel
        psi + delta  \               \  psi - delta
                      o--------------o
                       \            /       r = ds / dpsi, lever of the rack about both kingpins
                        ====rack====  -> s, F_R (positive: turns the wheels to the left)

    F_R ds = -sum_j M_j dpsi_j + dU + F_f |ds| + m s'' ds

    M_z = -r/2 (F_R - m s'') + d psi' + I psi'' + J(psi)        the mean of both wheels' M_j

with the gear's dry friction in it, damping d and inertia I of a wheel about its kingpin.

r falls towards full lock: 1 / r = (1 + q (s / s_max)^2) / r_0. The angle is its integral, never a table
of its own. The wheels' angles differ by 2 delta, delta = share (track / wheelbase) sin^2 psi / 2, from
cot psi_o - cot psi_i = share track / wheelbase; M_z is a mean weighted by dpsi_j / dpsi.

Jacking: a kingpin inclined by sigma and with caster tau lowers the wheel as it turns. Its middle moves
on a circle about the kingpin, and it stands on the lowest point of its rim, R below, as a disc that
leans by the kingpin's angles. With the ground point r_s outside and n behind that of the kingpin, the
terms that are alike left and right make the return torque of a wheel, to second order in sigma and tau,

    J = F_N sin psi (r_s sin sigma cos sigma - n sin tau cos tau + R sin^2 sigma cos psi
                     + R sin^2 tau (1 - cos psi)).

Those of other sign left and right cancel at even loads.

Pairs of a ratio that varies are joined by a monotone cubic ([Fritsch 1980]), mirrored to the right and
straight beyond the last one. So the gain ds / d delta, by which a torque becomes a force, has no jump.

Sources: [Sharp 2003] for the mechanisms; the rotation is that about the kingpin's axis (Rodrigues).
"""

from dataclasses import replace
from functools import cache
from math import cos, sin

import casadi as ca
import numpy as np

from symbolic.errors import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.patch_interface import Expression
from symbolic.vehicle.vehicle import RANGES, Pairs, Vehicle

OF_LOCK = 0.8
"""Share of the angle at the lock where the return torque is made to fit [1]."""


def sine_and_cosine(psi: Expression) -> tuple[Expression, Expression]:
    """Sine and cosine of a number, an array or a casadi expression."""
    functions = ca if isinstance(psi, ca.SX) else np
    return functions.sin(psi), functions.cos(psi)


def inverse_lever_growth(vehicle: Vehicle) -> float:
    """q, by which 1 / r grows from the middle to full lock [1]."""
    return vehicle.lever_loss / (1 - vehicle.lever_loss)


def mean_wheel_angle(vehicle: Vehicle, s: Expression) -> Expression:
    """Mean angle of the front wheels at a way of the rack [m], [rad]."""
    u = s / vehicle.rack_travel
    return s / vehicle.steering_arm * (1 + inverse_lever_growth(vehicle) * u * u / 3)


def rack_lever(vehicle: Vehicle, s: Expression) -> Expression:
    """Lever r = ds / dpsi at a way of the rack [m], [m/rad]."""
    u = s / vehicle.rack_travel
    return vehicle.steering_arm / (1 + inverse_lever_growth(vehicle) * u * u)


def lock_angle(vehicle: Vehicle) -> float:
    """Mean angle of the wheels at full lock [rad]."""
    return float(mean_wheel_angle(vehicle, vehicle.rack_travel))


def jacking_torque(vehicle: Vehicle, psi: Expression) -> Expression:
    """Return torque J of a wheel at its angle [N m]."""
    sine, cosine = sine_and_cosine(psi)
    by_scrub = vehicle.scrub_radius * sin(vehicle.inclination) * cos(vehicle.inclination)
    by_trail = vehicle.trail * sin(vehicle.caster) * cos(vehicle.caster)
    by_inclination = vehicle.wheel_radius * sin(vehicle.inclination) ** 2 * cosine
    by_caster = vehicle.wheel_radius * sin(vehicle.caster) ** 2 * (1 - cosine)
    return vehicle.wheel_load * sine * (by_scrub - by_trail + by_inclination + by_caster)


def inclination_for_return_torque(vehicle: Vehicle, factor: float) -> float:
    """The inclination with this multiple of the declared return torque [rad]; refused where none has."""
    from scipy.optimize import brentq

    angle = OF_LOCK * lock_angle(vehicle)

    def excess(inclination: float) -> float:
        torque = jacking_torque(replace(vehicle, inclination=inclination), angle)
        return float(torque - factor * jacking_torque(vehicle, angle))

    try:
        return float(brentq(excess, 0.0, RANGES["inclination"][1]))
    except ValueError:
        raise InvalidInputError(
            f"the return torque is {factor:.2f} times the declared one, which no kingpin inclined by 0"
            " to 0.5 rad has; correct front_axle_load, wheel_radius or scrub_radius"
        ) from None


def rack_force(
    vehicle: Vehicle, torsion_bar: Expression, motor: Expression = 0.0, pinion: Expression | None = None
) -> Expression:
    """Force of the gear on the rack [N]: torque of the torsion bar and of the motor [N m].

    Where the ratio varies, the angle of the pinion [rad] is needed as well.
    """
    if vehicle.rack_by_handwheel:
        if pinion is None:
            raise InvalidInputError("rack_by_handwheel needs the angle of the pinion for a force")
        torsion_bar = torsion_bar * (vehicle.rack_gain / rack_and_gain(vehicle, pinion)[1])
    straight = torsion_bar + vehicle.motor_ratio * vehicle.motor_efficiency * motor
    return straight / vehicle.rack_gain


def pinion_angle(vehicle: Vehicle, handwheel: Expression, torsion_bar: Expression) -> Expression:
    """Angle of the pinion [rad]: the handwheel's less the twist of the torsion bar."""
    return handwheel - torsion_bar / vehicle.torsion_bar


def rack_position(vehicle: Vehicle, handwheel: Expression, torsion_bar: Expression) -> Expression:
    """Way of the rack [m] by the handwheel's angle [rad] less the twist of the torsion bar."""
    return rack_and_gain(vehicle, pinion_angle(vehicle, handwheel, torsion_bar))[0]


def rack_and_gain(vehicle: Vehicle, pinion: Expression) -> tuple[Expression, Expression]:
    """Way of the rack [m] and gain [m/rad] at an angle of the pinion [rad]."""
    if not vehicle.rack_by_handwheel:
        return vehicle.rack_gain * pinion, vehicle.rack_gain
    functions, choose = (ca, ca.if_else) if isinstance(pinion, ca.SX) else (np, np.where)
    size, pieces = functions.fabs(pinion), _monotone_cubic_pieces(vehicle.rack_by_handwheel)
    way, gain = _cubic_value_and_slope(size, *pieces[0])
    for piece in pieces[1:]:
        here = _cubic_value_and_slope(size, *piece)
        way, gain = (
            choose(size > piece[0], one, last) for one, last in zip(here, (way, gain), strict=True)
        )
    return choose(pinion < 0, -way, way), gain


def pinion_angle_from_rack(vehicle: Vehicle, s: Array) -> Array:
    """Angle of the pinion [rad] at a way of the rack [m]."""
    if not vehicle.rack_by_handwheel:
        return s / vehicle.rack_gain
    end = vehicle.rack_by_handwheel[-1][0]
    angles = np.append(np.linspace(0.0, end, 2001), end + 100.0)
    inverse: Array = np.sign(s) * np.interp(np.abs(s), rack_and_gain(vehicle, angles)[0], angles)
    return inverse


def _cubic_value_and_slope(
    angle: Expression, begin: float, cubic: float, square: float, slope: float, way: float
) -> tuple[Expression, Expression]:
    u = angle - begin
    return ((cubic * u + square) * u + slope) * u + way, (3 * cubic * u + 2 * square) * u + slope


@cache
def _monotone_cubic_pieces(pairs: Pairs) -> tuple[tuple[float, ...], ...]:
    """Where each piece begins [rad], and its coefficients from the cubic one on."""
    from scipy.interpolate import PchipInterpolator

    from_middle = np.array([(0.0, 0.0), *pairs])
    beyond = 2 * from_middle[-1] - from_middle[-2]
    knots, ways = np.vstack([-from_middle[1], from_middle, beyond]).T
    coefficients = PchipInterpolator(knots, ways).c.T[1:].tolist()
    return tuple((knot, *piece) for knot, piece in zip(knots[1:-1].tolist(), coefficients, strict=True))
