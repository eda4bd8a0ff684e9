"""`brushgrip codegen`."""

from dataclasses import asdict, dataclass
from enum import StrEnum

from brushgrip.commands.options import (
    EffectModules,
    ModelFile,
    OutFolder,
    RigAlone,
    StiffnessState,
    TorqueMeasured,
    TuningProfile,
    TuningValues,
    VehicleAlone,
    option,
)
from brushgrip.inputs.option_choices import ModelObserverName, TorqueChannel

RealType = StrEnum("RealType", {"FLOAT": "float", "DOUBLE": "double"})
Target = StrEnum("Target", {"C": "c", "FMU": "fmu", "FMU3": "fmu3", "ROS2": "ros2"})
RunTime = StrEnum("RunTime", {"TUNING": "tuning", "ALL": "all"})
"""What a user chooses from: types of number by their name in C, what is written, and what the code takes
at run time."""


@dataclass(frozen=True, kw_only=True)
class CodegenRequest:
    """Write an observer as C99 for an embedded target, or as an FMU: no heap, one type of number.

    NAME.h and NAME.c are all that the target needs, NAME.hpp is a class of C++17 around them. main.c is
    an example that reads a recording; check.c holds a build against NAME_vector.csv, what Python made of
    400 samples; NAME.json says what parameters it was made with; NAME_sfun.c is an S-function for
    Simulink. With --target fmu, NAME.fmu holds the same C with sources and a library for 64-bit Linux:
    co-simulation by FMI 2.0 (fmu3: 3.0), a communication step is a sample. With --target ros2 it is a
    package with a node.

    With --tunable tuning the code takes prior, noises and limits at run time, with all also model and
    rig: NAME_set_parameters in C, described by NAME.a2l for calibration tools, and tunable parameters
    of an FMU.

    With --vehicle in place of --rig the observer is that of a car: NAME_vehicle.h makes its samples from
    the rack or the handwheel (target c), its wheels held or not as the file says.

    The prior is that of the tuning (--tune mu=0.8,mu_std=0.2), not the mu of the rig file. The first
    line says what a step will cost.

    Files that an earlier codegen wrote are replaced; any other file in the way is a fault.
    """

    out: OutFolder
    observer: ModelObserverName = option(
        "--observer", help="Observer to write; ekf if left out.", default=ModelObserverName.EKF
    )
    rig: RigAlone = None
    vehicle: VehicleAlone = None
    model: ModelFile = None
    effects: EffectModules = None
    tuning: TuningProfile = None
    tune: TuningValues = None
    window: int | None = option("--window", "N", "Samples that the MHE fits at once; 50 if left out.")
    ground: str | None = option(
        "--ground",
        "NAME",
        "Ground whose values are taken from the model file; the mean over its grounds without.",
    )
    real: RealType = option(
        "--real", help="Type of every number.", default=RealType.FLOAT, show_default=True
    )
    target: Target = option("--target", help="What to write.", default=Target.C, show_default=True)
    torque: TorqueMeasured = TorqueChannel.GROUND
    stiffness_state: StiffnessState = None
    no_acquire: bool = option(
        "--no-acquire",
        help="Leave out the acquisition, for fewer instructions: friction is followed from the prior"
        " alone, and may be wrong while usable where the prior is far off, as on ice; wrong units"
        " and signs are not noticed.",
        default=False,
    )
    tunable: RunTime | None = option(
        "--tunable",
        help="Parameters that the code takes at run time: the tuning, or all: model, rig and tuning.",
    )
    name: str = option(
        "--name", "NAME", "Begins every name in C.", default="brushgrip", show_default=True
    )

    def run(self) -> None:
        """Write an observer as C, as an FMU or as a package of ROS 2."""
        from brushgrip.estimation.recording_warnings import direction_deficit_and_note
        from brushgrip.inputs.command_inputs import gather_inputs
        from brushgrip.inputs.model_observer_from_options import (
            model_observer_from_options,
            rig_or_vehicle_file,
            window_setting,
        )
        from brushgrip.inputs.option_values import chosen_tuning
        from brushgrip.outputs import observer_as_c_fmu_ros as export
        from brushgrip.outputs.atomic import staged_directory
        from brushgrip.outputs.console import print_line, show_json
        from brushgrip.outputs.provenance import origin_comment
        from observers.embedded import generate_vehicle, require_replaceable
        from observers.embedded.estimated_instructions import estimated_instructions
        from observers.interfaces.observer_from_files import read_vehicle_file
        from symbolic import InvalidInputError

        window = window_setting(self.observer, self.window)
        tuning = chosen_tuning(self.tuning, self.tune)
        inputs = gather_inputs(
            rig=self.rig, model=self.model, effects=self.effects, vehicle=self.vehicle
        )
        observer = model_observer_from_options(
            self.observer, self.torque, inputs, tuning, self.ground,
            stiffness_state=self.stiffness_state, acquire=not self.no_acquire, **window,
        )  # fmt: skip
        found = inputs.read_found_model()
        if self.ground is not None and not (found and found.grounds):
            raise InvalidInputError(f"--ground {self.ground}: this model knows no grounds; leave it out")
        real, tunable = export.TYPES[self.real], export.TUNABLE[self.tunable or ""]
        cost = estimated_instructions(observer, real, tunable)
        with staged_directory(self.out) as stage:
            write = export.WRITERS[self.target]
            files = write(observer, stage, real, name=self.name, tunable=tunable)
            if self.vehicle is not None and self.target == "c":
                car = read_vehicle_file(self.vehicle)
                files += generate_vehicle(car, stage, real, name=self.name)
            finals = [self.out.resolve() / path.name for path in files]
            size = export.state_size_from_header(files, self.name)
            export.append_origin(files, origin_comment(rig_or_vehicle_file(inputs), self.model))
            inputs.refuse_overwriting(finals)
            require_replaceable(finals)
        # After the files are there: whoever reads the first line alone has them all the same.
        print_line(f"{f'{size:,} bytes a wheel, ' if size else ''}{cost}")
        print_line(export.prior_in_words(observer, self.rig))
        export.remove_stale_description(self.out / f"{self.name}.a2l", finals)
        if found is not None:
            _, unlike = direction_deficit_and_note(found.values_for_estimation(self.ground))
            for line in filter(None, (found.ground_used_text(self.ground), unlike)):
                print_line(line)
        show_json({"wrote": list(map(str, finals)), "cost": {"state_bytes": size, **asdict(cost)}})
        print_line(f"wrote {', '.join(path.name for path in files)} to {self.out}")
