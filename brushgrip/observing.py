"""Observers put to work on recordings: the settings a command chooses, and tracks to draw."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from enum import StrEnum

from brushgrip.friction import FrictionTrack
from identification.modelfile import FoundModel
from identification.recordings import Recording
from observers import Ekf, Estimates, Mhe, Observer, Tuning, run
from symbolic import Model


class ObserverName(StrEnum):
    """Observers by the name that a user gives."""

    EKF = "ekf"
    MHE = "mhe"


_BUILDERS: Mapping[ObserverName, Callable[..., Observer]] = {
    ObserverName.EKF: Ekf,
    ObserverName.MHE: Mhe,
}


def observe(name: ObserverName, recording: Recording, found: FoundModel | None = None) -> Estimates:
    """Friction over a recording, sample by sample.

    Args:
        name: the observer.
        recording: what was measured.
        found: the model that a diagnosis found; the declared model, k as given, without it.
    """
    tuning = Tuning()
    if found is None:
        model, values = Model(), {"k": recording.tyre.k}
    else:
        # A causal observer cannot know what was fitted to a whole recording, as its torque zero.
        shared_only = replace(found, own={})
        model, values = found.model, shared_only.values_for(recording.name, tuning.mu)
        del values["mu"]
    observer = _BUILDERS[name](model=model, values=values, rig=recording.rig, tuning=tuning)
    rate = recording.psi_dot if recording.psi_dot_recorded else None
    return run(observer, recording.t, recording.psi, recording.F_N, recording.M_z, rate)


def track(name: ObserverName, recording: Recording, estimates: Estimates, model: str) -> FrictionTrack:
    """Estimates ready to be drawn beside the declared mu; `model` says which model was used."""
    return FrictionTrack(
        name=recording.name,
        label=f"{name.upper()}, {model}",
        t=estimates.t,
        mu=estimates.mu,
        mu_std=estimates.mu_std,
        informed=estimates.informed,
        reference=recording.tyre.mu,
    )
