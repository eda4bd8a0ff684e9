"""Vehicle files and logs of random independent cars, as declared or with their tyres identified."""

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from brushgrip.cli.app import main as main_of_command
from reference_rig import TOLERANCES, CarRecording, FleetCar
from symbolic.vehicle.vehicle import VehicleTolerances

KNOWN_FRICTION, KNOWN_WITHIN = 0.9, 0.05
"""Friction of the ground on which tyres are identified; tolerance of it, as a share [1]."""
LOAD_CHANGE = 0.03
"""Change of the load after that, either way, as a share [1]."""
FORCE_SCALE = VehicleTolerances().force_scale
"""Error of the scale of a measured force or torque, either way, as a share [1]."""
COLUMNS = {
    "rack": ("rack", "F_rack"),
    "pinion": ("handwheel", "T_bar", "T_motor"),
    "handwheel": ("handwheel", "T_bar"),
}
"""Channels that a sensing takes."""


def vehicle_toml(declared: Mapping[str, float], *, brake: bool, handwheel_inertia: float = 0.0) -> str:
    """The vehicle file, with the tolerances where they are declared."""

    def tolerated(name: str) -> str:
        value = declared[name]
        return f"{{ value = {value:.6g}, tolerance = {TOLERANCES[name] * value:.6g} }}"

    def plain(*names: str) -> dict[str, str]:
        return {name: f"{declared[name]:.6g}" for name in names}

    lines = {
        "front_axle_load": tolerated("axle_load"),
        "tyre": '"205/55 R16"',
        "pressure": "2.4e5",
        **plain("wheelbase", "track"),
        "steering_ratio": f"{declared['lever'] / declared['pinion_radius']:.6g}",
        "steering_arm": f"{declared['lever']:.6g}",
        "half_length": tolerated("half_length"),
        "contact_width": f"{2 * declared['half_width']:.6g}",
        "stiffness": tolerated("k"),
        **plain("trail", "scrub_radius", "inclination", "caster"),
        **plain("rack_travel", "lever_loss", "ackermann"),
        "gear_friction": tolerated("gear_friction"),
        **plain("gear_load_share"),
        "rack_mass": f"{declared['moved_mass']:.6g}",
        "handwheel_inertia": f"{handwheel_inertia:.6g}",
        **plain("torsion_bar", "motor_ratio"),
        "motor_efficiency": "1.0",
        "brakes": "true" if brake else "false",
        "geometry": f"{{ tolerance = {TOLERANCES['wheelbase']:g} }}",
    }
    return "[vehicle]\n" + "".join(f"{key} = {value}\n" for key, value in lines.items())


def write_recording(path: Path, recording: CarRecording, sensing: str) -> None:
    """The bus as a CSV; a car without assistance shows the torque at its handwheel as T_bar."""
    names = ("t", *COLUMNS[sensing], "brake", "speed")
    shown = {name: getattr(recording, name) for name in names}
    if sensing == "handwheel":
        shown["T_bar"] = recording.T_hand
    table = np.column_stack([shown[name] for name in names])
    np.savetxt(path, table, fmt="%.8g", delimiter=",", header=",".join(names), comments="")


def with_force_scale(recording: CarRecording, seed: int, *, full: bool = False) -> CarRecording:
    """The same by sensors of the rack's force and the handwheel's torque whose scale is off.

    Of an assisted car's torques, motor and pinion are off already. With `full` it is off by all of
    `FORCE_SCALE`.
    """
    error = float(np.random.default_rng([seed, 26]).uniform(-1, 1))
    gain = 1 + FORCE_SCALE * (float(np.sign(error)) if full else error)
    return replace(recording, F_rack=gain * recording.F_rack, T_hand=gain * recording.T_hand)


def declared_toml(drawn: FleetCar, sensing: str) -> str:
    """The vehicle file of a car as it is declared."""
    # The torque at the handwheel turns its inertia too, known as well as the rack's mass.
    share = (sensing == "handwheel") * drawn.declared["moved_mass"] / drawn.true["moved_mass"]
    inertia = share * drawn.car.handwheel_inertia
    return vehicle_toml(drawn.declared, brake=drawn.brake, handwheel_inertia=inertia)


def run_command(*arguments: str | Path) -> None:
    """Run the command line, quietly.

    Raises:
        RuntimeError: it does not end well.
    """
    try:
        main_of_command(["--quiet", *map(str, arguments)])
    except SystemExit as done:
        if done.code:
            raise RuntimeError(f"{arguments[0]}: status {done.code}") from None


def calibrated_toml(drawn: FleetCar, sensing: str, *, full: bool = False) -> tuple[str, FleetCar]:
    """The vehicle file with the tyres identified, and the car, its load changed since.

    The car drives on ground that is known within `KNOWN_WITHIN`, with brakes held or not. Where the
    command refuses, the file stays as declared. With `full`, friction of the ground and load are off by
    all of their tolerances.
    """
    rng = np.random.default_rng([drawn.seed, 24])
    of_ground, of_brake, of_load = rng.uniform(-1, 1), rng.uniform(), rng.uniform(-1, 1)
    if full:
        of_ground, of_load = np.sign([of_ground, of_load])
    mu = KNOWN_FRICTION * (1 + KNOWN_WITHIN * of_ground)
    there = replace(
        drawn, seed=drawn.seed + 10**6, car=replace(drawn.car, mu=(mu, mu)), brake=of_brake < 0.5
    )
    change = 1 + LOAD_CHANGE * of_load
    tyre = replace(drawn.car.tyre, half_length=change * drawn.car.tyre.half_length)
    loaded = replace(drawn.car, axle_load=change * drawn.car.axle_load, tyre=tyre)
    text = declared_toml(drawn, sensing)
    with tempfile.TemporaryDirectory() as name:
        file, log, new = (Path(name) / one for one in ("car.toml", "log.csv", "new.toml"))
        file.write_text(text, encoding="utf-8")
        write_recording(log, with_force_scale(there.drive(), drawn.seed, full=full), sensing)
        known = ("--ground-friction", f"{KNOWN_FRICTION}")
        known += ("--friction-tolerance", f"{KNOWN_WITHIN * KNOWN_FRICTION}")
        try:
            run_command(
                "identify", "--vehicle", file, "--lock-to-lock", log, *known, "--write-vehicle", new
            )
            text = new.read_text(encoding="utf-8")
        except RuntimeError as error:
            print(f"{drawn.seed}: {error}, stays as declared")
    return text, replace(drawn, car=loaded)
