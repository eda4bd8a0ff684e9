"""Motion of a car that is steered at standstill: handwheel, gear, rods, wheels, patches, body.

The parts are masses between springs, moved in small steps (symplectic Euler). The body turns about the
rear axle against the rear tyres and rolls as the wheels lift it. Wheels roll where no brake holds them.
"""

from cmath import exp
from dataclasses import dataclass
from math import copysign, inf, tanh
from types import SimpleNamespace

import numpy as np

from reference_rig.car import Car
from reference_rig.car_geometry import MAX_STEER, SIDES, STEER_STEP, stand_table
from reference_rig.car_patch import COLUMNS, ROWS, CarPatches
from reference_rig.hooks import Array

CAR_STEP = 5e-4
"""Step of the motion [s]."""
ROLLING = 0.012
"""Rolling resistance over the load [1]."""
CREEP = 1e-3
"""Speed at which rolling resistance is nearly whole [m/s]."""
COLUMN_DAMPING = 0.2
"""Damping of the bearings of a handwheel that nobody holds [N m s/rad]."""
ROD_DAMPING = 1500.0
"""Damping of a tie rod and its joints [N s/m]."""
POSITION_GAIN = 2e6
"""Of the motor that follows a path of the rack [N/m]."""
POSITION_DAMPING = 5e4
"""Of the same [N s/m]."""
CHANNELS = (
    "handwheel", "T_hand", "T_bar", "T_motor", "rack", "F_rack", "F_rods", "F_friction",
    "steer_left", "steer_right", "M_left", "M_right", "load_left", "load_right", "body_yaw",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True, eq=False)
class CarMotion:
    """The motion as arrays of shape (n,): `t` [s] and the CHANNELS.

    Angles [rad], torques [N m], forces [N], rack [m]; all are positive to the left. M_left and M_right
    are moments of the ground about the kingpins, negative for a first turn to the left. F_rack is what
    pinion and motor put on the rack, F_rods what the tie rods put on it. T_motor is the rotor's mean.
    """

    t: Array
    channels: dict[str, Array]
    energy: dict[str, float]  # Work put in, stored and dissipated [J] by name, over the whole motion.

    def __getattr__(self, name: str) -> Array:
        """A channel by its name."""
        try:
            return self.channels[name]
        except KeyError:
            raise AttributeError(name) from None


def simulate_car(
    car: Car, path: Array, *, brake: bool = True, by_rack: bool = False, step: float = CAR_STEP,
    every: int = 2, grid: tuple[int, int] = (COLUMNS, ROWS),
) -> CarMotion:  # fmt: skip
    """Steer a car at standstill along a path.

    Args:
        car: the car.
        path: angle of the handwheel [rad] at every step, or with `by_rack` the rack's
            displacement [m] that the motor follows with the handwheel let go; shape (n,).
        brake: whether the brakes hold all wheels.
        by_rack: whether the motor steers by itself.
        step: of the motion [s].
        every: steps from one stored sample to the next.
        grid: bristles along and across.

    Returns:
        The motion, sampled every `every` steps.
    """
    if by_rack and car.assistance is None:
        raise ValueError("a car without a motor cannot steer by itself")
    positions = path.tolist()
    state = start_car(car, positions[0] if by_rack else positions[0] * car.pinion_radius, grid)
    rows = []
    previous = positions[0]
    for i, position in enumerate(positions):
        row = advance_car(car, state, position, (position - previous) / step, brake, by_rack, step)
        previous = position
        if i % every == 0:
            rows.append(row)
    table = np.array(rows)
    return CarMotion(
        t=np.arange(len(rows), dtype=np.float64) * (step * every),
        channels=dict(zip(CHANNELS, table.T, strict=True)),
        energy=state.energy | {"bristles": state.patches.energy},
    )


def start_car(car: Car, rack: float, grid: tuple[int, int]) -> SimpleNamespace:
    """Everything at rest, no spring stretched."""
    steer = [car.linkage.steer(side, rack) for side in SIDES]
    kingpin = car.kingpin
    return SimpleNamespace(
        patches=CarPatches(car.tyre, *grid),
        stands=[stand_table(kingpin, side) for side in SIDES],
        pivots=[car.wheelbase + car.linkage.pivot(side) for side in SIDES],
        arms=[car.linkage.arm_at_rest(side) for side in SIDES],
        moved_mass=car.moved_mass,
        tie_rod=car.linkage.tie_rod,
        upright=float(car.kingpin.upright),
        handwheel=rack / car.pinion_radius, handwheel_rate=0.0,
        rack=rack, speed=0.0, steer=steer, rates=[0.0, 0.0], gaps=[0.0, 0.0],
        yaw=0.0, yaw_rate=0.0, rolling=[0.0, 0.0], stretch=0.0, motor=0.0,
        force=[0j, 0j], moment=[0.0, 0.0],
        middles=[kingpin.stand(side, angle)[1] for side, angle in zip(SIDES, steer, strict=True)],
        energy=dict.fromkeys(("hands", "motor", "gear"), 0.0),
    )  # fmt: skip


def advance_car(
    car: Car, x: SimpleNamespace, input_position: float, input_rate: float, brake: bool, by_rack: bool,
    dt: float,
) -> list[float]:  # fmt: skip
    """One step of everything; returns the CHANNELS.

    The input is the rack's position [m] where `by_rack`, else the handwheel's angle [rad].
    """
    loads, slopes, middles = _stand(car, x)
    _move_patches(car, x, brake, dt, loads, middles)
    rods = [_rod(car, x, wheel, dt) for wheel in (0, 1)]
    F_rods = rods[0][1] + rods[1][1]
    for wheel in (0, 1):
        ground = x.upright * x.moment[wheel] - loads[wheel] * slopes[wheel]
        torque = rods[wheel][0] + ground - car.wheel_damping * x.rates[wheel]
        x.rates[wheel] += torque / car.wheel_inertia * dt
        x.steer[wheel] += x.rates[wheel] * dt
    # Handwheel, torsion bar and motor.
    r = car.pinion_radius
    if not by_rack:
        acceleration = (input_rate - x.handwheel_rate) / dt
        x.handwheel, x.handwheel_rate = input_position, input_rate
    else:
        acceleration = 0.0
    bar = 1 / (1 / car.torsion_bar + 1 / car.column)
    T_bar = bar * (x.handwheel - x.rack / r)
    T_rate = bar * (x.handwheel_rate - x.speed / r)
    if by_rack:
        drag = COLUMN_DAMPING * x.handwheel_rate
        x.handwheel_rate -= (T_bar + drag) / car.handwheel_inertia * dt
        x.handwheel += x.handwheel_rate * dt
    F_motor = _motor(car, x, T_bar, T_rate, input_position, input_rate, by_rack, dt)
    x.stretch, F_friction = car.friction.step(x.stretch, x.speed, F_rods, dt)
    F_gear = T_bar / r + F_motor
    x.speed += (F_gear + F_rods - F_friction) / x.moved_mass * dt
    x.rack += x.speed * dt
    energy = x.energy
    energy["hands"] += T_bar * x.handwheel_rate * dt
    energy["motor"] += F_motor * x.speed * dt
    energy["gear"] += F_friction * x.speed * dt
    T_hand = 0.0 if by_rack else T_bar + car.handwheel_inertia * acceleration
    return [
        x.handwheel, T_hand, T_bar, x.motor, x.rack, F_gear, F_rods, F_friction,
        *x.steer, *x.moment, *loads, x.yaw,
    ]  # fmt: skip


def _stand(car: Car, x: SimpleNamespace) -> tuple[list[float], list[float], list[complex]]:
    """Load of each wheel [N], slope of its rise [m/rad] and middle of its patch [m]."""
    rises, slopes, middles = [], [], []
    for wheel in (0, 1):
        place = (x.steer[wheel] + MAX_STEER) / STEER_STEP
        index = int(place)
        share = place - index
        rise, slope, middle = x.stands[wheel]
        rises.append(rise[index] + share * (rise[index + 1] - rise[index]))
        slopes.append(slope[index] + share * (slope[index + 1] - slope[index]))
        middles.append(middle[index] + share * (middle[index + 1] - middle[index]))
    # A wheel that lifts the body more carries more.
    crossing = car.warp_stiffness * (rises[0] - rises[1])
    left = min(max(car.left_share * car.axle_load + crossing, 0.0), car.axle_load)
    return [left, car.axle_load - left], slopes, middles


def _move_patches(
    car: Car, x: SimpleNamespace, brake: bool, dt: float, loads: list[float], middles: list[complex]
) -> None:
    """Move the treads with wheels and body, then body and rolling wheels by the ground's forces."""
    turns = [exp(1j * x.upright * x.steer[wheel]) for wheel in (0, 1)]
    yaws, shifts = [], []
    for wheel in (0, 1):
        yaw = (x.upright * x.rates[wheel] + x.yaw_rate) * dt
        shift = 1j * x.yaw_rate * dt * x.pivots[wheel] / turns[wheel] + 1j * yaw * middles[wheel]
        run = (x.middles[wheel] - middles[wheel]).real
        if not brake:
            shift += x.rolling[wheel] * dt
            run += x.rolling[wheel] * dt
        x.patches.roll(wheel, run)
        yaws.append(yaw)
        shifts.append(shift)
    x.middles = middles
    hold = (car.mu[0] * loads[0], car.mu[1] * loads[1])
    *x.force, left, right = x.patches.move((yaws[0], yaws[1]), (shifts[0], shifts[1]), hold)
    torque = 0.0
    for wheel, own in ((0, left), (1, right)):
        force = x.force[wheel]
        x.moment[wheel] = own + (middles[wheel].conjugate() * force).imag
        torque += x.moment[wheel] + (x.pivots[wheel].conjugate() * force * turns[wheel]).imag
        if not brake:
            resistance = ROLLING * loads[wheel] * tanh(x.rolling[wheel] / CREEP)
            x.rolling[wheel] += (force.real - resistance) / car.rolling_mass * dt
    stiffness = car.yaw_stiffness if brake else car.free_yaw_stiffness
    if stiffness < inf:
        damping = 0.6 * (stiffness * car.yaw_inertia) ** 0.5
        x.yaw_rate += (torque - stiffness * x.yaw - damping * x.yaw_rate) / car.yaw_inertia * dt
        x.yaw += x.yaw_rate * dt


def _rod(car: Car, x: SimpleNamespace, wheel: int, dt: float) -> tuple[float, float]:
    """Moment of a tie rod about the kingpin [N m] and its force on the rack [N], both to the left."""
    arm = x.arms[wheel] * exp(1j * x.steer[wheel])
    joint = car.linkage.joint(SIDES[wheel], x.rack)
    rod = x.pivots[wheel] - car.wheelbase + arm - joint
    length = abs(rod)
    gap = length - x.tie_rod
    pull = car.rod.force(gap)
    if pull:
        pull += ROD_DAMPING * (gap - x.gaps[wheel]) / dt
    x.gaps[wheel] = gap
    force = pull * rod / length
    return -(arm.conjugate() * force).imag, -force.imag


def _motor(
    car: Car, x: SimpleNamespace, T_bar: float, T_rate: float, input_position: float, input_rate: float,
    by_rack: bool, dt: float,
) -> float:  # fmt: skip
    """Force of the motor on the rack [N]; its torque follows the command late."""
    motor = car.assistance
    if motor is None:
        return 0.0
    r = car.pinion_radius
    if by_rack:
        asked = POSITION_GAIN * (input_position - x.rack) + POSITION_DAMPING * (input_rate - x.speed)
        torque = copysign(min(abs(asked) * r, motor.largest), asked)
    else:
        torque = motor.command(T_bar, T_rate)
    target = torque / (motor.ratio * motor.efficiency)
    x.motor += (target - x.motor) * dt / motor.lag
    return motor.at_pinion(x.motor, x.rack / r) / r
