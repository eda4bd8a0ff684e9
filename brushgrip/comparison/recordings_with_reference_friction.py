"""A recording with the friction that its estimates are compared with."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from brushgrip.inputs.command_inputs import Inputs
from identification import Recording
from identification.thesis import (
    AuthorEstimate,
    author_estimate_file,
    begin_of_part,
    read_author_estimate,
)
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

SETTLED = 1.89
"""Time after the beginning of the turn from which [Györök 2022], Table 6.1, takes the error [s]."""
TURN_BEGINS = 0.02
"""Without a file of the author, the turn begins at this distance from the first angle [rad]; the
author's files begin at 0.024 to 0.060."""
FIRST_SLIDE = 0.9
"""The first slide is where the torque first exceeds this share of its greatest value [1]."""
SURFACES = {"fem": 1.674, "piros": 1.9003}
"""Friction from towing a block over the plates [1], by the first letters of the published recordings;
[Györök 2022], section 5.2.1."""
_ROUNDING = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """A recording with the friction that its estimates are compared with."""

    recording: Recording
    declared: float  # Friction coefficient that errors refer to [1]; a reference, not the truth.
    origin: str  # Of that coefficient.
    author: AuthorEstimate | None  # The author's estimate, if any.
    span: slice  # Samples from the beginning of the turn on, or those of the author's estimate.
    settled: NDArray[np.bool_]  # True where the error is taken.

    def rmse(self, mu: Array) -> float:
        """Root mean square of mu, shape (n,), minus the declared [1]; [Györök 2022], section 5.3.1."""
        return float(np.sqrt(np.mean((mu[self.settled] - self.declared) ** 2)))

    def std_after_first_slide(self, mu: Array) -> float:
        """Standard deviation of mu over time, after the first slide [1]."""
        torque = np.nan_to_num(np.abs(self.recording.M_z[self.span]))
        first_slide = int(np.argmax(torque > FIRST_SLIDE * torque.max()))
        return float(mu[self.span][first_slide:].std())

    @property
    def author_mu(self) -> Array | None:
        """The author's estimate at the samples of the recording, NaN where there is none [1]."""
        if self.author is None:
            return None
        mu = np.full(self.recording.t.size, np.nan)
        mu[self.span] = self.author.mu
        return mu


def make_case(recording: Recording, author_folder: Path | None, declared: float | None = None) -> Case:
    """A case for a recording, with the author's estimate where the folder has one."""
    file = None if author_folder is None else author_estimate_file(author_folder, recording.name)
    author = None if file is None or not file.exists() else read_author_estimate(file)
    if author is None:
        first, last = _first_turning_sample(recording), recording.t.size
    else:
        try:
            first = begin_of_part(recording.psi, author.psi)
        except InvalidInputError as error:
            raise InvalidInputError(f"{file}: {error} {recording.name}") from None
        last = first + author.psi.size
    time = recording.t - recording.t[first]
    settled = (time >= SETTLED - _ROUNDING) & (np.arange(time.size) < last)
    if not settled.any():
        raise InvalidInputError(
            f"{recording.name}: ends less than {SETTLED} s after the wheel began to turn, and the error"
            " is taken from then on; a longer recording is needed"
        )
    reference, origin = _reference_mu_and_source(recording, author, declared)
    return Case(
        recording=recording,
        declared=reference,
        origin=origin,
        author=author,
        span=slice(first, last),
        settled=settled,
    )


def make_cases(inputs: Inputs, author: Path | None, declared: Sequence[float]) -> list[Case]:
    """A case for each recording, with the author's estimate from one folder, or from beside each."""
    paths = inputs.paths.values()
    references = list(declared) if len(declared) == len(paths) else [*declared, None][:1] * len(paths)
    return [
        make_case(recording, path.parent if author is None else author, mu)
        for recording, path, mu in zip(inputs.recordings(causal=True), paths, references, strict=True)
    ]


def check_reference_frictions(declared: Sequence[float], recordings: int, author: Path | None) -> None:
    """Refuses reference frictions and a folder of estimates that cannot belong to so many recordings."""
    if len(declared) not in (0, 1, recordings):
        raise InvalidInputError(
            f"--declared has {len(declared)} values for {recordings} recordings;"
            " give one for all, or one for each"
        )
    for mu in declared:
        if not 0 < mu < float("inf"):
            raise InvalidInputError(f"--declared must be finite and greater than 0, got {mu:g}")
    if author is not None and not author.is_dir():
        raise InvalidInputError(
            f"{author}: no such folder; --author takes that of author_estimate_*.csv"
        )


def author_estimate_files(recordings: Iterable[Path], author: Path | None) -> list[Path]:
    """The estimates of [Györök 2022] that may be read along with these recordings."""
    folders = {path.parent for path in recordings} if author is None else {author}
    return [path for folder in folders for path in folder.glob(author_estimate_file(Path(), "*").name)]


def _first_turning_sample(recording: Recording) -> int:
    turning = np.abs(recording.psi - recording.psi[0]) >= TURN_BEGINS
    if not turning.any():
        raise InvalidInputError(
            f"{recording.name}: the wheel turns by less than {TURN_BEGINS} rad; nothing slides"
        )
    return int(np.argmax(turning))


def _reference_mu_and_source(
    recording: Recording, author: AuthorEstimate | None, given: float | None
) -> tuple[float, str]:
    if given is not None:
        return given, "--declared"
    if author is not None:
        return author.declared, "the author's file"
    for surface, mu in SURFACES.items():
        if recording.name.startswith(surface):
            return mu, "the surface"
    if recording.tyre.mu is not None:
        return recording.tyre.mu, "rig or recording"
    raise InvalidInputError(
        f"{recording.name}: no mu to take the error from; give --declared MU, or mu under [tyre] of the"
        " rig file, or '# mu = 1.2' before a CSV header"
    )
