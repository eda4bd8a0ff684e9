"""What a found model does for friction: the EKF's estimates before and after, recording by recording."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from brushgrip.choices import ObserverName
from brushgrip.estimation import OBSERVERS, has_aligning_torque, observe
from identification import Diagnosis, FoundModel, Recording
from observers import FrictionQuality, friction_quality, friction_spread

Stage = Mapping[str, FrictionQuality]
"""The quality of the estimates on each recording, by name."""
MEANS = ("settling", "drift", "coverage", "relative_band")
"""Figures of `FrictionQuality` that are averaged over recordings."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionOutcome:
    """Friction by the EKF on the declared model and on the model found.

    Attributes:
        before: by the declared model, k as given, by recording.
        after: by the model found, by recording.
        grounds: names of the recordings of each ground, those without one under an empty name.
    """

    before: Stage
    after: Stage
    grounds: Mapping[str, tuple[str, ...]]

    @property
    def stages(self) -> Mapping[str, Stage]:
        """Both stages by name."""
        return {"before": self.before, "after": self.after}

    def means(self, stage: Stage) -> dict[str, float | None]:
        """`MEANS` averaged over the recordings that have the figure."""
        return {name: _mean([getattr(quality, name) for quality in stage.values()]) for name in MEANS}

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


def friction_outcome(recordings: Sequence[Recording], found: FoundModel) -> FrictionOutcome | None:
    """The EKF over every recording by both models; None where a recording has no aligning torque."""
    if not recordings or not all(has_aligning_torque(recording) for recording in recordings):
        return None
    factory = OBSERVERS[ObserverName.EKF]
    before, after = (
        {r.name: friction_quality(observe(factory, r, model)) for r in recordings}
        for model in (None, found)
    )
    grounds: dict[str, tuple[str, ...]] = {}
    for recording in recordings:
        ground = recording.ground or ""
        grounds[ground] = (*grounds.get(ground, ()), recording.name)
    return FrictionOutcome(before=before, after=after, grounds=grounds)


def _mean(figures: Sequence[float | None]) -> float | None:
    known = [figure for figure in figures if figure is not None]
    return float(np.mean(known)) if known else None


def friction_figures(outcome: FrictionOutcome) -> list[tuple[str, list[str]]]:
    """Rows of a table, before and after: a label, and the figures averaged over recordings."""
    means = [outcome.means(stage) for stage in outcome.stages.values()]
    rows = [
        ("settled within 10 %, mean [s]", [_decimal(mean["settling"]) for mean in means]),
        ("drift over the second half, mean", [whole_percent(mean["drift"]) for mean in means]),
        ("informed samples whose band holds the end", [whole_percent(m["coverage"]) for m in means]),
        ("standard deviation over μ_eff, median", [_share(mean["relative_band"]) for mean in means]),
    ]
    spreads = [outcome.spread(stage) for stage in outcome.stages.values()]
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
