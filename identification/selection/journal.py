"""Trials kept on disk, so that an interrupted search goes on from them.

A search is deterministic: a trial that it has run before is taken from here. A trial is one file, named
by a digest of the model's Functions, the start, the precision, the recordings and the format, and begins
with one of its content. A file that was damaged or altered, or holds anything but such a trial, counts
as absent. joblib.Memory and diskcache would unpickle what they read, which executes code that a file may
hold; here only JSON and arrays without objects are read.
"""

import hashlib
import io
import json
import logging
import secrets
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from identification.fits.fitting import Fit
from identification.fits.values import Values, grounds_of, initial_guess
from identification.reading.recordings import Recording
from identification.selection.trials import Trial, TrialTask, model_of, trial_of
from symbolic import TOLERATED, parameter_name

FORMAT = 4
"""Changes with whatever makes a kept trial differ from one run anew."""
ARRAYS = ("jacobian", "scales", "bound_distances", "prior_weights", "prior_steps")
"""What of a fit is an array, beside its residuals."""
DIGEST = hashlib.sha256().digest_size
"""Bytes in the beginning of a file that say whether the others are as they were written."""
_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, kw_only=True)
class Journal:
    """A folder of trials.

    Attributes:
        folder: where they are kept; created with the first.
    """

    folder: Path

    def recall(self, task: TrialTask) -> Trial | None:
        """The trial of this task, None if it is not kept whole."""
        path = self._path(task)
        places = [task.training, *([task.holdout] if task.holdout else [])]
        try:
            content = path.read_bytes()
            if content[:DIGEST] != _seal(path, content[DIGEST:]):
                return None
            with np.load(io.BytesIO(content[DIGEST:]), allow_pickle=False) as kept:
                arrays = {name: kept[name] for name in kept.files}
            texts = json.loads(str(arrays.pop("texts")))
            fits = [_fit(task, text, arrays, i) for i, text in enumerate(texts)]
            if not all(_is_whole(*pair) for pair in zip(fits, places, strict=True)):
                return None
            return trial_of(task, fits[0], fits[1] if task.holdout else None)
        except Exception:  # a damaged file may raise anything
            return None

    def note(self, task: TrialTask, trial: Trial) -> None:
        """Keep the trial of this task, whole or not at all; where nothing can be written, not at all."""
        fits = [trial.fitted, *([trial.held_out] if trial.held_out else [])]
        arrays: dict[str, Any] = {"texts": json.dumps([_text(fitted) for fitted in fits])}
        for i, fitted in enumerate(fits):
            arrays |= {f"{i}/residual/{name}": r for name, r in fitted.residuals.items()}
            arrays |= {f"{i}/{name}": getattr(fitted, name) for name in ARRAYS}
        path = self._path(task)
        content = io.BytesIO()
        np.savez(content, **arrays)
        stage = path.with_name(f"{secrets.token_hex(4)}.part")
        try:
            self.folder.mkdir(exist_ok=True)
            stage.write_bytes(_seal(path, content.getvalue()) + content.getvalue())
            stage.replace(path)
        except OSError as error:
            with suppress(OSError):
                stage.unlink()
            _say_once(f"{self.folder}: what is found cannot be kept: {error.strerror or error}")

    def _path(self, task: TrialTask) -> Path:
        start = asdict(task.start) if task.start else None
        model = model_of(task.effects, task.precision)
        # What the effects do belongs to the key, and with other bounds a trial comes out otherwise.
        plain = [FORMAT, repr(model.parameters), start, asdict(task.precision), repr(task.loss)]
        # The first guess holds the declared tyre and what `Effect.fixed_values` makes of recordings.
        plain += [repr(initial_guess(model, place)) for place in (task.training, task.holdout) if place]
        digest = hashlib.sha256(json.dumps(plain, sort_keys=True).encode())
        for function in (model.initial, model.step):
            digest.update(function.serialize().encode())
        for place in (task.training, task.holdout):
            digest.update(b"|")
            for recording in place:
                digest.update(_digest(recording))
        return self.folder / f"{digest.hexdigest()[:32]}.npz"


def _seal(path: Path, content: bytes) -> bytes:
    """Digest of a trial and of the task that it is of."""
    return hashlib.sha256(path.stem.encode() + content).digest()


@cache
def _say_once(line: str) -> None:
    _LOG.warning("brushgrip: %s", line)


def _digest(recording: Recording) -> bytes:
    digest = hashlib.sha256(repr((recording.name, recording.rig, recording.ground)).encode())
    for values in (recording.t, recording.psi, recording.psi_dot, recording.M_z, recording.F_N):
        digest.update(values.tobytes())
    return digest.digest()


def _text(fitted: Fit) -> dict[str, Any]:
    """What of a fit is not an array."""
    return {
        "values": asdict(fitted.values),
        "labels": fitted.labels,
        "status": fitted.status,
        "converged": fitted.converged,
    }


def _fit(task: TrialTask, text: Mapping[str, Any], arrays: Mapping[str, Any], i: int) -> Fit:
    prefix = f"{i}/residual/"
    labels: Sequence[Sequence[Any]] = text["labels"]
    return Fit(
        model=model_of(task.effects, task.precision),
        values=Values(**text["values"]),
        residuals={n.removeprefix(prefix): r for n, r in arrays.items() if n.startswith(prefix)},
        labels=tuple((owner, name) for owner, name in labels),
        status=text["status"],
        converged=text["converged"],
        loss=task.loss,
        **{name: arrays[f"{i}/{name}"] for name in ARRAYS},
    )


def _is_whole(fitted: Fit, recordings: Sequence[Recording]) -> bool:
    """Whether a fit that was read has all that a fit to these recordings has, of the right types.

    Raises:
        Exception: of any kind, where it has not.
    """
    names = {parameter_name(effect, parameter) for effect, parameter in fitted.model.parameters}
    present = {r.name: np.isfinite(r.M_z) for r in recordings}
    rows, columns = sum(int(mask.sum()) for mask in present.values()), len(fitted.labels)
    shapes = dict.fromkeys(ARRAYS, (columns,)) | {
        "jacobian": (rows, columns),
        "bound_distances": (2, columns),
    }
    arrays = {name: getattr(fitted, name) for name in shapes}
    for recording in recordings:
        # Raises where a value is missing or out of bounds.
        fitted.model.theta(fitted.values.of(recording))
    owners = {None, *present, *grounds_of(recordings)}
    names |= set(TOLERATED)
    for label in fitted.labels:
        if not isinstance(fitted.values.at(label), float):
            return False
    return (
        type(fitted.status) is str
        and type(fitted.converged) is bool
        and all(owner in owners and name in names for owner, name in fitted.labels)
        and len(set(fitted.labels)) == columns > 0
        and fitted.residuals.keys() == present.keys()
        and all(np.array_equal(np.isfinite(fitted.residuals[n]), mask) for n, mask in present.items())
        and all(array.shape == shapes[name] for name, array in arrays.items())
        and all(array.dtype == float for array in (*arrays.values(), *fitted.residuals.values()))
        and all(np.isfinite(array).all() for array in (fitted.jacobian, fitted.scales))
    )
