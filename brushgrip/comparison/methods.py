"""Ways to estimate friction that are held against each other."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from brushgrip.estimation import (
    ObserverName,
    angle_heard,
    observer_for,
    on_model,
    run_on,
)
from identification.modelfile import FoundModel
from identification.reading.recordings import Recording
from observers import Ekf, Observer, ZoneRootSolver
from observers.embedded import NativeObserver, compile_native
from symbolic import Model, Rig
from symbolic.compiled import compiler

Array = NDArray[np.float64]
SMOOTHING = 0.99
"""Share of the last value in the exponential filter of [Györök 2022], (5.9) [1]."""


class Method(Protocol):
    """A way to estimate friction; one more is one more line in `methods`."""

    @property
    def name(self) -> str:
        """What the tables call it."""

    @property
    def works_beyond_five_zones(self) -> bool:
        """Whether it holds when a reversal within five zones of the patch makes seven."""

    @property
    def gives_deviation(self) -> bool:
        """Whether it says how sure it is."""

    def estimate(self, recording: Recording) -> Array:
        """Friction at every sample, from what came before it alone, shape (n,) [1].

        A call is timed; what is made once for a recording, as by a compiler, is to be kept.
        """


@dataclass(frozen=True, kw_only=True)
class Observed:
    """A method that is an observer; it gets its samples one at a time, as from a controller.

    Attributes:
        name: what the tables call it.
        observer: makes the observer for a recording.
        works_beyond_five_zones: as of `Method`.
        gives_deviation: as of `Method`.
    """

    name: str
    observer: Callable[[Recording], Observer]
    works_beyond_five_zones: bool
    gives_deviation: bool

    def estimate(self, recording: Recording) -> Array:
        """See `Method.estimate`."""
        return run_on(self.observer(recording), recording, one_by_one=True).mu


@dataclass(frozen=True, kw_only=True)
class Generated:
    """The EKF as C in single precision, compiled for this machine and run within this process.

    Attributes:
        found: the model of a diagnosis; the declared one without it.
        name: what the tables call it.
        works_beyond_five_zones: as of `Method`.
        gives_deviation: as of `Method`.
    """

    found: FoundModel | None = None
    name: str = "EKF in C"
    works_beyond_five_zones: bool = True
    gives_deviation: bool = True

    def estimate(self, recording: Recording) -> Array:
        """See `Method.estimate`."""
        ekf = on_model(ObserverName.EKF, recording, self.found)
        code = _native(ekf.model, tuple(ekf.values.items()), ekf.rig)
        rate = recording.psi_dot if recording.psi_dot_recorded else None
        return code.run(recording.t, angle_heard(recording), recording.F_N, recording.M_z, rate).mu


def methods(found: FoundModel | None = None) -> list[Method]:
    """Everything that is compared on a recording with its aligning torque.

    Args:
        found: the model of a diagnosis for EKF and MHE; the declared one without it.
    """
    made: list[Method] = [
        Observed(
            name="root, five zones",
            observer=partial(observer_for, ObserverName.ROOT),
            works_beyond_five_zones=False,
            gives_deviation=False,
        ),
        Observed(
            name="root, filtered (5.9)",
            observer=_filtered,
            works_beyond_five_zones=False,
            gives_deviation=False,
        ),
        Observed(
            name="EKF",
            observer=partial(observer_for, ObserverName.EKF, found=found),
            works_beyond_five_zones=True,
            gives_deviation=True,
        ),
        Observed(
            name="MHE",
            observer=partial(observer_for, ObserverName.MHE, found=found),
            works_beyond_five_zones=True,
            gives_deviation=True,
        ),
    ]
    if compiler() is not None:
        made.append(Generated(found=found))
    return made


def _filtered(recording: Recording) -> ZoneRootSolver:
    return ZoneRootSolver(rig=recording.rig, k=recording.tyre.k, smoothing=SMOOTHING)


@cache
def _native(model: Model, values: tuple[tuple[str, float], ...], rig: Rig) -> NativeObserver:
    return compile_native(Ekf(model=model, values=dict(values), rig=rig))
