"""`brushgrip estimate`."""

from collections.abc import Sequence
from pathlib import Path

from brushgrip.atomic import check_picture_name, staged_file
from brushgrip.choices import ObserverName, TuningName
from brushgrip.console import say
from brushgrip.estimation import (
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
    *,
    recording: str,
    observer: ObserverName,
    out: Path,
    rig: Path | None,
    model: Path | None,
    effects: Sequence[str] | None,
    tuning: TuningName | None,
    ground: Sequence[str] | None,
    smooth: bool,
    picture: Path | None,
) -> None:
    """Write friction over time, and a picture of it.

    Its arguments are those of the command; see `brushgrip estimate --help`.
    """
    image = out.with_suffix(".png") if picture is None else picture
    _check_names(out, image)
    own = user_effects(effects)
    (read,) = on_grounds([_read(recording, rig)], ground, bare=True)
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


def _read(name: str, rig: Path | None) -> Recording:
    """The recording with its aligning or steering torque; without both, the message asks for M_z."""
    (read,) = read_all([name], rig, torque_required=False, causal=True)
    if not (has_aligning_torque(read) or has_steering_torque(read)):
        (read,) = read_all([name], rig, causal=True)
    return read


def _table(estimates: Estimates) -> str:
    return csv_text({name: getattr(estimates, name) for name in ("t", *ESTIMATE)})
