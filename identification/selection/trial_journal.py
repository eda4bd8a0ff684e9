"""Trials kept on disk, so that an interrupted search goes on from them.

A search is deterministic: a trial that it has run before is taken from here. A trial is one file, named
by a digest of the model's Functions, the start, the precision, the recordings and the format. The file
begins with a digest of its content; one that was damaged or altered counts as absent. joblib.Memory and
diskcache would unpickle what they read, which executes code that a file may hold; here only JSON and
arrays without objects are read.
"""

import hashlib
import io
import json
import logging
import secrets
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from identification.fits.fitting import Fit
from identification.fits.values_by_ground_and_recording import Values, initial_guess
from identification.reading.recordings import Recording
from identification.selection.trial import Trial, TrialTask, model_of, trial_of
from symbolic import Model

FORMAT = 5
"""Changes with whatever makes a kept trial differ from one run anew."""
ARRAYS = ("jacobian", "scales", "bound_distances", "prior_weights", "prior_steps")
TEXTS = ("labels", "status", "converged")
"""What of a fit is an array, and what is none, beside its residuals and its values."""
DIGEST = hashlib.sha256().digest_size
"""Bytes in the beginning of a file that say whether the others are as they were written."""
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Journal:
    """A folder of trials, created with the first."""

    folder: Path

    def recall(self, task: TrialTask) -> Trial | None:
        """The trial of this task, None if it is not kept whole."""
        path = self._path(task)
        try:
            content = path.read_bytes()
            if content[:DIGEST] != _trial_digest(path, content[DIGEST:]):
                return None
            with np.load(io.BytesIO(content[DIGEST:]), allow_pickle=False) as kept:
                arrays = {name: kept[name] for name in kept.files}
            texts = json.loads(str(arrays.pop("texts")))
            fitted, *held_out = [_restore_fit(task, text, arrays, i) for i, text in enumerate(texts)]
            return trial_of(task, fitted, held_out[0] if task.holdout else None)
        except Exception:  # a damaged file may raise anything
            return None

    def note(self, task: TrialTask, trial: Trial) -> None:
        """Keep the trial of this task, whole or not at all; where nothing can be written, not at all."""
        texts = [
            {"values": asdict(fitted.values), **{name: getattr(fitted, name) for name in TEXTS}}
            for fitted in trial.fits
        ]
        arrays: dict[str, Any] = {"texts": json.dumps(texts)}
        for i, fitted in enumerate(trial.fits):
            arrays |= {f"{i}/residual/{name}": r for name, r in fitted.residuals.items()}
            arrays |= {f"{i}/{name}": getattr(fitted, name) for name in ARRAYS}
        path = self._path(task)
        content = io.BytesIO()
        np.savez(content, **arrays)
        stage = path.with_name(f"{secrets.token_hex(4)}.part")
        try:
            self.folder.mkdir(exist_ok=True)
            stage.write_bytes(_trial_digest(path, content.getvalue()) + content.getvalue())
            stage.replace(path)
        except OSError as error:
            with suppress(OSError):
                stage.unlink()
            _warn_once(f"{self.folder}: what is found cannot be kept: {error.strerror or error}")

    def _path(self, task: TrialTask) -> Path:
        return self.folder / f"{_key(task)}.npz"


@lru_cache(maxsize=100)
def _key(task: TrialTask) -> str:
    """Digest of all that makes the trial of a task what it is; asked for before the trial and after."""
    start = asdict(task.start) if task.start else None
    model = model_of(task.effects, task.precision)
    # What the effects do belongs to the key, and with other bounds a trial comes out otherwise.
    plain = [FORMAT, repr(model.parameters), start, asdict(task.precision), repr(task.loss)]
    # The first guess holds the declared tyre and what `Effect.fixed_values` makes of recordings.
    plain += [repr(initial_guess(model, place)) for place in (task.training, task.holdout) if place]
    digest = hashlib.sha256(json.dumps(plain, sort_keys=True).encode())
    for effect in task.effects or (None,):
        alone = (effect,) if effect else ()
        digest.update(_serialised_model(model_of(alone, task.precision)))
    for place in (task.training, task.holdout):
        digest.update(b"|")
        for recording in place:
            digest.update(_digest(recording))
    return digest.hexdigest()[:32]


@cache
def _serialised_model(model: Model) -> bytes:
    """What a model does; for one effect a time, as its Functions take longer than all else of a key."""
    return b"".join(function.serialize().encode() for function in (model.initial, model.step))


def _trial_digest(path: Path, content: bytes) -> bytes:
    """Digest of a trial and of the task that it is of."""
    return hashlib.sha256(path.stem.encode() + content).digest()


@cache
def _warn_once(line: str) -> None:
    _LOG.warning("brushgrip: %s", line)


def _digest(recording: Recording) -> bytes:
    digest = hashlib.sha256(repr((recording.name, recording.rig, recording.ground)).encode())
    for values in (recording.t, recording.psi, recording.psi_dot, recording.M_z, recording.F_N):
        digest.update(values.tobytes())
    return digest.digest()


def _restore_fit(task: TrialTask, text: Mapping[str, Any], arrays: Mapping[str, Any], i: int) -> Fit:
    prefix = f"{i}/residual/"
    return Fit(
        model=model_of(task.effects, task.precision),
        values=Values(**text["values"]),
        residuals={n.removeprefix(prefix): r for n, r in arrays.items() if n.startswith(prefix)},
        labels=tuple((owner, name) for owner, name in text["labels"]),
        status=text["status"],
        converged=text["converged"],
        loss=task.loss,
        **{name: arrays[f"{i}/{name}"] for name in ARRAYS},
    )
