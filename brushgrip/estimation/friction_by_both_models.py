"""What a found model does for friction: the EKF's estimates before and after, recording by recording."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from brushgrip.estimation.friction_at_common_load import at_load, common_load
from brushgrip.estimation.friction_budget import friction_budget
from brushgrip.estimation.observe_recording import (
    FrictionTrack,
    aligning_torque_is_measured,
    friction_track,
    observe,
    observer_factory,
)
from brushgrip.inputs.option_choices import ObserverName
from identification import Diagnosis, FoundModel, Recording, signals_of
from identification.selection.trial_runner import Submit, results_of, run_in_this_process
from observers import GroundFriction, SelfConsistency, friction_spread, ground_friction, self_consistency
from symbolic import Rig
from symbolic.patch_moment_by_zones import full_slide_arm
from symbolic.tables.found_model import has_implausible_stiffness
from symbolic.trajectory_sensitivity import final_full_slide_memory

_TrackAndConsistency = tuple[FrictionTrack, SelfConsistency]
Stage = Mapping[str, SelfConsistency]
"""Consistency of the estimates on each recording with the final one, by name."""
MODELS = ("assumed model", "model found")
EKF_DECLARED, EKF_FOUND, MHE_FOUND = (f"EKF, {MODELS[0]}", f"EKF, {MODELS[1]}", f"MHE, {MODELS[1]}")
"""Labels of tracks."""
MAX_COMPARED = 6
"""Most recordings whose friction over time is shown by every observer."""
FIGURES = ("settling", "drift", "relative_band", "coverage", "reference_coverage")
"""Figures of `SelfConsistency` that are averaged over recordings."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionByBothModels:
    """Friction by the EKF on the assumed model, k as given (before), and on the model found (after)."""

    before: Stage
    after: Stage
    grounds: Mapping[str, tuple[str, ...]]  # Recordings of each ground, "" for none.
    holdout: tuple[str, ...] = ()  # No shared parameter was fitted to them; they chose the effects.
    tracks: tuple[FrictionTrack, ...] = ()  # Of every recording by both; of some by `MHE_FOUND`.
    slide_speed: float | None = None  # That mu_eff belongs to, mean over contact and recordings [m/s].
    slide_rate: float | None = None  # Turning at which it slides so [rad/s].
    load: float | None = None  # That mu_eff by the model found is told at [N]; None: it changes nothing.
    inclination: float | None = None  # Of kingpins in the vehicle that is the model found [rad].
    # Mean mu_eff of each ground by the model without its stand-ins over that with them [1], both fitted
    # to whole recordings; empty where the diagnosis has no such model.
    without_stand_ins: Mapping[str, float] = field(default_factory=dict)

    def tracks_of(self, label: str = EKF_FOUND) -> dict[str, FrictionTrack]:
        """The tracks of an observer, `EKF_DECLARED`, `EKF_FOUND` or `MHE_FOUND`, by recording."""
        return {track.name: track for track in self.tracks if track.label == label}

    def known_tracks(self, ground: str, label: str = EKF_FOUND) -> list[tuple[FrictionTrack, int]]:
        """The tracks on a ground whose friction is known, each with its last usable sample."""
        tracks = self.tracks_of(label)
        own = [tracks[name] for name in self.grounds[ground] if name in tracks]
        return [(track, at) for track in own if (at := track.last_usable) is not None]

    @property
    def is_known_in_any_recording(self) -> bool:
        """Whether friction is known in a recording by the model found."""
        return any(map(self.known_tracks, self.grounds))

    def recordings_without_friction(self) -> list[str]:
        """The recordings whose friction is not known by the model found."""
        return [name for name, track in self.tracks_of().items() if track.last_usable is None]

    @property
    def complete_tracks(self) -> tuple[FrictionTrack, ...]:
        """All tracks of the recordings that have one by every observer."""
        return tuple(track for track in self.tracks if track.name in self.tracks_of(MHE_FOUND))

    def names_by_group(self) -> dict[str, tuple[str, ...]]:
        """Names of the training and, where there are any, of the held-out recordings."""
        training = tuple(name for name in self.before if name not in self.holdout)
        return {"training": training, **({"holdout": self.holdout} if self.holdout else {})}

    def last_usable_by_ground(self, label: str = EKF_FOUND) -> dict[str, GroundFriction]:
        """Friction of each named ground by the last usable samples; grounds without one are left out."""
        known = {ground: self.known_tracks(ground, label) for ground in self.grounds if ground}
        return {
            ground: ground_friction(
                [float(t.mu[at]) for t, at in own], [float(t.mu_std[at]) for t, at in own]
            )
            for ground, own in known.items()
            if own
        }

    def prediction_band_by_ground(self, label: str = EKF_FOUND) -> dict[str, GroundFriction]:
        """Those of `last_usable_by_ground` that have a band for a further recording."""
        usable = self.last_usable_by_ground(label)
        return {ground: one for ground, one in usable.items() if one.further is not None}

    def to_dict(self) -> dict[str, Any]:
        """The content of `friction` in `diagnosis.json`."""
        named = {ground: names for ground, names in self.grounds.items() if ground}
        groups = self.names_by_group()
        return {
            name: {
                "mean": settling_and_coverage(stage, stage),
                **{g: {"mean": settling_and_coverage(stage, names)} for g, names in groups.items()},
                # Coefficient of variation of the final mu_eff; None below two recordings.
                "spread": {g: friction_spread([stage[n] for n in names]) for g, names in named.items()},
                "further": {g: asdict(one) for g, one in self.last_usable_by_ground(label).items()},
                "load": self.load if stage is self.after else None,
                "inclination": self.inclination if stage is self.after else None,
                "without_stand_ins": dict(self.without_stand_ins) if stage is self.after else {},
                "recordings": {
                    recording: asdict(consistency)
                    | summarise_usable(self.tracks_of(label).get(recording))
                    for recording, consistency in stage.items()
                },
            }
            for name, stage, label in (
                ("before", self.before, EKF_DECLARED),
                ("after", self.after, EKF_FOUND),
            )
        }


def settling_and_coverage(stage: Stage, recordings: Iterable[str]) -> dict[str, float | None]:
    """The figures of `FIGURES`, each averaged over those of the recordings that have it."""
    chosen = [stage[name] for name in recordings]
    return {figure: _mean([getattr(one, figure) for one in chosen]) for figure in FIGURES}


def summarise_usable(track: FrictionTrack | None) -> dict[str, float | None]:
    """Share of usable samples [1], and time [s] and friction [1] of the last; None without any."""
    if track is None:
        return {}
    at = track.last_usable
    known = {"last_usable": track.t, "usable_mu_eff": track.mu, "usable_mu_eff_std": track.mu_std}
    return {
        "usable": track.usable_share,
        **{name: None if at is None else float(values[at]) for name, values in known.items()},
    }


def found_model(diagnosis: Diagnosis) -> FoundModel:
    """The model of a diagnosis for recordings that it has not seen."""
    return FoundModel(
        model=diagnosis.model,
        tyre=diagnosis.values.tyre,
        own={},
        grounds=diagnosis.values.grounds,
        error=diagnosis.model_error,
        basis=diagnosis.basis,
        k_std=k.std if (k := diagnosis.parameters.get("k")) is not None else None,
    )


def _model_with_values_of_recordings(diagnosis: Diagnosis) -> FoundModel:
    """The model of a diagnosis with what was fitted to each of its recordings."""
    return replace(found_model(diagnosis), own=diagnosis.values.own, rig=diagnosis.values.rig)


def friction_by_both_models(
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    diagnosis: Diagnosis,
    submit: Submit = run_in_this_process,
    by_inclination: Sequence[Recording] | None = None,
) -> FrictionByBothModels | None:
    """The EKF over every recording by both models; None where a recording has no aligning torque.

    None, too, where k of the model is of another scale than the declared one. The moving-horizon
    estimator goes over `MAX_COMPARED` of the recordings too, those held out first. `submit` takes the
    work to processes; the result is the same. `by_inclination` are all recordings of a car by the
    vehicle with the inclination of the diagnosis, which then is the model found.
    """
    recordings = [*training, *holdout]
    if not recordings or not all(aligning_torque_is_measured(recording) for recording in recordings):
        return None
    of_found = by_inclination or recordings
    compared = [*of_found[len(training) :], *of_found[: len(training)]][:MAX_COMPARED]
    found = found_model(diagnosis)
    fitted = _model_with_values_of_recordings(diagnosis)
    on_rig = [r for r in recordings if r.standstills is None]
    stiffness = ((found.values_for_estimation(r.ground)["k"], r) for r in on_rig)
    if any(has_implausible_stiffness(k, r.tyre.k, r.rig.tolerances.k) for k, r in stiffness):
        return None
    load = common_load(found, recordings)
    pairs = list(zip(recordings, of_found, strict=True))
    by_found = {r.name: offline_mu_eff_at_end(fitted, r, load, one.rig) for r, one in pairs}
    by_declared = {r.name: offline_mu_eff_at_end(fitted, r) for r in recordings}
    labels = dict.fromkeys(r.ground or "" for r in recordings)
    grounds = {g: tuple(r.name for r in recordings if (r.ground or "") == g) for g in labels}
    runs = {
        MHE_FOUND: (ObserverName.MHE, found, compared),
        EKF_FOUND: (ObserverName.EKF, found, of_found),
        EKF_DECLARED: (ObserverName.EKF, None, recordings),
    }
    # To build an observer takes longer than to run it, and one serves all recordings.
    outcomes: dict[str, dict[str, _TrackAndConsistency]] = results_of(
        {
            label: submit(_tracks_of, observer, model, some, by_found if model else by_declared, load)
            for label, (observer, model, some) in runs.items()
        }
    )
    return FrictionByBothModels(
        before={r.name: outcomes[EKF_DECLARED][r.name][1] for r in recordings},
        after={r.name: outcomes[EKF_FOUND][r.name][1] for r in recordings},
        grounds=grounds,
        holdout=tuple(recording.name for recording in holdout),
        tracks=tuple(
            outcomes[label][r.name][0]
            for r in recordings
            for label in (EKF_DECLARED, EKF_FOUND, MHE_FOUND)
            if r.name in outcomes[label]
        ),
        slide_speed=_mean([r.rig.slide_rate * full_slide_arm(r.rig.a, r.rig.e) for r in recordings]),
        slide_rate=_mean([r.rig.slide_rate for r in recordings]),
        load=load,
        inclination=diagnosis.inclination if by_inclination else None,
        without_stand_ins=_friction_without_stand_ins(diagnosis, recordings, grounds, load),
    )


def _friction_without_stand_ins(
    diagnosis: Diagnosis,
    recordings: Sequence[Recording],
    grounds: Mapping[str, Sequence[str]],
    load: float | None,
) -> dict[str, float]:
    """See `FrictionOutcome.without_stand_ins`."""
    if diagnosis.without_stand_ins is None:
        return {}
    model, values = diagnosis.without_stand_ins
    poorer = replace(diagnosis, model=model, values=values)
    mu, told = (
        {r.name: offline_mu_eff_at_end(_model_with_values_of_recordings(d), r, load) for r in recordings}
        for d in (poorer, diagnosis)
    )
    return {
        ground: float(np.mean([mu[n] for n in names]) / np.mean([told[n] for n in names]))
        for ground, names in grounds.items()
    }


def _tracks_of(
    observer: ObserverName,
    model: FoundModel | None,
    recordings: Sequence[Recording],
    references: Mapping[str, float],
    load: float | None,
) -> dict[str, _TrackAndConsistency]:
    """Tracks of an observer over recordings, and how consistent, by name; of a found model at a load."""
    factory, observed = observer_factory(observer), {}
    for recording in recordings:
        # A car's observer takes no model but its vehicle.
        used = None if recording.standstills is not None else model
        estimates, reference = observe(factory, recording, used), references[recording.name]
        if used is not None and load is not None:
            estimates = at_load(estimates, used, recording, load)
        with_budget = observer is ObserverName.EKF and model is not None
        track = replace(
            friction_track(observer, recording, estimates, MODELS[model is not None]),
            reference=reference,
            reference_label="μ_eff fitted to the whole recording",
            budget=friction_budget(factory, recording, used, estimates) if with_budget else {},
        )
        observed[recording.name] = track, self_consistency(estimates, reference)
    return observed


def offline_mu_eff_at_end(
    found: FoundModel, recording: Recording, load: float | None = None, told: Rig | None = None
) -> float:
    """mu_eff at the end of a recording [1] that the diagnosis saw: mu and rig fitted to all of it.

    Independent of the filter, not of the recording or of the model found. At a load [N], None for the
    recording's median; told by the contact of a rig, None for the recording's.
    """
    model, rig = found.model, recording.rig
    told = told or rig
    fitted = found.rig.get(recording.name, {})
    load = float(np.median(recording.F_N)) if load is None else load
    theta = model.theta(found.values_for_recording(recording.name, ground=recording.ground))
    memory = final_full_slide_memory(model, signals_of(recording), np.asarray(theta).ravel())
    _, corrected = model.full_slide(
        memory,
        load * fitted.get("load", 1.0),
        theta,
        [fitted.get("a", rig.a), fitted.get("e", rig.e)],
        rig.slide_rate,
    )
    mu_eff, torque = model.full_slide(memory, load, theta, [told.a, told.e], rig.slide_rate)
    return float(corrected * mu_eff / torque)


def _mean(figures: Sequence[float | None]) -> float | None:
    known = [figure for figure in figures if figure is not None]
    return float(np.mean(known)) if known else None
