r"""The steering by virtual work: rack, mean angle of the front wheels, lever, jacking.

            left wheel            right wheel
        psi + delta  \               \  psi - delta
                      o--------------o
                       \            /       r = ds / dpsi, lever of the rack about both kingpins
                        ====rack====  -> s, F_R (positive: turns the wheels to the left)

    F_R ds = -sum_j M_j dpsi_j + dU + F_f |ds| + m s'' ds

    M_z = -r/2 (F_R - m s'') + J sin psi        the mean of both wheels' M_j, gear's friction in it

r falls towards full lock: 1 / r = (1 + q (s / s_max)^2) / r_0. The angle is its integral, never a table
of its own. The wheels' angles differ by 2 delta, delta = share (track / wheelbase) sin^2 psi / 2, from
cot psi_o - cot psi_i = share track / wheelbase; M_z is a mean weighted by dpsi_j / dpsi.

Jacking: a kingpin inclined by sigma and with caster tau moves the contact's middle, r_s outside and n
behind its own point on the ground, down as the wheel turns: U = F_N (r_s sin sigma cos sigma - n sin tau
cos tau)(1 - cos psi) for each wheel, and terms of other sign left and right, which cancel at even loads.

Sources: [Sharp 2003] for the mechanisms; the rotation is that about the kingpin's axis (Rodrigues).
"""

from math import cos, sin
from typing import Any

from symbolic.vehicle.vehicle import Vehicle

Expression = Any
"""A number, an array, or a casadi expression."""


def lever_growth(vehicle: Vehicle) -> float:
    """q, by which 1 / r grows from the middle to full lock [1]."""
    return vehicle.lever_loss / (1 - vehicle.lever_loss)


def mean_angle(vehicle: Vehicle, s: Expression) -> Expression:
    """Mean angle of the front wheels at a way of the rack [m], [rad]."""
    u = s / vehicle.rack_travel
    return s / vehicle.steering_arm * (1 + lever_growth(vehicle) * u * u / 3)


def lever(vehicle: Vehicle, s: Expression) -> Expression:
    """Lever r = ds / dpsi at a way of the rack [m], [m/rad]."""
    u = s / vehicle.rack_travel
    return vehicle.steering_arm / (1 + lever_growth(vehicle) * u * u)


def lock_angle(vehicle: Vehicle) -> float:
    """Mean angle of the wheels at full lock [rad]."""
    return float(mean_angle(vehicle, vehicle.rack_travel))


def wheel_angles(vehicle: Vehicle, psi: Expression) -> tuple[Expression, Expression]:
    """Angles of the left and of the right wheel at a mean angle [rad]."""
    import casadi as ca

    delta = vehicle.ackermann * vehicle.track / vehicle.wheelbase * ca.sin(psi) ** 2 / 2
    return psi + delta, psi - delta


def jacking_stiffness(vehicle: Vehicle) -> float:
    """J, return torque of a wheel over the sine of its angle [N m]."""
    by_scrub = vehicle.scrub_radius * sin(vehicle.inclination) * cos(vehicle.inclination)
    by_trail = vehicle.trail * sin(vehicle.caster) * cos(vehicle.caster)
    return vehicle.wheel_load * (by_scrub - by_trail)


def rack_force(vehicle: Vehicle, torsion_bar: Expression, motor: Expression = 0.0) -> Expression:
    """Force of the gear on the rack [N]: torque of the torsion bar and of the motor [N m]."""
    pinion = torsion_bar + vehicle.motor_ratio * vehicle.motor_efficiency * motor
    return pinion / vehicle.rack_gain


def rack_position(vehicle: Vehicle, handwheel: Expression, torsion_bar: Expression) -> Expression:
    """Way of the rack [m] by the handwheel's angle [rad] less the twist of the torsion bar."""
    return vehicle.rack_gain * (handwheel - torsion_bar / vehicle.torsion_bar)


def aligning_torque(
    vehicle: Vehicle, s: Expression, force: Expression, acceleration: Expression, sine: Expression
) -> Expression:
    """M_z of the mean wheel [N m], the gear's friction in it, from the force on the rack [N].

    Args:
        vehicle: the vehicle.
        s: way of the rack [m].
        force: F_R [N].
        acceleration: of the rack [m/s^2].
        sine: of the mean angle at s.
    """
    driving = force - vehicle.rack_mass * acceleration
    return -lever(vehicle, s) / 2 * driving + jacking_stiffness(vehicle) * sine
