"""`brushgrip identify`."""

from typing import Annotated

import typer

from brushgrip.atomic import staged_file
from brushgrip.commands.options import ChannelMap, OutJson, RigFile
from brushgrip.console import print_free_decay, say
from brushgrip.formatting import free_decay_document, json_text
from brushgrip.pictures import draw_free_decay
from brushgrip.recordings import keep_inputs, read_decays
from identification import identify_free_decay
from identification.thesis import estimate_by_decrement
from symbolic import BrushgripError, InvalidInputError


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
    out: OutJson,
    rig: RigFile = None,
    channel_map: ChannelMap = None,
) -> None:
    """Identify k and b_t from free vibrations, with standard deviations.

    A recording needs t and psi alone; lines such as '# a = 0.045' before the header override the rig
    for that recording. a, e and J_A are required. A picture of the fit goes beside ID.json.
    """
    image = out.with_suffix(".png")
    if image == out:
        raise InvalidInputError(f"{out}: the result needs a name such as .json; .png is its picture")
    decays = read_decays(free_decay, rig, channel_map)
    keep_inputs([out, image], free_decay, rig)
    with staged_file(out) as table, staged_file(image) as drawing:
        result = identify_free_decay(decays)
        if not result.converged:
            raise BrushgripError(f"k and b_t were {result.status}: {result.remedy}")
        decrement = estimate_by_decrement(decays)
        text = json_text(free_decay_document(result, decrement))
        table.write_text(text, encoding="utf-8", newline="\n")
        draw_free_decay(drawing, result, decrement)
    print_free_decay(result, decrement)
    say(f"wrote {out} and {image}")
