"""A recording with what its estimates are held against."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification.reading.recordings import Recording
from identification.thesis.author_estimate import (
    AuthorEstimate,
    aligned,
    author_file,
    read_author_estimate,
)
from symbolic import InvalidInputError

Array = NDArray[np.float64]
SETTLED = 1.89
"""From so long after the wheel began to turn the source's Table 6.1 counts [s]."""
TURNED = 0.02
"""Without a file of the author the wheel has begun to turn when it is so far from its start [rad]; his
files begin at 0.024 to 0.060."""
SLIDES = 0.9
"""The wheel has slid once its torque has first reached this share of its greatest [1]."""
SURFACES = {"fem": 1.674, "piros": 1.9003}
"""Friction from towing a block over the plates, by how the names of published recordings begin [1],
source section 5.2.1."""
_ROUNDING = 1e-6


@dataclass(frozen=True, kw_only=True, eq=False)
class Subject:
    """What a recording's estimates are held against.

    Attributes:
        recording: what was measured.
        declared: friction coefficient to take the error from [1]; a reference, not the truth.
        origin: where that comes from.
        author: the author's estimate, None where there is none.
        span: the samples that count at all, the author's where he has some.
        settled: of the recording's samples, those in `span` that the error is taken over.
    """

    recording: Recording
    declared: float
    origin: str
    author: AuthorEstimate | None
    span: slice
    settled: NDArray[np.bool_]

    def rmse(self, mu: Array) -> float:
        """Root mean square of mu less the declared one, source section 5.3.1 [1].

        Args:
            mu: estimate at every sample of the recording, shape (n,) [1].
        """
        return float(np.sqrt(np.mean((mu[self.settled] - self.declared) ** 2)))

    def spread(self, mu: Array) -> float:
        """Standard deviation of mu over time, after the first slide [1]."""
        torque = np.nan_to_num(np.abs(self.recording.M_z[self.span]))
        slid = int(np.argmax(torque > SLIDES * torque.max()))
        return float(mu[self.span][slid:].std())

    @property
    def author_mu(self) -> Array | None:
        """The author's estimate at the samples of the recording, NaN where he has none [1]."""
        if self.author is None:
            return None
        mu = np.full(self.recording.t.size, np.nan)
        mu[self.span] = self.author.mu
        return mu


def subject_of(recording: Recording, folder: Path | None, declared: float | None = None) -> Subject:
    """A recording with the author's estimate, where a file of his lies in the folder.

    Args:
        recording: what was measured.
        folder: where the author's files are; None for nowhere.
        declared: friction coefficient to take the error from [1]; None for that of the author's file,
            of the surface by the recording's name, or of the rig or the recording, in this order.

    Raises:
        InvalidInputError: the author's file is of another recording, mu is known from nowhere, or
            nothing is left to take the error over.
    """
    file = None if folder is None else author_file(folder, recording.name)
    author = None if file is None or not file.exists() else read_author_estimate(file)
    if author is None:
        first, last = _beginning(recording), recording.t.size
    else:
        try:
            first = aligned(recording.psi, author.psi)
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
    known, origin = _declared(recording, author, declared)
    return Subject(
        recording=recording,
        declared=known,
        origin=origin,
        author=author,
        span=slice(first, last),
        settled=settled,
    )


def _beginning(recording: Recording) -> int:
    turned = np.abs(recording.psi - recording.psi[0]) >= TURNED
    if not turned.any():
        raise InvalidInputError(
            f"{recording.name}: the wheel turns by less than {TURNED} rad; nothing slides"
        )
    return int(np.argmax(turned))


def _declared(
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
