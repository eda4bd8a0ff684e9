"""`brushgrip identify`."""

from collections.abc import Sequence
from pathlib import Path

from brushgrip.atomic import staged_file
from brushgrip.console import print_free_decay, say
from brushgrip.formatting import free_decay_document, json_text
from brushgrip.pictures import draw_free_decay
from brushgrip.recordings import keep_inputs, read_decays
from identification import identify_free_decay
from identification.thesis import estimate_by_decrement
from symbolic import BrushgripError, InvalidInputError


def identify(
    *,
    free_decay: Sequence[str],
    out: Path,
    rig: Path | None,
) -> None:
    """Write k and b_t from free vibrations, and a picture of the fit.

    Its arguments are those of the command; see `brushgrip identify --help`.
    """
    image = out.with_suffix(".png")
    if image == out:
        raise InvalidInputError(f"{out}: the result needs a name such as .json; .png is its picture")
    decays = read_decays(free_decay, rig)
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
