"""`brushgrip estimate`."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.atomic import staged_file
from brushgrip.commands.options import (
    ChannelMap,
    EffectModules,
    ModelFile,
    OneGround,
    OutFile,
    RecordingName,
    RigFile,
    TuningProfile,
    check_picture_name,
    usable_file,
)
from brushgrip.console import say
from brushgrip.estimation import (
    ObserverName,
    friction_track,
    has_aligning_torque,
    has_steering_torque,
    observe,
    observer_factory,
    require_plausible,
)
from brushgrip.formatting import csv_text, estimates_summary
from brushgrip.grounds import on_grounds, say_ground
from brushgrip.pictures import draw_friction
from brushgrip.recordings import keep_inputs, read_all
from brushgrip.user_effects import effect_files, user_effects
from identification import Recording, read_model
from observers import ESTIMATE, Estimates
from symbolic import InvalidInputError


def estimate(
    recording: RecordingName,
    observer: Annotated[
        ObserverName, typer.Option("--observer", help="Observer to use.", show_default=False)
    ],
    out: OutFile,
    rig: RigFile = None,
    model: ModelFile = None,
    effects: EffectModules = None,
    tuning: TuningProfile = None,
    ground: OneGround = None,
    channel_map: ChannelMap = None,
    smooth: Annotated[
        bool,
        typer.Option("--smooth", help="Estimate every sample from the whole recording; takes ekf."),
    ] = False,
    picture: Annotated[
        Path | None,
        typer.Option(
            "--picture",
            metavar="PNG",
            help="Picture of mu(t); OUT.png if left out.",
            show_default=False,
            callback=usable_file,
        ),
    ] = None,
) -> None:
    """Estimate friction over time, causally, one row a sample.

    Columns t,mu,mu_std,M_z_predicted,informed,mu_eff,mu_eff_std,M_slide,nis,status. The effective
    friction mu_eff compares between models: the torque M_slide [N m] of a steady full slide over that of
    the declared patch with mu = 1; nis is the square of measured minus predicted over its variance.

    From the aligning torque M_z, or, where the recording has none, from the steering torque M; that
    takes J_A and b_t of the rig. informed is 0 or 1, status a number; deviations and nis are empty with
    root, the method of [Györök 2022], which has none. A picture of mu_eff(t) goes beside OUT.csv.
    With --smooth an estimate knows later samples too, for those who work offline.
    """
    image = out.with_suffix(".png") if picture is None else picture
    _check_names(out, image)
    own = user_effects(effects)
    (read,) = on_grounds([_read(recording, rig, channel_map)], ground, bare=True)
    require_plausible(read)
    keep_inputs([out, image], [recording], rig, model, *effect_files(effects))
    found = None if model is None else read_model(model, effects=own)
    with staged_file(out) as table, staged_file(image) as drawing:
        estimates = observe(observer_factory(observer, tuning), read, found, smoothed=smooth)
        table.write_text(_table(estimates), encoding="utf-8", newline="\n")
        label = ("declared model" if found is None else "model found") + ", smoothed" * smooth
        draw_friction(drawing, [friction_track(observer, read, estimates, label)])
    say_ground(read, found)
    say(f"{read.name}: {estimates_summary(estimates)}")
    say(f"wrote {out} and {image}")


def _check_names(out: Path, image: Path) -> None:
    if out.suffix.lower() == ".png":
        raise InvalidInputError(f"{out}: the table needs a name such as .csv; .png is its picture")
    check_picture_name(image)


def _read(name: str, rig: Path | None, given_map: str | None) -> Recording:
    """The recording with its aligning or steering torque; without both, the message asks for M_z."""
    (read,) = read_all([name], rig, torque_required=False, causal=True, given_map=given_map)
    if not (has_aligning_torque(read) or has_steering_torque(read)):
        (read,) = read_all([name], rig, causal=True, given_map=given_map)
    return read


def _table(estimates: Estimates) -> str:
    return csv_text({name: getattr(estimates, name) for name in ("t", *ESTIMATE)})
