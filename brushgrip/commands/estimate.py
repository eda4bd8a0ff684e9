"""`brushgrip estimate`."""

from typing import Annotated

import typer

from brushgrip.atomic import staged_file
from brushgrip.commands.options import ModelFile, OutFile, RigFile
from brushgrip.console import say
from brushgrip.observing import ObserverName, observe, track
from brushgrip.pictures import draw_friction
from brushgrip.recordings import keep_inputs, read_all
from brushgrip.tables import csv_text
from identification.modelfile import read_model
from symbolic.errors import InvalidInputError


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
) -> None:
    """Estimate friction over time, causally: t,mu,mu_std,M_z_predicted,informed.

    One row a sample, informed as 0 or 1; a picture of mu(t) goes beside OUT.csv as OUT.png.
    """
    if out.suffix.lower() == ".png":
        raise InvalidInputError(f"{out}: the table needs a name such as .csv; .png is its picture")
    (read,) = read_all([recording], rig, causal=True)
    keep_inputs([out, out.with_suffix(".png")], [recording], rig, model)
    found = None if model is None else read_model(model)
    picture = out.with_suffix(".png")
    with staged_file(out) as table, staged_file(picture) as image:
        made = observe(observer, read, found)
        columns = {
            "t": made.t,
            "mu": made.mu,
            "mu_std": made.mu_std,
            "M_z_predicted": made.M_z_predicted,
            "informed": made.informed,
        }
        table.write_text(csv_text(columns), encoding="utf-8", newline="\n")
        label = "declared model" if found is None else "model found"
        draw_friction(image, [track(observer, read, made, label)])
    say(f"wrote {out} and {picture}")
