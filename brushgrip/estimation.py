"""Observers put to work on recordings: the settings a command chooses, and tracks to draw."""

from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from brushgrip.friction import FrictionTrack
from identification.modelfile import FoundModel
from identification.reading.recordings import Recording
from observers import (
    AligningTorque,
    Ekf,
    Estimates,
    MeasurementModel,
    Mhe,
    Observer,
    Status,
    SteeringTorque,
    Tuning,
    ZoneRootSolver,
    run,
)
from symbolic import InvalidInputError, Model

Array = NDArray[np.float64]


class ObserverName(StrEnum):
    """Observers by the name that a user gives."""

    EKF = "ekf"
    MHE = "mhe"
    ROOT = "root"


def observe(name: ObserverName, recording: Recording, found: FoundModel | None = None) -> Estimates:
    """Friction over a recording, sample by sample.

    Args:
        name: the observer.
        recording: what was measured; its steering torque is heard where it has no aligning torque.
        found: the model that a diagnosis found; the declared model, k as given, without it.

    Raises:
        InvalidInputError: the observer cannot use the model or the torque, or the rig lacks what it
            takes; the message names the recording.
    """
    return run_on(observer_for(name, recording, found), recording)


def observer_for(name: ObserverName, recording: Recording, found: FoundModel | None = None) -> Observer:
    """The observer with the settings that a recording asks for; arguments and errors as of `observe`."""
    try:
        if name is ObserverName.ROOT:
            return _root(recording, found)
        return on_model(name, recording, found)
    except InvalidInputError as error:
        raise InvalidInputError(f"{recording.name}: {error}") from None


def run_on(observer: Observer, recording: Recording, *, one_by_one: bool = False) -> Estimates:
    """What an observer says of a recording; see `observers.run`."""
    ground, hand = (recording.M_z, None) if hears_ground(recording) else (None, recording.M)
    rate = recording.psi_dot if recording.psi_dot_recorded else None
    psi = angle_heard(recording)
    return run(observer, recording.t, psi, recording.F_N, ground, rate, M=hand, one_by_one=one_by_one)


def angle_heard(recording: Recording) -> Array:
    """The yaw angle as it was measured, NaN where it was filled in [rad]."""
    known = True if recording.psi_recorded is None else recording.psi_recorded
    return np.where(known, recording.psi, np.nan)


def hears_ground(recording: Recording) -> bool:
    """True where the aligning torque was measured; it goes before the steering torque."""
    return bool(np.isfinite(recording.M_z).any())


def hears_hand(recording: Recording) -> bool:
    """True where the steering torque was measured."""
    return recording.M is not None and bool(np.isfinite(recording.M).any())


def _root(recording: Recording, found: FoundModel | None) -> ZoneRootSolver:
    if found is not None:
        raise InvalidInputError(
            "--observer root solves the declared zones and knows no effects;"
            " leave --model out, or use ekf or mhe"
        )
    if not hears_ground(recording):
        raise InvalidInputError("--observer root needs M_z; from M, use ekf or mhe")
    return ZoneRootSolver(rig=recording.rig, k=recording.tyre.k)


def on_model(name: ObserverName, recording: Recording, found: FoundModel | None) -> Ekf | Mhe:
    """EKF or MHE on the declared model, k as given, or on one that was found."""
    tuning = Tuning()
    if found is None:
        model, values = Model(), {"k": recording.tyre.k}
    else:
        # A causal observer cannot know what was fitted to a whole recording, as its torque zero.
        model, values = found.model_for_estimation(), found.values_for_estimation()
    measurement_model: MeasurementModel = (
        AligningTorque() if hears_ground(recording) else SteeringTorque()
    )
    kind = Ekf if name is ObserverName.EKF else Mhe
    return kind(
        model=model, values=values, rig=recording.rig, tuning=tuning, measurement_model=measurement_model
    )


def track(name: ObserverName, recording: Recording, estimates: Estimates, model: str) -> FrictionTrack:
    """Estimates ready to be drawn beside the declared mu; `model` says which model was used."""
    label = name.value if name is ObserverName.ROOT else name.upper()
    return FrictionTrack(
        name=recording.name,
        label=f"{label}, {model}",
        t=estimates.t,
        mu=estimates.mu,
        mu_std=estimates.mu_std,
        informed=estimates.informed,
        changes=estimates.t[estimates.status & Status.RESET != 0],
        reference=recording.tyre.mu,
    )
