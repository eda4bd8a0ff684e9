"""`brushgrip simulate`."""

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from brushgrip.atomic import staged_file
from brushgrip.commands.options import ModelFile, OutFile, RecordingNames, RigFile
from brushgrip.console import say
from brushgrip.recordings import keep_inputs, read_all
from brushgrip.tables import csv_text
from identification.fits.fitting import signals_of
from identification.modelfile import FoundModel, read_model
from identification.reading.recordings import Recording
from symbolic import InvalidInputError, Model
from symbolic import simulate as torque_of


def simulate(
    recordings: RecordingNames, out: OutFile, rig: RigFile = None, model: ModelFile = None
) -> None:
    """Simulate the aligning torque for the angle and the load of recordings: t,M_z.

    No M_z is needed. mu comes from the model file where it knows the recording, else from the rig.
    Several recordings go to OUT_<recording>.csv.
    """
    read = read_all(recordings, rig, torque_required=False)
    found = None if model is None else read_model(model)
    inputs = [parameters_for(recording, found) for recording in read]
    finals = [_final(out, recording, read) for recording in read]
    keep_inputs(finals, recordings, rig, model)
    with ExitStack() as stack:
        stages = [stack.enter_context(staged_file(final)) for final in finals]
        for recording, (structure, values), stage in zip(read, inputs, stages, strict=True):
            theta = np.asarray(structure.theta(values)).ravel()
            geometry = np.array([recording.rig.a, recording.rig.e])
            made = torque_of(structure, signals_of(recording), theta, geometry)
            text = csv_text({"t": recording.t, "M_z": made.M_z})
            stage.write_text(text, encoding="utf-8", newline="\n")
    for final in finals:
        say(f"wrote {final}")


def parameters_for(recording: Recording, found: FoundModel | None) -> tuple[Model, dict[str, float]]:
    """The model to use for a recording, declared or found, and all of its parameter values.

    Raises:
        InvalidInputError: mu is known from nowhere.
    """
    mu = recording.tyre.mu
    if found is not None:
        return found.model, found.values_for(recording.name, mu)
    if mu is None:
        raise InvalidInputError(
            f"{recording.name}: mu is not known; give it under [tyre] of the rig file, "
            "as '# mu = 1.2' before a CSV header, or name a model file (--model)"
        )
    return Model(), {"mu": mu, "k": recording.tyre.k}


def _final(out: Path, recording: Recording, everything: Sequence[Recording]) -> Path:
    return out if len(everything) == 1 else out.with_stem(f"{out.stem}_{recording.name}")
