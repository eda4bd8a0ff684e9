"""A rig file with the k and b_t that free vibrations identify."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from identification import Decay, FreeDecay, SignalMap, read_rig, read_signals
from identification.reading.rigfile import rig_text
from identification.reading.signal_map import signals_text
from symbolic import InvalidInputError, Rig, Tyre


def declared_rig(decays: Sequence[Decay], rig: Path | None) -> tuple[Rig, Tyre]:
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


def identified_rig_text(rig: Rig, tyre: Tyre, file: Path | None, result: FreeDecay) -> str:
    """The rig file with k and b_t as identified, and the [signals] of the one that was given."""
    completed = rig_text(replace(rig, b_t=result.b_t.value), replace(tyre, k=result.k.value))
    signals = signals_text(SignalMap() if file is None else read_signals(file))
    return "\n".join(filter(None, (completed, signals)))
