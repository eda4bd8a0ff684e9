"""What a found model does for friction: the EKF's estimates before and after, recording by recording."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from brushgrip.estimation.estimates import (
    OBSERVERS,
    FrictionTrack,
    friction_track,
    has_aligning_torque,
    observe,
)
from brushgrip.inputs.choices import ObserverName
from identification import Diagnosis, FoundModel, Recording
from observers import FrictionQuality, friction_quality, friction_spread

Stage = Mapping[str, FrictionQuality]
"""The quality of the estimates on each recording, by name."""
GROUP_LABELS = {"training": "training", "holdout": "held out"}
"""Labels of `FrictionOutcome.groups`."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionOutcome:
    """Friction by the EKF on the declared model and on the model found.

    Attributes:
        before: by the declared model, k as given, by recording.
        after: by the model found, by recording.
        grounds: names of the recordings of each ground, those without one under an empty name.
        holdout: names of the recordings to which no shared parameter was fitted; their errors still
            chose the effects.
    """

    before: Stage
    after: Stage
    grounds: Mapping[str, tuple[str, ...]]
    holdout: tuple[str, ...] = ()

    @property
    def stages(self) -> Mapping[str, Stage]:
        """Both stages by name."""
        return {"before": self.before, "after": self.after}

    def groups(self) -> Mapping[str, tuple[str, ...]]:
        """Names of the training and, where there are any, of the held-out recordings."""
        training = tuple(name for name in self.before if name not in self.holdout)
        return {"training": training, **({"holdout": self.holdout} if self.holdout else {})}

    def means(self, stage: Stage, names: Sequence[str] | None = None) -> dict[str, float | None]:
        """The figures of `LABELS`, each averaged over those of the recordings that have it."""
        chosen = [stage[name] for name in (stage if names is None else names)]
        return {figure: _mean([getattr(quality, figure) for quality in chosen]) for figure in LABELS}

    def spread(self, stage: Stage) -> dict[str, float | None]:
        """Coefficient of variation of the final mu_eff on each ground [1]; None below two recordings."""
        return {
            ground: friction_spread([stage[name] for name in names])
            for ground, names in self.grounds.items()
            if ground
        }

    def to_dict(self) -> dict[str, Any]:
        """The content of `friction` in `diagnosis.json`."""
        return {
            name: {
                "mean": self.means(stage),
                **{group: {"mean": self.means(stage, names)} for group, names in self.groups().items()},
                "spread": self.spread(stage),
                "recordings": {recording: asdict(quality) for recording, quality in stage.items()},
            }
            for name, stage in self.stages.items()
        }


def found_model(diagnosis: Diagnosis) -> FoundModel:
    """The model of a diagnosis for recordings that it has not seen."""
    return FoundModel(
        model=diagnosis.model,
        tyre=diagnosis.values.tyre,
        own={},
        grounds=diagnosis.values.grounds,
        error=diagnosis.model_error,
    )


def fitted_model(diagnosis: Diagnosis) -> FoundModel:
    """The same with what was fitted to each recording that the diagnosis has seen."""
    values = diagnosis.values
    return replace(found_model(diagnosis), own=values.own, rig=values.rig)


def friction_outcome(
    training: Sequence[Recording], holdout: Sequence[Recording], diagnosis: Diagnosis
) -> FrictionOutcome | None:
    """The EKF over every recording by both models; None where a recording has no aligning torque."""
    recordings = [*training, *holdout]
    if not recordings or not all(has_aligning_torque(recording) for recording in recordings):
        return None
    factory = OBSERVERS[ObserverName.EKF]
    found, fitted = found_model(diagnosis), fitted_model(diagnosis)
    references = {recording.name: offline_friction(fitted, recording) for recording in recordings}
    before, after = (
        {r.name: friction_quality(observe(factory, r, model), references[r.name]) for r in recordings}
        for model in (None, found)
    )
    grounds: dict[str, tuple[str, ...]] = {}
    for recording in recordings:
        ground = recording.ground or ""
        grounds[ground] = (*grounds.get(ground, ()), recording.name)
    held_out = tuple(recording.name for recording in holdout)
    return FrictionOutcome(before=before, after=after, grounds=grounds, holdout=held_out)


def estimate_friction(recordings: Sequence[Recording], diagnosis: Diagnosis) -> list[FrictionTrack]:
    """Friction over each recording: EKF on the declared model, EKF and MHE on the model found."""
    found, fitted = found_model(diagnosis), fitted_model(diagnosis)
    runs: list[tuple[ObserverName, FoundModel | None, str]] = [
        (ObserverName.EKF, None, "declared model"),
        (ObserverName.EKF, found, "model found"),
        (ObserverName.MHE, found, "model found"),
    ]
    return [
        replace(
            friction_track(observer, recording, observe(OBSERVERS[observer], recording, model), label),
            reference=offline_friction(fitted, recording),
            reference_label="μ_eff fitted to the whole recording",
        )
        for recording in recordings
        for observer, model, label in runs
    ]


def offline_friction(found: FoundModel, recording: Recording) -> float:
    """mu_eff of a recording [1] that the diagnosis saw: mu and rig tolerances fitted to all of it.

    Independent of the filter, not of the recording or of the model found.
    """
    model, rig = found.model, recording.rig
    fitted = found.rig.get(recording.name, {})
    load = float(np.median(recording.F_N))
    theta = model.theta(found.values_for(recording.name, ground=recording.ground))
    memory = np.zeros(model.memory_size)
    _, corrected = model.full_slide(
        memory,
        load * fitted.get("load", 1.0),
        theta,
        [fitted.get("a", rig.a), fitted.get("e", rig.e)],
        rig.slide_rate,
    )
    mu_eff, torque = model.full_slide(memory, load, theta, [rig.a, rig.e], rig.slide_rate)
    return float(corrected * mu_eff / torque)


def _mean(figures: Sequence[float | None]) -> float | None:
    known = [figure for figure in figures if figure is not None]
    return float(np.mean(known)) if known else None


def friction_figures(outcome: FrictionOutcome) -> list[tuple[str, list[str]]]:
    """Rows of a table, before and after: a label, and figures of training and held-out recordings."""
    stages = outcome.stages.values()
    rows = []
    for group, names in outcome.groups().items():
        means = [outcome.means(stage, names) for stage in stages]
        rows += [
            (f"{GROUP_LABELS[group]}: {label}", [text(mean[figure]) for mean in means])
            for figure, (label, text) in LABELS.items()
        ]
    spreads = [outcome.spread(stage) for stage in stages]
    return rows + [
        (f"spread between recordings on {ground}", [_share(spread[ground]) for spread in spreads])
        for ground in spreads[0]
    ]


def end_friction(quality: FrictionQuality) -> str:
    """The effective friction at the end, with its deviation."""
    return f"{quality.mu_eff:.3f} ± {quality.mu_eff_std:.3f}"


def whole_percent(share: float | None) -> str:
    """A share as a whole percentage, a dash where there is none."""
    return "–" if share is None else f"{100 * share:.0f} %"


def _share(share: float | None) -> str:
    return "–" if share is None else f"{100 * share:.1f} %"


def _decimal(value: float | None) -> str:
    return "–" if value is None else f"{value:.1f}"


LABELS: Mapping[str, tuple[str, Callable[[float | None], str]]] = {
    "settling": ("settled within 10 %, mean [s]", _decimal),
    "drift": ("drift over the second half, mean", whole_percent),
    "coverage": ("bands that hold the end", whole_percent),
    "reference_coverage": ("bands that hold the offline fit", whole_percent),
    "relative_band": ("standard deviation over μ_eff, median of informed samples", _share),
}
"""Figures of `FrictionQuality` that are averaged over recordings: label and text of each."""
