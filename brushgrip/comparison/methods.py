"""Methods of estimating friction that `compare` sets side by side, the networks of [Györök 2022] too."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Protocol

import numpy as np

from brushgrip.comparison.cases import Case
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
from identification.thesis import Activation, Design, FrictionNetwork, label_mean, train
from observers import Ekf, RootObserver, ZoneHistory, run, zone_history
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


ANALYTIC = 9
"""Column of `all_inputs` that holds the analytic estimate of mu."""
MIN_REVERSAL = 5e-4
"""Least turn back that is taken for a reversal [rad], as in `observers.RootObserver`."""


def angle_and_torque_inputs(recording: Recording) -> Array:
    """Inputs of the neural network of [Györök 2022], section 4.1: psi, psi_max and M, shape (n, 3).

    M is -M_z, as in the files published with it; where it is missing, the last value is imputed.
    """
    last_measured = np.maximum.accumulate(
        np.where(np.isfinite(recording.M_z), np.arange(recording.t.size), 0)
    )
    M = np.nan_to_num(-recording.M_z[last_measured])
    return np.column_stack([recording.psi - recording.psi[0], _zones(recording).psi_max, M])


def all_inputs(recording: Recording) -> Array:
    """Inputs of the network of [Györök 2022], section 4.2, shape (n, 10).

    psi, psi_max, M, e, F_N, direction, five zones or three, a, k and the analytic estimate of mu.
    """
    rig, k, history = recording.rig, recording.tyre.k, _zones(recording)
    # The root solver takes missing torques as they are.
    analytic = run(RootObserver(rig=rig, k=k), recording.t, recording.psi, recording.F_N, recording.M_z)
    constant = [np.full(recording.t.size, value) for value in (rig.e, rig.a, k)]
    return np.column_stack([
        angle_and_torque_inputs(recording),
        constant[0],
        recording.F_N,
        history.direction,
        history.zones == 5,
        *constant[1:],
        analytic.mu,
    ])  # fmt: skip


def neural_network(recordings: Sequence[Recording], design: Design | None = None) -> FrictionNetwork:
    """The neural network of [Györök 2022], section 4.1, trained on recordings with a declared mu."""
    return train(recordings, angle_and_torque_inputs, design, name="neural network")


def corrected_root(recordings: Sequence[Recording], design: Design | None = None) -> FrictionNetwork:
    """Root solve with a correcting network: scientific machine learning, [Györök 2022], section 4.2.

    The activation is always tanh, the best in section 4.2.
    """
    tanh = replace(design or Design(), activation=Activation.TANH)
    return train(recordings, all_inputs, tanh, base=ANALYTIC, name="root and network")


def trained_methods(training: Sequence[Case]) -> list[Method]:
    """The networks of [Györök 2022] trained on these cases, and the mean that a method has to beat."""
    labelled = [
        replace(case.recording, tyre=replace(case.recording.tyre, mu=case.declared)) for case in training
    ]
    return [neural_network(labelled), corrected_root(labelled), label_mean(labelled)]


def _zones(recording: Recording) -> ZoneHistory:
    """Angles of the last reversals and zones, counted from the first sample."""
    return zone_history(recording.psi - recording.psi[0], MIN_REVERSAL)
