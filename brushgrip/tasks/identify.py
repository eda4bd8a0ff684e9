"""`brushgrip identify`."""

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

from brushgrip.atomic import is_same_file, staged_file
from brushgrip.console import print_free_decay, say, show
from brushgrip.formatting import free_decay_document, json_text, listed
from brushgrip.pictures import draw_free_decay
from brushgrip.provenance import KEY, provenance_of
from brushgrip.recordings import files_read, keep_inputs, read_decays, signal_map
from identification import Decay, FreeDecay, identify_free_decay, read_rig
from identification.reading.rigfile import rig_text
from identification.reading.signal_map import signals_text
from identification.thesis import estimate_by_decrement
from symbolic import BrushgripError, InvalidInputError, Rig, Tyre


def identify(
    *,
    free_decay: Sequence[str],
    out: Path,
    rig: Path | None,
    channel_map: str | None,
    write_rig: Path | None,
) -> None:
    """Write k and b_t from free vibrations, and a picture of the fit.

    Its arguments are those of the command; see `brushgrip identify --help`.
    """
    image = out.with_suffix(".png")
    if image == out:
        raise InvalidInputError(f"{out}: the result needs a name such as .json; .png is its picture")
    decays = read_decays(free_decay, rig, channel_map)
    finals = [out, image, *([write_rig] if write_rig else [])]
    if write_rig and any(is_same_file(write_rig, other) for other in (out, image)):
        raise InvalidInputError(f"{write_rig}: --write-rig and --out must name different files")
    signals = signal_map(rig, channel_map)
    files = files_read(free_decay, signals)
    keep_inputs(finals, files, rig)
    made = provenance_of(files, rig, signals=signals.to_dict())
    declared = _declared(decays, rig) if write_rig else None
    with ExitStack() as stack:
        table, drawing, *rest = (stack.enter_context(staged_file(final)) for final in finals)
        result = identify_free_decay(decays)
        if not result.converged:
            raise BrushgripError(f"k and b_t were {result.status}: {result.remedy}")
        decrement = estimate_by_decrement(decays)
        document = free_decay_document(result, decrement) | {KEY: made}
        table.write_text(json_text(document), encoding="utf-8", newline="\n")
        draw_free_decay(drawing, result, decrement)
        if declared is not None:
            of_rig = signal_map(rig, None)
            text = "\n".join(
                filter(None, (rig_text(*_identified(*declared, result)), signals_text(of_rig)))
            )
            rest[0].write_text(text, encoding="utf-8", newline="\n")
    print_free_decay(result, decrement)
    say(f"wrote {listed(list(map(str, finals)))}")
    show(document)


def _declared(decays: Sequence[Decay], rig: Path | None) -> tuple[Rig, Tyre]:
    """Rig and tyre to write k and b_t into: the rig file's, else those that all recordings declare.

    Raises:
        InvalidInputError: there is no rig file, and recordings differ.
    """
    if rig is not None:
        return read_rig(rig)
    first = decays[0]
    if any((decay.rig, decay.tyre) != (first.rig, first.tyre) for decay in decays):
        raise InvalidInputError(
            "--write-rig: the recordings declare different rigs; name the one to complete with --rig"
        )
    return first.rig, first.tyre


def _identified(rig: Rig, tyre: Tyre, result: FreeDecay) -> tuple[Rig, Tyre]:
    return replace(rig, b_t=result.b_t.value), replace(tyre, k=result.k.value)
