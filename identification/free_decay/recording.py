"""Recordings of a free vibration: the wheel is struck, swings and comes to rest."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np

from identification.reading.checked_sample_table import DECAY_COLUMNS, MIN_SAMPLES
from identification.reading.readers import READERS, Reader, read_table
from identification.reading.rigfile import rig_overridden_by_table
from identification.reading.signal_map import NO_MAP, SignalMap, parse_signals
from symbolic import InvalidInputError, Rig, Tyre
from symbolic.float_array_type import Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Decay:
    """The yaw angle of a wheel that has been struck. Arrays are read-only copies of shape (n,).

    Attributes:
        name: name in results and figures.
        t: time [s], increasing.
        psi: yaw angle as the encoder shows it, from a zero of its own [rad]; samples that were missing
            are left out.
        rig: the rig as declared, with its inertia J_A.
        tyre: the tyre as declared; its k is a first guess.

    Raises:
        InvalidInputError: shapes differ, there are fewer than `MIN_SAMPLES`, time does not increase, a
            value is not finite, or J_A is unknown.
    """

    name: str
    t: Array
    psi: Array
    rig: Rig
    tyre: Tyre

    def __post_init__(self) -> None:
        """Freeze the arrays and check everything."""
        for field in ("t", "psi"):
            array = np.array(getattr(self, field), dtype=np.float64)
            array.setflags(write=False)
            object.__setattr__(self, field, array)
        if self.t.ndim != 1 or self.t.shape != self.psi.shape:
            raise InvalidInputError(
                f"{self.name}: psi has shape {self.psi.shape}, t has {self.t.shape}; equal"
                " one-dimensional shapes are needed"
            )
        if self.t.size < MIN_SAMPLES:
            raise InvalidInputError(
                f"{self.name}: {self.t.size} samples of psi, at least {MIN_SAMPLES} needed"
            )
        if not (np.isfinite(self.t).all() and np.isfinite(self.psi).all()):
            raise InvalidInputError(f"{self.name}: t and psi must be finite throughout")
        if not (np.diff(self.t) > 0).all():
            raise InvalidInputError(f"{self.name}: t must increase from sample to sample")
        if self.rig.J_A is None:
            raise InvalidInputError(
                f"{self.name}: J_A is not known, and a free vibration shows only k/J_A and b_t/J_A;"
                " give J_A [kg m^2] under [rig] of the rig file, or as '# J_A = 0.15' before a header"
            )

    @property
    def inertia(self) -> float:
        """J_A [kg m^2]."""
        return cast(float, self.rig.J_A)


def read_decay(
    path: str | Path,
    rig: tuple[Rig, Tyre] | None = None,
    *,
    readers: Mapping[str, Reader] = READERS,
    signals: SignalMap | str = NO_MAP,
) -> Decay:
    """Read a free vibration; formats, readers and signals are as of `read_recording`.

    Only t and psi are needed (`time` and `Psi` in a MAT file); other columns are ignored. Values that
    the recording declares, such as ``# a = 0.045`` or ``# J_A = 0.15``, override those of `read_rig`.

    Raises:
        InvalidInputError: one line naming the file, the row, what is wrong and what is allowed.
    """
    path = Path(path)
    signals = parse_signals(signals) if isinstance(signals, str) else signals
    table = read_table(path, DECAY_COLUMNS, readers, signals)
    own_rig, own_tyre = rig_overridden_by_table(table, rig)
    present = np.isfinite(table.columns["psi"])
    try:
        return Decay(
            name=path.stem,
            t=table.columns["t"][present],
            psi=table.columns["psi"][present],
            rig=own_rig,
            tyre=own_tyre,
        )
    except InvalidInputError as error:
        # The message begins with the recording's name; that of a file begins with its path.
        raise InvalidInputError(f"{path}{str(error).removeprefix(path.stem)}") from None
