"""Methods of estimating friction that `compare` sets side by side."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import Protocol

from brushgrip.estimation.estimates import (
    OBSERVERS,
    ObserverFactory,
    angle_without_imputed,
    model_observer,
    mu_eff_or_mu,
    root_solver,
    run_observer,
)
from brushgrip.inputs.choices import ObserverName
from identification import FoundModel, Recording
from observers import Ekf
from observers.embedded import NativeObserver, compile_native
from symbolic import Model, Rig, compiler
from symbolic.array_alias import Array

SMOOTHING = 0.99
"""Weight of the last value in the exponential filter of [Györök 2022], (5.9) [1]."""


class Method(Protocol):
    """A method of estimating friction; `compare` takes any object with these members."""

    @property
    def name(self) -> str:
        """Name of the method in the tables."""

    @property
    def works_beyond_five_zones(self) -> bool:
        """Whether the estimate is right where nested reversals make seven zones or more."""

    @property
    def gives_deviation(self) -> bool:
        """Whether the method gives a standard deviation."""

    def estimate(self, recording: Recording) -> Array:
        """Effective friction at every sample, from this and earlier samples alone, shape (n,) [1].

        That of the declared model is its mu. Each call is timed; work done once per recording, such as
        compiling, is to be cached.
        """


@dataclass(frozen=True, kw_only=True)
class ObserverMethod:
    """A method that runs an observer sample by sample, as a controller does.

    Attributes:
        factory: builds the observer for a recording; any `observers.Observer` will do.
        found: the model of a diagnosis, handed to the factory; None for the declared model.
    """

    name: str
    factory: ObserverFactory
    found: FoundModel | None = None
    works_beyond_five_zones: bool = True
    gives_deviation: bool = True

    def estimate(self, recording: Recording) -> Array:
        """See `Method.estimate`."""
        observer = self.factory(recording, self.found)
        return mu_eff_or_mu(run_observer(observer, recording, one_by_one=True))


@dataclass(frozen=True, kw_only=True)
class CompiledEkf:
    """The EKF as C in single precision, compiled for this machine and run within this process.

    Attributes:
        found: the model of a diagnosis; None for the declared model.
    """

    found: FoundModel | None = None
    name: str = "EKF in C"
    works_beyond_five_zones: bool = True
    gives_deviation: bool = True

    def estimate(self, recording: Recording) -> Array:
        """See `Method.estimate`."""
        ekf = model_observer(Ekf, recording, self.found)
        code = _compiled_ekf(ekf.model, tuple(ekf.values.items()), ekf.rig)
        psi_dot = recording.psi_dot if recording.psi_dot_recorded else None
        psi = angle_without_imputed(recording)
        channels = (recording.t, psi, recording.F_N, recording.M_z, psi_dot)
        return mu_eff_or_mu(code.run(*channels))


ROOT_METHODS: Mapping[str, ObserverFactory] = {
    "root, five zones": root_solver,
    "root, filtered (5.9)": partial(root_solver, smoothing=SMOOTHING),
}
"""The root solve of [Györök 2022]: at most five zones, no standard deviation, the declared model."""
MODEL_METHODS: Mapping[str, ObserverFactory] = {
    "EKF": OBSERVERS[ObserverName.EKF],
    "MHE": OBSERVERS[ObserverName.MHE],
}
"""Observers on the declared model or on one that was found."""


def default_methods(found: FoundModel | None = None) -> list[Method]:
    """The methods that the command compares; `EKF in C` where there is a compiler.

    Filters are on the model of a diagnosis, or on the declared one; the root solve always is.
    """
    methods: list[Method] = [
        ObserverMethod(name=name, factory=factory, works_beyond_five_zones=False, gives_deviation=False)
        for name, factory in ROOT_METHODS.items()
    ]
    methods += [
        ObserverMethod(name=name, factory=factory, found=found)
        for name, factory in MODEL_METHODS.items()
    ]
    return [*methods, CompiledEkf(found=found)] if compiler() is not None else methods


@cache
def _compiled_ekf(model: Model, values: tuple[tuple[str, float], ...], rig: Rig) -> NativeObserver:
    return compile_native(Ekf(model=model, values=dict(values), rig=rig))
