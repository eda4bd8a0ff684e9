"""`brushgrip identify`."""

from dataclasses import asdict, dataclass
from pathlib import Path

from brushgrip.commands.options import (
    ChannelMap,
    OutJson,
    RigFile,
    VehicleFile,
    option,
    output_file_option,
)

USUAL_TOLERANCE = 0.05
"""Of the friction of a ground that is called known, as a share of it [1]."""


@dataclass(frozen=True, kw_only=True)
class IdentifyRequest:
    """Identify k and b_t from free vibrations, or a car's gear, with standard deviations.

    A recording needs t and psi alone; lines such as '# a = 0.045' before the header override the rig
    for that recording. a, e and J_A are required. A picture of the fit goes beside ID.json.

    With --vehicle and --plates, of a car: friction of its gear, zero and return torque, from lock to
    lock slowly and back quickly, then quickly and back slowly, the front wheels on turntables. With
    --lock-to-lock and --ground-friction: torque of full slide and stiffness of its tyres.
    """

    free_decay: list[str] | None = option(
        "--free-decay",
        "REC...",
        "Recordings of the wheel swinging freely after an impact: one or more after the flag.",
    )
    plates: list[str] | None = option(
        "--plates", "REC...", "Recordings of a car whose front wheels stand on turntables."
    )
    lock_to_lock: list[str] | None = option(
        "--lock-to-lock",
        "REC...",
        "Recordings of a car that stands on ground of known friction and steers from lock to lock.",
    )
    ground_friction: float | None = option("--ground-friction", "MU", "Friction of that ground, known.")
    friction_tolerance: float | None = option(
        "--friction-tolerance", "DMU", "How far off that may be, either way; 5 % of it if left out."
    )
    vehicle: VehicleFile = None
    out: OutJson = None
    rig: RigFile = None
    channel_map: ChannelMap = None
    write_rig: Path | None = output_file_option(
        "--write-rig", "R", "Rig file to write: that of --rig with the k and b_t found."
    )

    write_vehicle: Path | None = output_file_option(
        "--write-vehicle", "CAR", "Vehicle file to write: that of --vehicle with what was found."
    )

    def run(self) -> None:
        """Write what was asked for.

        Raises:
            InvalidInputError: what was asked for is neither of a rig nor of a car.
        """
        from symbolic import InvalidInputError

        of_rig = (self.free_decay, self.rig, self.write_rig)
        of_ground = (self.lock_to_lock, self.ground_friction, self.friction_tolerance)
        of_car = (self.plates, self.write_vehicle, *of_ground)
        if self.lock_to_lock and self.ground_friction is None:
            raise InvalidInputError(
                "--lock-to-lock needs the friction of the ground, --ground-friction 0.9: without it, the"
                " torque of full slide tells nothing about the tyres"
            )
        if self.vehicle is None and self.free_decay and not any(of_car):
            self._run_free_decay(self.free_decay)
        elif self.vehicle is not None and self.plates and not any((*of_rig, *of_ground)):
            self._run_car(self.vehicle, self.plates)
        elif self.vehicle is not None and self.lock_to_lock and not any((*of_rig, self.plates)):
            self._run_car(self.vehicle, self.lock_to_lock)
        else:
            raise InvalidInputError(
                "give --free-decay, with --rig and --write-rig, or --vehicle with --plates, or with"
                " --lock-to-lock and --ground-friction, and --write-vehicle"
            )

    def _run_car(self, vehicle: Path, recordings: list[str]) -> None:
        """Write what recordings on plates, or on ground of known friction, tell of a car."""
        from brushgrip.inputs.command_inputs import gather_inputs, require_brakes_known
        from brushgrip.outputs.atomic import is_same_file, staged_files, write_utf8
        from brushgrip.outputs.console import print_line, show_json
        from brushgrip.outputs.provenance import KEY
        from brushgrip.outputs.rig_and_vehicle_files import identified_vehicle_text
        from brushgrip.report.print_diagnosis_and_fits import print_car_result
        from brushgrip.wording.formatting import json_text, listed
        from identification import read_vehicle
        from identification.reading.car_as_mean_wheel import read_rack_recording
        from identification.steering.gear_friction_on_plates import PlatesResult, identify_on_plates
        from identification.steering.tyres_on_known_friction import TyresResult, identify_tyres
        from symbolic import InvalidInputError

        written = self.write_vehicle
        finals = [path for path in (self.out, written) if path]
        if self.out and written and is_same_file(self.out, written):
            raise InvalidInputError(f"{written}: --write-vehicle and --out must name different files")
        inputs = gather_inputs(recordings, vehicle=vehicle, channel_map=self.channel_map)
        inputs.refuse_overwriting(finals)
        car = read_vehicle(vehicle)
        comments: dict[str, str] = {}
        with staged_files(finals) as stages:
            if self.plates:
                racks = [
                    read_rack_recording(path, car, inputs.signals) for path in inputs.paths.values()
                ]
                result: PlatesResult | TyresResult = identify_on_plates(racks, car)
            else:
                read, mu = inputs.recordings(), self.ground_friction or 0.0
                require_brakes_known(inputs.vehicle, read)
                told = self.friction_tolerance
                off = USUAL_TOLERANCE * mu if told is None else told
                result = identify_tyres(read, car, friction=mu, tolerance=off)
                on = f"on ground of mu {mu:g} ± {off:g}"
                comments["slide_factor"] = f"{on}, load {car.front_axle_load:g} N"
            document = {"plates" if self.plates else "tyres": asdict(result), KEY: inputs.provenance()}
            if self.out:
                write_utf8(stages[0], json_text(document))
            if written:
                write_utf8(stages[-1], identified_vehicle_text(vehicle, car, result, comments))
        print_car_result(result, car)
        if finals:
            print_line(f"wrote {listed(list(map(str, finals)))}")
        show_json(document)

    def _run_free_decay(self, recordings: list[str]) -> None:
        """Write k and b_t from free vibrations, and a picture of the fit."""
        import identification
        from brushgrip.inputs.command_inputs import gather_inputs
        from brushgrip.outputs.atomic import is_same_file, staged_files, table_and_picture, write_utf8
        from brushgrip.outputs.console import print_line, show_json
        from brushgrip.outputs.provenance import KEY
        from brushgrip.outputs.rig_and_vehicle_files import declared_rig, identified_rig_text
        from brushgrip.pictures.free_decay_fit_quality import draw_free_decay
        from brushgrip.report.print_diagnosis_and_fits import print_free_decay
        from brushgrip.wording.formatting import free_decay_document, json_text, listed
        from identification.thesis import estimate_by_decrement
        from symbolic import BrushgripError, InvalidInputError

        written = self.write_rig
        results = table_and_picture(self.out)
        if written and any(is_same_file(written, other) for other in results):
            raise InvalidInputError(f"{written}: --write-rig and --out must name different files")
        finals = [*results, *([written] if written else [])]
        inputs = gather_inputs(recordings, rig=self.rig, channel_map=self.channel_map)
        inputs.refuse_overwriting(finals)
        decays = inputs.decays()
        declared = declared_rig(decays, self.rig) if written else None
        with staged_files(finals) as stages:
            result = identification.identify_free_decay(decays)
            if not result.converged:
                raise BrushgripError(f"k and b_t were {result.status}: {result.remedy}")
            decrement = estimate_by_decrement(decays)
            document = free_decay_document(result, decrement) | {KEY: inputs.provenance()}
            if results:
                write_utf8(stages[0], json_text(document))
                draw_free_decay(stages[1], result, decrement)
            if declared:
                write_utf8(stages[-1], identified_rig_text(*declared, self.rig, result))
        print_free_decay(result, decrement)
        if finals:
            print_line(f"wrote {listed(list(map(str, finals)))}")
        show_json(document)
