"""`brushgrip codegen`."""

from collections.abc import Sequence
from pathlib import Path

from brushgrip.atomic import staged_directory
from brushgrip.choices import GeneratedObserver, RealType, Target, TorqueChannel, TuningName
from brushgrip.console import say, show
from brushgrip.provenance import comment
from brushgrip.recordings import keep_inputs
from brushgrip.user_effects import effect_files, user_effects
from identification import read_model
from observers import AligningTorque, Ekf, MeasurementModel, Mhe, SteeringTorque, from_files, profile
from observers.embedded import DOUBLE, SINGLE, generate, generate_fmu, require_replaceable

KINDS = {GeneratedObserver.EKF: Ekf, GeneratedObserver.MHE: Mhe}
TYPES = {RealType.FLOAT: SINGLE, RealType.DOUBLE: DOUBLE}
MEASUREMENT_MODELS: dict[TorqueChannel, MeasurementModel] = {
    TorqueChannel.GROUND: AligningTorque(),
    TorqueChannel.HAND: SteeringTorque(),
}


def codegen(
    *,
    rig: Path,
    observer: GeneratedObserver,
    out: Path,
    model: Path | None,
    effects: Sequence[str] | None,
    tuning: TuningName | None,
    ground: str | None,
    real: RealType,
    target: Target,
    torque: TorqueChannel,
    name: str,
) -> None:
    """Write an observer as C or as an FMU.

    Its arguments are those of the command; see `brushgrip codegen --help`.
    """
    own = user_effects(effects)
    chosen = from_files(
        KINDS[observer],
        rig,
        model,
        effects=own,
        ground=ground,
        measurement_model=MEASUREMENT_MODELS[torque],
        tuning=None if tuning is None else profile(tuning),
    )
    with staged_directory(out) as stage:
        if target is Target.FMU:
            files = [generate_fmu(chosen, stage, TYPES[real], name=name)]
        else:
            files = generate(chosen, stage, TYPES[real], name=name)
            _say_origin(files, comment(rig, model))
        finals = [out.resolve() / path.name for path in files]
        keep_inputs(finals, [], rig, model, *effect_files(effects))
        require_replaceable(finals)
    if model is not None and (taken := read_model(model, effects=own).ground_taken(ground)):
        say(taken)
    show({"wrote": list(map(str, finals))})
    say(f"wrote {', '.join(path.name for path in files)} to {out}")


def _say_origin(files: Sequence[Path], text: str) -> None:
    """Say at the end of code what it was made from."""
    for path in files:
        if path.suffix in (".c", ".h"):
            with path.open("a", encoding="utf-8", newline="\n") as file:
                file.write(text)
