"""`brushgrip simulate`."""

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from brushgrip.atomic import staged_file
from brushgrip.console import say, show
from brushgrip.formatting import csv_text, json_text
from brushgrip.grounds import on_grounds, say_ground
from brushgrip.provenance import beside, provenance_of
from brushgrip.recordings import files_read, keep_inputs, read_all, signal_map
from brushgrip.user_effects import effect_files, user_effects
from identification import FoundModel, Recording, Values, read_model, replaced_rig, signals_of
from symbolic import InvalidInputError, Model
from symbolic import simulate as simulate_torque


def simulate(
    *,
    recordings: Sequence[str],
    out: Path,
    rig: Path | None,
    channel_map: str | None,
    model: Path | None,
    effects: Sequence[str] | None,
    ground: Sequence[str] | None,
    mu: float | None,
) -> None:
    """Write the torque that the model predicts for recordings.

    Its arguments are those of the command; see `brushgrip simulate --help`.
    """
    if mu is not None and not 0 < mu < float("inf"):
        raise InvalidInputError(f"--mu must be finite and greater than 0, got {mu:g}")
    own = user_effects(effects)
    read = read_all(recordings, rig, torque_required=False, given_map=channel_map)
    read = on_grounds(read, ground, bare=True)
    found = None if model is None else read_model(model, effects=own)
    inputs = [model_and_values(recording, found, mu) for recording in read]
    finals = [_final(out, recording, read) for recording in read]
    told = beside(out)
    signals = signal_map(rig, channel_map)
    files = files_read(recordings, signals, effect_files(effects))
    keep_inputs([*finals, told], files, rig, model)
    made = provenance_of(files, rig, model, signals.to_dict(), mu=mu, ground=list(ground or ()))
    with ExitStack() as stack:
        stages = [stack.enter_context(staged_file(final)) for final in finals]
        origin = stack.enter_context(staged_file(told))
        origin.write_text(json_text(made), encoding="utf-8", newline="\n")
        for recording, (structure, values), stage in zip(read, inputs, stages, strict=True):
            theta = np.asarray(structure.theta(values)).ravel()
            rig_found = {} if found is None else found.rig
            actual = replaced_rig(recording, Values(tyre={}, own={}, rig=rig_found))
            geometry = np.array([actual.rig.a, actual.rig.e])
            torque = simulate_torque(structure, signals_of(actual), theta, geometry)
            zero = rig_found.get(recording.name, {}).get("zero", 0.0)
            text = csv_text({"t": recording.t, "M_z": torque.M_z + zero})
            stage.write_text(text, encoding="utf-8", newline="\n")
    for recording in read:
        say_ground(recording, found)
    for final in finals:
        say(f"wrote {final}")
    show({"wrote": list(map(str, finals))})


def model_and_values(
    recording: Recording, found: FoundModel | None, given: float | None = None
) -> tuple[Model, dict[str, float]]:
    """The model for a recording, declared or found, and the values of all its parameters.

    Raises:
        InvalidInputError: mu is unknown.
    """
    mu = recording.tyre.mu if given is None else given
    if found is not None:
        values = found.values_for(recording.name, mu, recording.ground)
        return found.model, values if given is None else values | {"mu": given}
    if mu is None:
        raise InvalidInputError(
            f"{recording.name}: mu is not known; give it with --mu, under [tyre] of the rig file, "
            "as '# mu = 1.2' before a CSV header, or name a model file (--model)"
        )
    return Model(), {"mu": mu, "k": recording.tyre.k}


def _final(out: Path, recording: Recording, everything: Sequence[Recording]) -> Path:
    return out if len(everything) == 1 else out.with_stem(f"{out.stem}_{recording.name}")
