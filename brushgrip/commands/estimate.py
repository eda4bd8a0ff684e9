"""`brushgrip estimate`."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.atomic import staged_file
from brushgrip.commands.options import ModelFile, OutFile, RigFile
from brushgrip.console import say
from brushgrip.estimation import ObserverName, hears_ground, hears_hand, observe, track
from brushgrip.pictures import draw_friction
from brushgrip.recordings import keep_inputs, read_all
from brushgrip.summary import summary
from brushgrip.tables import csv_text
from identification.modelfile import read_model
from identification.reading.recordings import Recording
from observers import Estimates
from symbolic import InvalidInputError


def estimate(
    recording: Annotated[
        str,
        typer.Argument(
            metavar="REC",
            help="Recording: a .csv or .mat file, or the name of a published one, such as fem1.",
            show_default=False,
        ),
    ],
    observer: Annotated[
        ObserverName, typer.Option("--observer", help="Observer to use.", show_default=False)
    ],
    out: OutFile,
    rig: RigFile = None,
    model: ModelFile = None,
    picture: Annotated[
        Path | None,
        typer.Option(
            "--picture", metavar="PNG", help="Picture of mu(t); OUT.png if left out.", show_default=False
        ),
    ] = None,
) -> None:
    """Estimate friction over time, causally: t,mu,mu_std,M_z_predicted,informed.

    From the aligning torque M_z, or, where the recording has none, from the steering torque M; that
    takes J_A and b_t of the rig. One row a sample, informed as 0 or 1; mu_std is empty with root, the
    source's own method, which has none. A picture of mu(t) goes beside OUT.csv.
    """
    image = out.with_suffix(".png") if picture is None else picture
    _check_names(out, image)
    read = _read(recording, rig)
    keep_inputs([out, image], [recording], rig, model)
    found = None if model is None else read_model(model)
    with staged_file(out) as table, staged_file(image) as drawing:
        made = observe(observer, read, found)
        table.write_text(_table(made), encoding="utf-8", newline="\n")
        label = "declared model" if found is None else "model found"
        draw_friction(drawing, [track(observer, read, made, label)])
    say(f"{read.name}: {summary(made)}")
    say(f"wrote {out} and {image}")


def _check_names(out: Path, image: Path) -> None:
    if out.suffix.lower() == ".png":
        raise InvalidInputError(f"{out}: the table needs a name such as .csv; .png is its picture")
    if image.suffix.lower() != ".png":
        raise InvalidInputError(f"{image}: the picture needs a name that ends in .png")


def _read(name: str, rig: Path | None) -> Recording:
    """The recording, which has one of the torques; without any, the fault is the aligning torque's."""
    (read,) = read_all([name], rig, torque_required=False, causal=True)
    if not (hears_ground(read) or hears_hand(read)):
        (read,) = read_all([name], rig, causal=True)
    return read


def _table(made: Estimates) -> str:
    names = ("t", "mu", "mu_std", "M_z_predicted", "informed")
    return csv_text({name: getattr(made, name) for name in names})
