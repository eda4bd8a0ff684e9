"""Gear friction, zero and return torque of a steering whose front wheels stand on plates.

On turntables the ground hardly turns the wheels. While the rack moves evenly,

    F_R - m s'' = F_f sign(s') + 2 d s' / r^2 + j (2 J / r + share |2 J / r| sign(s')) + F_0,

which is linear in the gear's friction F_f, its damping d about one kingpin, the factor j on the declared
return torque J and the zero F_0; half of what F_f differs by direction is in F_0. Friction and damping
part only where the rack moved slowly and quickly to either side. Standard deviations leave out a block
of time in turn (the jackknife), as errors of a car last long.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from identification.fits.values_by_ground_and_recording import ParameterEstimate
from identification.reading.car_as_mean_wheel import RackRecording
from identification.reading.car_units_and_signs import MOVING, require_unclipped
from identification.reading.yaw_rate_from_angle import smoothed_rate
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.rig_and_tyre import EVEN
from symbolic.vehicle.contact_about_kingpin import Contact
from symbolic.vehicle.steering import jacking_torque, mean_wheel_angle, rack_lever
from symbolic.vehicle.vehicle import RANGES, Vehicle

PLATE_FRICTION = 0.005
"""Friction of turntables on balls goes up to it [1]; its mean is taken off the gear's."""
MIN_SPEED_SHARE, STEADY_SHARE = 0.5, 0.6
"""Share of the median speed below which a sample is left out, and share
of the samples with the least acceleration that stay [1]."""
BLOCKS, MIN_SAMPLES = 20, 200
REACH = 0.6
"""Share of the way to either lock that is needed [1]."""
APART = 0.2
"""Share of friction's regressor that those of the others leave, at least [1]."""
POOR = 0.1
"""Standard deviation of the gear's friction over it, beyond which it is not known [1]."""
MAX_FRICTION_RATIO = 2.0
"""Largest friction of a gear over its declared value [1]."""
UNITS = {"gear_friction": "N", "damping": "N m s/rad", "return_torque": "1", "zero": "N"}
"""Of what is identified, in the order of the regressors."""
DRIVE = "turn from lock to lock slowly and back quickly, then quickly and back slowly"
"""What tells friction from damping."""


@dataclass(frozen=True, kw_only=True)
class PlatesResult:
    """What was identified on plates."""

    gear_friction: ParameterEstimate  # Dry friction of the gear at the rack under no load [N].
    damping: ParameterEstimate  # About one kingpin, of the gear and what moves with it [N m s/rad].
    return_torque: ParameterEstimate  # Factor on the declared return torque [1].
    zero: ParameterEstimate  # Force that is shown without any [N].
    samples: int  # Number of them that were used.
    rms: float  # Of what is left of the force [N].

    @property
    def parameters(self) -> dict[str, ParameterEstimate]:
        """All of them by name."""
        return {name: getattr(self, name) for name in UNITS}


def identify_on_plates(recordings: Sequence[RackRecording], vehicle: Vehicle) -> PlatesResult:
    """Least squares over the samples in which the rack moves evenly."""
    rows, forces = zip(*(_regressors_and_force(one, vehicle) for one in recordings), strict=True)
    A, force = np.concatenate(rows), np.concatenate(forces)
    names = ", ".join(one.name for one in recordings)
    if force.size < MIN_SAMPLES:
        raise InvalidInputError(
            f"{names}: the rack moves evenly in {force.size} samples; allowed: from {MIN_SAMPLES} on"
        )
    alone = A[:, 0] - A[:, 1:] @ _least_squares(A[:, 1:], A[:, 0])
    if not np.linalg.norm(alone) > APART * np.linalg.norm(A[:, 0]):
        raise InvalidInputError(
            f"{names}: the rack moves at one speed to a side, so that its friction and its damping"
            f" are the same; {DRIVE}"
        )
    value = _least_squares(A, force)
    residual = force - A @ value
    edges = np.linspace(0, force.size, BLOCKS + 1).astype(int)
    others = [np.r_[0:a, b : force.size] for a, b in pairwise(edges)]
    without = np.array([_least_squares(A[kept], force[kept]) for kept in others])
    variance = (BLOCKS - 1) * without.var(axis=0)
    plates = PLATE_FRICTION * full_slide_rack_force(vehicle)
    value[0] -= plates / 2
    # Levers make the force out of torques, and the return torque out of the way.
    lengths = EVEN * vehicle.tolerances.geometry * value
    variance += lengths**2 * np.array([1, 4, 2, 1])
    variance[0] += (EVEN * plates / 2) ** 2
    if not value[0] > 0 or variance[0] > (POOR * value[0]) ** 2:
        raise InvalidInputError(
            f"{names}: gear friction is {value[0]:.0f} ± {variance[0] ** 0.5:.0f} N, it and damping are"
            f" hard to tell apart; allowed: up to {100 * POOR:.0f} %; {DRIVE}, the"
            " front wheels on turntables"
        )
    if value[0] > MAX_FRICTION_RATIO * vehicle.gear_friction:
        raise InvalidInputError(
            f"{names}: gear friction is {value[0]:.0f} N, more than {MAX_FRICTION_RATIO:g} times what"
            " the vehicle file declares: the plates hold the tyres, or declare gear_friction"
        )
    if value[1] > (most := RANGES["damping"][1]):
        raise InvalidInputError(
            f"{names}: damping about one kingpin is {value[1]:.0f} N m s/rad; allowed: up to {most:g};"
            " the plates drag, or the force has another unit"
        )
    estimates = {
        name: ParameterEstimate(value=float(x), std=float(v**0.5), unit=unit)
        for (name, unit), x, v in zip(UNITS.items(), value, variance, strict=True)
    }
    return PlatesResult(**estimates, samples=force.size, rms=float(residual.std()))


def _regressors_and_force(recording: RackRecording, vehicle: Vehicle) -> tuple[Array, Array]:
    """Regressors and force, of even motion alone."""
    s, t = recording.s, recording.t
    require_unclipped(recording.name, recording.at_limit, "less return torque")
    if not (s.max() > REACH * vehicle.rack_travel and s.min() < -REACH * vehicle.rack_travel):
        raise InvalidInputError(
            f"{recording.name}: the rack goes from {s.min():.3g} to {s.max():.3g} m; turn it beyond"
            f" {REACH * vehicle.rack_travel:.3g} m to either side"
        )
    rate = smoothed_rate(t, s)
    acceleration = smoothed_rate(t, rate)
    side: Array = np.sign(rate)
    moving = np.abs(rate) > MOVING
    moving &= np.abs(rate) > MIN_SPEED_SHARE * np.median(np.abs(rate[moving]))
    size = np.abs(acceleration)
    even = moving & (size < np.quantile(size[moving], STEADY_SHARE))
    lift = 2 * jacking_torque(vehicle, mean_wheel_angle(vehicle, s)) / rack_lever(vehicle, s)
    by_load = lift + vehicle.gear_load_share * np.abs(lift) * side
    drag = 2 * rate / rack_lever(vehicle, s) ** 2
    regressors: Array = np.column_stack([side, drag, by_load, np.ones_like(s)])
    force = recording.force - vehicle.moved_mass * acceleration
    return regressors[even], force[even]


def _least_squares(A: Array, force: Array) -> Array:
    return np.asarray(np.linalg.lstsq(A, force, rcond=None)[0], dtype=np.float64)


def full_slide_rack_force(vehicle: Vehicle) -> float:
    """Force on the rack of both tyres that slide, mu = 1 [N]."""
    arm = Contact.from_vehicle(vehicle, brakes=True).slide_arm
    return 2 * vehicle.wheel_load * arm / vehicle.steering_arm
