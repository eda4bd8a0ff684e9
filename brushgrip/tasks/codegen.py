"""`brushgrip codegen`."""

import re
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from brushgrip.atomic import staged_directory
from brushgrip.choices import GeneratedObserver, RealType, RunTime, Target, TorqueChannel, TuningName
from brushgrip.console import say, show
from brushgrip.provenance import comment, other_rig
from brushgrip.recordings import keep_inputs
from brushgrip.tunings import chosen_tuning
from brushgrip.user_effects import effect_files, user_effects
from identification import read_model
from observers import (
    AligningTorque,
    Ekf,
    FunctionObserver,
    MeasurementModel,
    Mhe,
    SteeringTorque,
    Tuning,
    from_files,
)
from observers.embedded import (
    DOUBLE,
    SINGLE,
    Real,
    Tunable,
    generate,
    generate_fmu,
    generate_ros2,
    require_replaceable,
)
from observers.embedded.cost import estimated_cost
from observers.interfaces.factory import read_rig_file
from symbolic import InvalidInputError

KINDS = {GeneratedObserver.EKF: Ekf, GeneratedObserver.MHE: Mhe}
TYPES = {RealType.FLOAT: SINGLE, RealType.DOUBLE: DOUBLE}
MEASUREMENT_MODELS: dict[TorqueChannel, MeasurementModel] = {
    TorqueChannel.GROUND: AligningTorque(),
    TorqueChannel.HAND: SteeringTorque(),
}
FMI = {Target.FMU: 2, Target.FMU3: 3}
"""Versions."""
LONGEST_WINDOW = 1000
"""Samples; ten seconds at 100 Hz."""


def codegen(
    *,
    rig: Path,
    observer: GeneratedObserver,
    out: Path,
    model: Path | None,
    effects: Sequence[str] | None,
    tuning: TuningName | None,
    tune: Sequence[str] | None,
    window: int | None,
    ground: str | None,
    real: RealType,
    target: Target,
    torque: TorqueChannel,
    tunable: RunTime | None,
    name: str,
) -> None:
    """Write an observer as C, as an FMU or as a package of ROS 2.

    Its arguments are those of the command; see `brushgrip codegen --help`.
    """
    own = user_effects(effects)
    settings, tuned = _window(observer, window), chosen_tuning(tuning, tune)
    chosen = from_files(
        KINDS[observer],
        rig,
        model,
        effects=own,
        ground=ground,
        measurement_model=MEASUREMENT_MODELS[torque],
        tuning=tuned and tuned.profile,
        by_hand=tuned and tuned.by_hand,
        **settings,
    )
    found = None if model is None else read_model(model, effects=own)
    if ground is not None and not (found and found.grounds):
        raise InvalidInputError(f"--ground {ground}: this model knows no grounds; leave it out")
    at_run_time: Tunable = tunable.value if tunable else ""
    cost = estimated_cost(chosen, TYPES[real], at_run_time)
    size: int | None = None
    with staged_directory(out) as stage:
        files = _written(chosen, target, stage, TYPES[real], name, at_run_time)
        if target not in FMI:
            _say_origin(files, comment(rig, model))
            size = _state_bytes(stage / f"{name}.h")
        finals = [out.resolve() / path.name for path in files]
        keep_inputs(finals, [], rig, model, *effect_files(effects))
        require_replaceable(finals)
        say(f"{f'{size:,} bytes a wheel, ' if size else ''}{cost}")
        say(_prior(chosen.tuning, rig))
    _remove_stale(out / f"{name}.a2l", finals)
    if found is not None:
        for line in (found.ground_taken(ground), other_rig(chosen.rig, model)):
            if line:
                say(line)
    show({"wrote": list(map(str, finals)), "cost": {"state_bytes": size, **asdict(cost)}})
    say(f"wrote {', '.join(path.name for path in files)} to {out}")


def _written(
    observer: FunctionObserver, target: Target, folder: Path, real: Real, name: str, tunable: Tunable
) -> list[Path]:
    """Write the files of a target."""
    if target in FMI:
        return [generate_fmu(observer, folder, real, name=name, version=FMI[target], tunable=tunable)]
    if target is Target.C:
        return generate(observer, folder, real, name=name, tunable=tunable)
    if tunable:
        raise InvalidInputError(
            "--tunable is for the targets c, fmu and fmu3; the node of ROS 2 has constants, got ros2"
        )
    return generate_ros2(observer, folder, real, name=name)


def _window(observer: GeneratedObserver, window: int | None) -> dict[str, int]:
    """The settings that `--window` makes."""
    if window is None:
        return {}
    if observer is not GeneratedObserver.MHE:
        raise InvalidInputError(
            f"--window is that of the MHE; allowed with --observer mhe, got {window}"
        )
    if not 1 <= window <= LONGEST_WINDOW:
        raise InvalidInputError(f"--window must be from 1 to {LONGEST_WINDOW} samples, got {window}")
    return {"window": window}


def _state_bytes(header: Path) -> int | None:
    """The size of a state that a header tells."""
    seen = re.search(r"One observer, (\d+) bytes", header.read_text(encoding="utf-8"))
    return int(seen[1]) if seen else None


def _prior(tuning: Tuning, rig: Path) -> str:
    """The prior, and that the rig file's friction is not it."""
    declared = read_rig_file(rig)[1].mu
    text = f"prior mu {tuning.mu:g} with standard deviation {tuning.mu_std:g}"
    if declared is None or declared == tuning.mu:
        return text
    return f"{text}; the rig file's mu = {declared:g} is not used, --tune mu={declared:g} would be"


def _remove_stale(description: Path, written: Sequence[Path]) -> None:
    """Remove the description of parameters of an earlier generation, which this one has not."""
    if description.is_file() and description.resolve() not in written:
        require_replaceable([description])
        description.unlink()
        say(f"removed {description.name} of an earlier generation")


def _say_origin(files: Sequence[Path], text: str) -> None:
    """Say at the end of code what it was made from."""
    for path in files:
        if path.suffix in (".c", ".h", ".hpp", ".cpp"):
            with path.open("a", encoding="utf-8", newline="\n") as file:
                file.write(text)
