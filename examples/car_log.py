"""Logs of a parked car, to try the car with
=========================================

Three BLF logs of a car that is steered while it stands, their DBC file, and its vehicle file.

.. code-block:: sh

    python examples/car_log.py logs
    brushgrip diagnose --vehicle logs/car.toml logs/*.blf --ground yard --out found

The car is the independent one of the reference rig, steered by hand on its brakes, μ = 0.8. Load,
half-length and stiffness are declared wrongly, within their tolerances. Its kingpins lift the body
twice as hard as their declared inclination says: that is to be found. ``--sound`` leaves them as
declared. Needs ``pip install '.[can]'``.
"""

import struct
import sys
from dataclasses import replace
from pathlib import Path

import can
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from reference_rig import Car, CarBus, CarRecording, handwheel_path, record_car, simulate_car

MU, LOGS = 0.8, {"one": 1, "two": 2, "three": 3}
"""Friction, and the seed of each log."""
CAR = Car(axle_load=7500.0, mu=(MU, MU))
TWICE = 2**0.5
"""Times the inclination, whose square the return torque follows."""
FRAME = 0x2F0
DATABASE = f"""VERSION ""
NS_ :
BS_:
BU_: EPS
BO_ {FRAME} Steering: 7 EPS
 SG_ RackTravel : 0|16@1- (0.01,0) [-200|200] "mm" EPS
 SG_ RackForce : 16|16@1- (1,0) [-30000|30000] "N" EPS
 SG_ VehicleSpeed : 32|16@1+ (0.01,0) [0|300] "km/h" EPS
 SG_ BrakePressed : 48|8@1+ (1,0) [0|1] "" EPS
"""
VEHICLE = f"""[vehicle]
front_axle_load = {0.97 * CAR.axle_load:.0f}
tyre = "185/60 R15"
pressure = 2.4e5
wheelbase = {CAR.wheelbase}
track = 1.38
steering_arm = 0.128
half_length = {1.04 * CAR.tyre.half_length:.4f}
contact_width = {2 * CAR.tyre.half_width}
stiffness = {0.9 * CAR.tyre.k:.3g}
inclination = {CAR.kingpin.inclination:.4f}
caster = {CAR.kingpin.caster:.4f}
trail = {CAR.kingpin.trail}
scrub_radius = {CAR.kingpin.scrub_radius}
wheel_radius = {CAR.kingpin.radius}
rack_mass = {CAR.moved_mass:.1f}

[signals]
rack = {{ channel = "RackTravel", unit = "mm" }}
F_rack = {{ channel = "RackForce", unit = "N" }}
brake = "BrakePressed"
speed = {{ channel = "VehicleSpeed", unit = "km/h" }}
"""


def steered(seed: int, *, sound: bool) -> CarRecording:
    """What the bus shows while the parked car is steered by hand."""
    leaning = replace(CAR.kingpin, inclination=TWICE * CAR.kingpin.inclination)
    car = CAR if sound else replace(CAR, kingpin=leaning)
    motion = simulate_car(car, handwheel_path(seed, car.lock / car.pinion_radius))
    return record_car(seed, car, motion, bus=CarBus(force_zero=15.0))


def write_log(path: Path, seen: CarRecording) -> None:
    """The recording as frames of a classical CAN bus."""
    rows = zip(seen.t, 1e5 * seen.rack, seen.F_rack, 360 * seen.speed, seen.brake, strict=True)
    with can.Logger(path) as log:
        for t, *values in rows:
            data = struct.pack("<hhHB", *(round(float(value)) for value in values))
            frame = can.Message(arbitration_id=FRAME, is_extended_id=False, data=data)
            frame.timestamp = 1.7e9 + float(t)
            log.on_message_received(frame)


def main() -> None:
    """Write the logs into the folder that is named, `logs` without one."""
    names = [argument for argument in sys.argv[1:] if not argument.startswith("-")]
    folder = Path(names[0] if names else "logs")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "car.toml").write_text(VEHICLE, encoding="utf-8")
    (folder / "car.dbc").write_text(DATABASE, encoding="utf-8")
    for name, seed in LOGS.items():
        seen = steered(seed, sound="--sound" in sys.argv)
        write_log(folder / f"{name}.blf", seen)
        print(f"{folder / name}.blf: {seen.t[-1]:.0f} s on mu = {MU}, rack force up to"
              f" {np.abs(seen.F_rack).max():.0f} N")  # fmt: skip


if __name__ == "__main__":
    main()
