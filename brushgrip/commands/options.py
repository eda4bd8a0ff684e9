"""Arguments and options that several commands share, and checks of the files they name."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from brushgrip.inputs.option_choices import ObserverName, TorqueChannel, TuningPreset

if TYPE_CHECKING:
    from brushgrip.inputs.command_inputs import Inputs

MAX_JOBS = 256
OPTION = "option"
"""Where the metadata of a field have its option."""


def shared(flag: str, metavar: str | None = None, help: str = "", **settings: Any) -> Any:
    """The annotation of an option of several commands, whose default the help does not show."""
    return typer.Option(flag, metavar=metavar, help=help, show_default=False, **settings)


def option(
    flag: str, metavar: str | None = None, help: str = "", *, default: Any = None, **settings: Any
) -> Any:
    """A field that an option of one command fills; its default is shown where `show_default` is set."""
    settings = {"metavar": metavar, "help": help, "show_default": False, **settings}
    return field(default=default, metadata={OPTION: typer.Option(default, flag, **settings)})


def valid_file_name(path: Path | None) -> Path | None:
    """The name of a file to write, as given; none that names a folder by its place, as `/`."""
    if path is not None and path.name in ("", ".."):
        from symbolic import InvalidInputError

        raise InvalidInputError(f"{str(path)!r} names no file to write; give one such as out.csv")
    return path


def valid_folder_name(path: Path | None) -> Path | None:
    """The name of a folder to write to, as given; a loop of links, or one too long, is refused."""
    if path is not None:
        from brushgrip.outputs.atomic import as_input_error

        with as_input_error(path):
            path.resolve().exists()
    return path


def model_file_in_folder(path: Path | None) -> Path | None:
    """The name of a model file: of a folder of a diagnosis, that in it."""
    from observers.interfaces.observer_from_files import model_file_in

    return None if path is None else model_file_in(path)


def output_file_option(flag: str, metavar: str, help: str) -> Any:
    """The name of a file to write."""
    return option(flag, metavar, help, callback=valid_file_name)


RigFile = Annotated[
    Path | None,
    shared("--rig", "R", "Rig file (TOML). May be left out where the recordings know a, e and k."),
]
VehicleFile = Annotated[
    Path | None,
    shared(
        "--vehicle",
        "CAR",
        "Vehicle file (TOML) of a car, in place of a rig: recordings then have rack or handwheel,"
        " and F_rack or T_bar and T_motor.",
    ),
]
RigAlone = Annotated[Path | None, shared("--rig", "R", "Rig file (TOML).")]
VehicleAlone = Annotated[Path | None, shared("--vehicle", "CAR", "Vehicle file (TOML) of a car.")]
ObserverUsed = Annotated[ObserverName, shared("--observer", help="Observer to use; ekf if left out.")]
StiffnessState = Annotated[
    bool | None,
    typer.Option(
        "--stiffness-state/--stiffness-known",
        help="k is estimated beside friction, as with --model, or known; takes M_z, ekf or mhe.",
    ),
]
TorqueMeasured = Annotated[
    TorqueChannel, typer.Option("--torque", help="Torque measured: aligning, or steering.")
]
ChannelMap = Annotated[
    list[str] | None,
    shared(
        "--map",
        "psi=NAME:deg,...",
        "Channels of the columns with their units and factors, such as"
        " psi=SteeringAngle:deg,t=time:ms,M_z=-Mz,F_N=0.5*Load:kN; goes before [signals] of the rig"
        " file, and in place of several [[signals]] where it has angle, torque and"
        " load. May be repeated: a column that is named again begins the map of recordings with other"
        " channels; each takes the map whose channels it has.",
    ),
]
Force = Annotated[bool, typer.Option("--force", help="Replace what another run wrote into the folder.")]
ModelFile = Annotated[
    Path | None,
    shared(
        "--model",
        "MODEL",
        "Folder of a diagnosis, or its model file (model.json); the declared model without it.",
        callback=model_file_in_folder,
    ),
]
TuningProfile = Annotated[
    TuningPreset | None,
    shared(
        "--tuning",
        help="Tuning by name; real_tyre if left out. A model file's model_error goes before its error,"
        " noise, error_travel and explained; what --tune sets goes before both.",
    ),
]
TuningValues = Annotated[
    list[str] | None,
    shared(
        "--tune",
        "NAME=VALUE",
        "A value of the tuning in place of the profile's, such as mu_walk=0.02. May be repeated;"
        " several may be separated by commas.",
    ),
]
EffectModules = Annotated[
    list[str] | None,
    shared(
        "--effects",
        "MODULE",
        "Module, or its file, with effects of your own, EFFECTS = [MyEffect(), ...]; it is"
        " imported. May be repeated; several may be separated by commas.",
    ),
]
OutJson = Annotated[
    Path | None,
    shared(
        "--out",
        "OUT.json",
        "File to write; left out, the tables here suffice.",
        callback=valid_file_name,
    ),
]
OutFolder = Annotated[Path, shared("--out", "DIR", "Folder to write to.", callback=valid_folder_name)]
OutFile = Annotated[Path, shared("--out", "OUT.csv", "File to write.", callback=valid_file_name)]
Jobs = Annotated[
    int | None, shared("--jobs", "N", "Processes to use; one per core if left out.", min=1, max=MAX_JOBS)
]
Scheduler = Annotated[
    str | None,
    shared(
        "--scheduler",
        "ADDRESS",
        "Scheduler of a Dask cluster that does the work in place of processes here, such as"
        " tcp://10.0.0.1:8786.",
    ),
]


@dataclass(frozen=True, kw_only=True)
class RecordingRequest:
    """What commands that read recordings have in common."""

    recordings: Annotated[
        list[str],
        typer.Argument(
            metavar="REC...",
            help="Recordings: files (.csv, .mat, .mf4, .tdms, .parquet, .h5, .blf and more), or names of"
            " published ones, such as fem1.",
            show_default=False,
        ),
    ]
    rig: RigFile = None
    channel_map: ChannelMap = None
    steering_ratio: float | None = option(
        "--steering-ratio",
        "RATIO",
        "Angle of the steering wheel over that of the wheel, such as 15: psi and psi_dot are"
        " divided by it. A torque from the steering wheel's shaft needs its own"
        " factor: --map M_z=-15*Torque.",
    )
    begin: float | None = option(
        "--from", "T", "Use samples from this time on, as the recording counts it [s]."
    )
    end: float | None = option("--to", "T", "Use samples up to this time [s].")
    effects: EffectModules = None

    def inputs(self, more: Sequence[str] = (), **options: Any) -> "Inputs":
        """The recordings, then those of `more`, with what else is read; see `gather_inputs`."""
        from brushgrip.inputs.command_inputs import gather_inputs

        return gather_inputs(
            [*self.recordings, *more],
            rig=self.rig,
            channel_map=self.channel_map,
            steering_ratio=self.steering_ratio,
            span=(self.begin, self.end),
            effects=self.effects,
            **options,
        )


@dataclass(frozen=True, kw_only=True)
class ModelRunRequest(RecordingRequest):
    """What commands that run a model over recordings have in common."""

    model: ModelFile = None
    ground: list[str] | None = option(
        "--ground",
        "NAME",
        "What the wheel stands on, or NAME=REC,REC for some of the recordings; picks the values"
        " of that ground from the model file.",
    )

    def model_inputs(self, **options: Any) -> "Inputs":
        """The inputs with the model and the grounds."""
        return self.inputs(model=self.model, ground=self.ground, **options)
