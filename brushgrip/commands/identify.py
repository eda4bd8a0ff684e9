"""`brushgrip identify`."""

from pathlib import Path
from typing import Annotated

import typer

from brushgrip.atomic import staged_file
from brushgrip.commands.options import RigFile
from brushgrip.console import say
from brushgrip.identified import identified_document, print_identified
from brushgrip.pictures import draw_free_decay
from brushgrip.recordings import keep_inputs, read_decays
from brushgrip.tables import json_text
from identification.free_decay.estimator import identify_free_decay
from identification.thesis.fft_decrement import estimate_by_decrement
from symbolic.errors import BrushgripError, InvalidInputError


def identify(
    free_decay: Annotated[
        list[str],
        typer.Option(
            "--free-decay",
            metavar="REC...",
            help="Recordings of the wheel swinging freely after an impact: one or more after the flag.",
            show_default=False,
        ),
    ],
    out: Annotated[
        Path, typer.Option("--out", metavar="ID.json", help="File to write.", show_default=False)
    ],
    rig: RigFile = None,
) -> None:
    """Identify k and b_t from free vibrations, with standard deviations.

    A recording needs t and psi alone; lines such as '# a = 0.045' before the header give what is its
    own. a, e and J_A have to be known. A picture of the fit goes beside ID.json.
    """
    image = out.with_suffix(".png")
    if image == out:
        raise InvalidInputError(f"{out}: the result needs a name such as .json; .png is its picture")
    decays = read_decays(free_decay, rig)
    keep_inputs([out, image], free_decay, rig)
    with staged_file(out) as table, staged_file(image) as drawing:
        made = identify_free_decay(decays)
        if not made.converged:
            raise BrushgripError(f"k and b_t were {made.status}: {made.remedy}")
        decrement = estimate_by_decrement(decays)
        text = json_text(identified_document(made, decrement))
        table.write_text(text, encoding="utf-8", newline="\n")
        draw_free_decay(drawing, made, decrement)
    print_identified(made, decrement)
    say(f"wrote {out} and {image}")
