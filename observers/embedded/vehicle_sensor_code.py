"""C of a car's sensors: the sample of its mean front wheel, see `templates/vehicle.h`."""

from pathlib import Path

import casadi as ca

from observers.embedded.generated_file_overwriting import file_mark, write_generated
from observers.embedded.jinja_templates import render
from observers.embedded.scalar_type import Real, code_in_type, prefix_own_c_names
from observers.layout import symbols
from symbolic.compilation.scalar_c import c_function
from symbolic.named_and_buffered_functions import named_function
from symbolic.vehicle.mean_wheel import wheel_from_rack
from symbolic.vehicle.steering import pinion_angle, rack_force, rack_position
from symbolic.vehicle.vehicle import Vehicle


def generate_vehicle(vehicle: Vehicle, folder: str | Path, real: Real, *, name: str) -> list[Path]:
    """Write and return NAME_vehicle.h beside an observer's C: rack or handwheel to `NAME_sample_t`.

    Folder, type and name are those of that C; the vehicle's `brakes` say whether the wheels are held.
    """
    written = [c_function(f.name(), f, real.c_type) for f in rack_and_handwheel_functions(vehicle)]
    if vehicle.rack_by_handwheel:
        written.insert(0, "#include <stdbool.h>\n")
    terms = {
        "name": name, "NAME": name.upper(), "real": real.c_type, "generated": file_mark(),
        "functions": "\n".join(written), "load": real.literal(vehicle.wheel_load),
        "standstill": real.literal(vehicle.standstill),
        "held": "held by the brakes" if vehicle.brakes else "free to roll about the kingpin",
    }  # fmt: skip
    text = prefix_own_c_names(code_in_type(render("vehicle.h", terms), real), name)
    return write_generated(folder, {f"{name}_vehicle.h": text})


def rack_and_handwheel_functions(vehicle: Vehicle) -> list[ca.Function]:
    """From the rack and from the handwheel.

    (rack, force, speed, acceleration) -> (psi, M_z), and (handwheel, T_bar, T_motor) -> (rack, force).
    """
    of_rack = symbols(ca.SX, rack=1, force=1, speed=1, acceleration=1)
    of_handwheel = symbols(ca.SX, handwheel=1, T_bar=1, T_motor=1)
    handwheel, bar, motor = of_handwheel.values()
    psi, M_z = wheel_from_rack(vehicle, *of_rack.values(), brakes=vehicle.brakes)
    pinion = pinion_angle(vehicle, handwheel, bar)
    way, force = rack_position(vehicle, handwheel, bar), rack_force(vehicle, bar, motor, pinion)
    return [
        named_function("wheel_of_rack", of_rack, {"psi": psi, "M_z": M_z}, cse=True),
        named_function("rack_of_handwheel", of_handwheel, {"rack": way, "force": force}, cse=True),
    ]
