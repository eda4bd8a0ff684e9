"""Methods of estimating friction that `compare` sets side by side, the networks of [Györök 2022] too."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Protocol

import numpy as np

from brushgrip.comparison.recordings_with_reference_friction import Case
from brushgrip.estimation.observe_recording import (
    ObserverFactory,
    model_observer,
    mu_eff_or_mu,
    observer_factory,
    root_observer_on_declared_model,
    run_arguments,
)
from brushgrip.inputs.option_choices import ObserverName
from identification import FoundModel, Recording
from identification.thesis import Activation, FrictionNetwork, NetworkDesign, label_mean, train_network
from observers import Ekf, MeasurementModel, RootObserver, Tuning, ZoneHistory, run, zone_history
from observers.embedded import NativeObserver, compile_native
from symbolic import Model, Rig, compiler
from symbolic.float_array_type import Array

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

    def estimate_mu_eff(self, recording: Recording) -> Array:
        """Effective friction at every sample, from this and earlier samples alone, shape (n,) [1].

        That of the declared model is its mu. Each call is timed; work done once per recording, such as
        compiling, is to be cached.
        """


@dataclass(frozen=True, kw_only=True)
class ObserverMethod:
    """A method that runs any `observers.Observer` sample by sample, as a controller does."""

    name: str
    factory: ObserverFactory
    found: FoundModel | None = None
    works_beyond_five_zones: bool = True
    gives_deviation: bool = True

    def estimate_mu_eff(self, recording: Recording) -> Array:
        """See `Method.estimate_mu_eff`."""
        observer = self.factory(recording, self.found)
        return mu_eff_or_mu(run(observer, **run_arguments(recording), one_by_one=True))


@dataclass(frozen=True, kw_only=True)
class CompiledEkf:
    """The EKF as C in single precision, compiled for this machine and run within this process."""

    found: FoundModel | None = None
    name: str = "EKF in C"
    works_beyond_five_zones: bool = True
    gives_deviation: bool = True

    def estimate_mu_eff(self, recording: Recording) -> Array:
        """See `Method.estimate_mu_eff`."""
        ekf = model_observer(Ekf, recording, self.found)
        code = _compiled_ekf(
            ekf.model, tuple(ekf.values.items()), ekf.rig, ekf.measurement_model, ekf.tuning
        )
        channels = run_arguments(recording)
        return mu_eff_or_mu(code.run(*(channels[n] for n in ("t", "psi", "F_N", "M_z", "psi_dot"))))


def default_methods(found: FoundModel | None = None) -> list[Method]:
    """The methods that the command compares; `EKF in C` where there is a compiler.

    Filters are on the model of a diagnosis, or on the declared one. The root solve of [Györök 2022] is
    always on the declared one, with at most five zones and without a standard deviation.
    """
    roots: dict[str, ObserverFactory] = {
        "root, five zones": root_observer_on_declared_model,
        "root, filtered (5.9)": partial(root_observer_on_declared_model, smoothing=SMOOTHING),
    }
    methods: list[Method] = [
        ObserverMethod(name=name, factory=factory, works_beyond_five_zones=False, gives_deviation=False)
        for name, factory in roots.items()
    ]
    methods += [
        ObserverMethod(name=name.upper(), factory=observer_factory(name), found=found)
        for name in (ObserverName.EKF, ObserverName.MHE)
    ]
    return [*methods, CompiledEkf(found=found)] if compiler() is not None else methods


@cache
def _compiled_ekf(
    model: Model, values: tuple[tuple[str, float], ...], rig: Rig, measured: MeasurementModel,
    tuning: Tuning,
) -> NativeObserver:  # fmt: skip
    return compile_native(
        Ekf(model=model, values=dict(values), rig=rig, measurement_model=measured, tuning=tuning)
    )


ANALYTIC = 9
"""Column of `root_mu_correction_inputs` that holds the analytic estimate of mu."""
MIN_REVERSAL = 5e-4
"""Least turn back that is taken for a reversal [rad], as in `observers.RootObserver`."""


def neural_network_inputs(recording: Recording) -> Array:
    """Inputs of the neural network of [Györök 2022], section 4.1: psi, psi_max and M, shape (n, 3).

    M is -M_z, as in the files published with it; where it is missing, the last value is imputed.
    """
    last_measured = np.maximum.accumulate(
        np.where(np.isfinite(recording.M_z), np.arange(recording.t.size), 0)
    )
    M = np.nan_to_num(-recording.M_z[last_measured])
    return np.column_stack([recording.psi - recording.psi[0], _zones(recording).psi_max, M])


def root_mu_correction_inputs(recording: Recording) -> Array:
    """Inputs of the network of [Györök 2022], section 4.2, shape (n, 10).

    psi, psi_max, M, e, F_N, direction, five zones or three, a, k and the analytic estimate of mu.
    """
    rig, k, history = recording.rig, recording.tyre.k, _zones(recording)
    # The root solver takes missing torques as they are.
    analytic = run(RootObserver(rig=rig, k=k), recording.t, recording.psi, recording.F_N, recording.M_z)
    inputs, ones = neural_network_inputs(recording), np.ones(recording.t.size)
    state = (recording.F_N, history.direction, history.zones == 5)
    return np.column_stack([inputs, rig.e * ones, *state, rig.a * ones, k * ones, analytic.mu])


def train_neural_network(
    recordings: Sequence[Recording], design: NetworkDesign | None = None
) -> FrictionNetwork:
    """The neural network of [Györök 2022], section 4.1, trained on recordings with a declared mu."""
    return train_network(recordings, neural_network_inputs, design, name="neural network")


def train_root_correction_network(
    recordings: Sequence[Recording], design: NetworkDesign | None = None
) -> FrictionNetwork:
    """Root solve with a correcting network: scientific machine learning, [Györök 2022], section 4.2.

    The activation is always tanh, the best in section 4.2.
    """
    tanh = replace(design or NetworkDesign(), activation=Activation.TANH)
    return train_network(
        recordings, root_mu_correction_inputs, tanh, base=ANALYTIC, name="root and network"
    )


def trained_methods(training: Sequence[Case]) -> list[Method]:
    """The networks of [Györök 2022] trained on these cases, and the mean that a method has to beat."""
    labelled = [
        replace(case.recording, tyre=replace(case.recording.tyre, mu=case.declared)) for case in training
    ]
    return [
        train_neural_network(labelled),
        train_root_correction_network(labelled),
        label_mean(labelled),
    ]


def _zones(recording: Recording) -> ZoneHistory:
    """Angles of the last reversals and zones, counted from the first sample."""
    return zone_history(recording.psi - recording.psi[0], MIN_REVERSAL)
