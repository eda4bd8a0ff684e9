"""A parked car that drives off by itself
======================================

Steer while parked, learn the friction, and limit the torque of the drive-off by it.

.. code-block:: sh

    python examples/drive_off.py

The steering is that of the independent car of the reference rig, turned by its own motor, seen over a
bus with quantisation and jitter; load, half-length and stiffness are declared wrongly, within their
tolerances. The driveline is simple: two driven front wheels with a brush for the slip along, less
friction the faster the tread slides, and a traction control that takes torque away where it slips, late
as a real one. The car asks for as much torque as it needs on dry ground. Knowing friction, it asks for
no more than nine tenths of what both tyres hold; where friction is not usable, it says so and drives off
by the least that it expects, ice.
"""

import sys
from dataclasses import dataclass, replace
from math import exp, nan
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from observers import Ekf, Loop
from observers.interfaces.car_observer import RackSampler, car_observer
from reference_rig import CAR_STEP, Car, CarBus, CarRecording, record_car, simulate_car
from symbolic import Vehicle, VehicleTolerances

GROUNDS = {"ice": 0.05, "snow": 0.1, "wet cobbles": 0.4, "dry asphalt": 0.9}
CAR = Car(axle_load=7500.0)
VEHICLE = Vehicle(
    front_axle_load=0.96 * CAR.axle_load, tyre_width=0.205, pressure=2.4e5, wheelbase=CAR.wheelbase,
    track=1.38, half_length=1.05 * CAR.tyre.half_length, contact_width=2 * CAR.tyre.half_width,
    stiffness=0.9 * CAR.tyre.k, steering_arm=0.128, inclination=CAR.kingpin.inclination,
    caster=CAR.kingpin.caster, trail=CAR.kingpin.trail, scrub_radius=CAR.kingpin.scrub_radius,
    wheel_radius=CAR.kingpin.radius, rack_mass=CAR.moved_mass, gear_friction=200.0,
    tolerances=VehicleTolerances(gear_friction=0.15),
)  # fmt: skip
"""What is declared: load 4 % too low, half-length 5 % too large, stiffness 10 % too low; friction of the
gear 20 N too large, within 15 %, as after a measurement on plates."""
BUS = CarBus(force_zero=15.0)
ENDS, RACK_SPEED = (0.0, 0.045, -0.025, 0.02, 0.0), 0.02
"""Ways at which the rack turns round [m], and its speed [m/s]."""

MASS, INERTIA, RADIUS = 1300.0, 1.2, 0.31
"""Car [kg]; a driven wheel with its share of the driveline [kg m^2] and its radius [m]."""
LOAD, SLIP_STIFFNESS, FADING = CAR.axle_load / 2, 18.0, 0.2
"""Of a driven wheel [N]; its force over slip and load [1]; share of friction that fades as it slides."""
WANTED, SHARE = 0.45, 0.9
"""Force that is asked for over the load of the driven wheels, and share of friction that is used [1]."""
LEAST = 0.05
"""Friction that is acted on where none is usable, the least that is expected [1]."""
STEP, FAST, SLIPPING = 1e-3, 3.0, 0.3
"""Step [s]; speed of the car at which it has driven off [m/s]; speed of the tread that is slip [m/s]."""
LATE, CUT, RISE = 0.08, 0.5, 2.0
"""Traction control: delay [s], share of the torque that it leaves, and rise of that share [1/s]."""


@dataclass(frozen=True)
class DriveOff:
    """Time in which the wheels slip, and time and way until the car has driven off [s], [m]."""

    slip: float
    time: float
    way: float


def steered(mu: float) -> CarRecording:
    """What the bus shows while the parked car turns its wheels."""
    car = replace(CAR, mu=(mu, mu))
    times = np.cumsum([0.5, *np.abs(np.diff(ENDS)) / RACK_SPEED])
    path = np.interp(np.arange(0.0, times[-1] + 0.3, CAR_STEP), times, ENDS)
    width = round(0.2 / CAR_STEP)
    path = np.convolve(np.pad(path, width, mode="edge"), np.ones(width) / width, "valid")
    return record_car(1, car, simulate_car(car, path, by_rack=True), bus=BUS)


def friction_of(seen: CarRecording) -> tuple[float, float, str]:
    """Friction and its deviation by the last sample, NaN where it is not usable, and what is wrong."""
    loop = Loop(car_observer(Ekf, VEHICLE, brakes=True))
    sample_of = RackSampler(VEHICLE, brakes=True)
    for measured in zip(seen.t.tolist(), seen.rack.tolist(), seen.F_rack.tolist(), strict=True):
        now = loop(sample_of(*measured))
    return (now.mu_eff, now.mu_eff_std, "") if now.usable else (nan, nan, now.remedy)


def drive_off(mu: float, known: float = nan) -> DriveOff:
    """Drive off on a friction, from rest until FAST; torque limited by one known or not."""
    most = WANTED if np.isnan(known) else min(WANTED, SHARE * known)
    v, tread, t, way, slip, share = 0.0, 0.0, 0.0, 0.0, 0.0, 1.0
    slid: list[bool] = []
    while v < FAST and t < 60.0:
        sliding = tread - v
        slid.append(sliding > SLIPPING)
        noticed = len(slid) > LATE / STEP and slid[-1 - round(LATE / STEP)]
        share = share * (1 - (1 - CUT) * STEP / LATE) if noticed else min(1.0, share + RISE * STEP)
        torque = most * LOAD * RADIUS * min(1.0, t / 0.2) * share
        hold = mu * LOAD * (1 - FADING * (1 - exp(-abs(sliding))))
        # A brush: the deformation over that of full slide, of a tread that rolls at 0.5 m/s at least.
        u = min(1.0, SLIP_STIFFNESS * LOAD * abs(sliding) / max(tread, 0.5) / (3 * hold))
        force = float(np.sign(sliding)) * hold * (3 * u - 3 * u**2 + u**3)
        tread += RADIUS * (torque - RADIUS * force) / INERTIA * STEP
        v += 2 * force / MASS * STEP
        way, t, slip = way + v * STEP, t + STEP, slip + STEP * slid[-1]
    return DriveOff(slip=slip, time=t, way=way)


def main() -> None:
    """Print slip and time of the drive-off by ground."""
    print(
        f"slip of the time to {FAST:g} m/s: {'without':>16} {'by the true friction':>20} by the estimate"
    )
    for ground, mu in GROUNDS.items():
        found, std, remedy = friction_of(steered(mu))
        without, true, by_estimate = (
            drive_off(mu, known) for known in (nan, mu, LEAST if remedy else found)
        )
        cells = "   ".join(
            f"{one.slip:5.2f} s of {one.time:5.2f} s" for one in (without, true, by_estimate)
        )
        print(f"{ground:14}{mu:5.2f}   {cells}   mu = {found:.3f} +- {std:.3f}")
        if remedy:
            print(f"{ground}: friction is not usable, drives off as on {LEAST:g}: {remedy}")


if __name__ == "__main__":
    main()
