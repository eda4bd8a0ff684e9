"""What a found model does for friction: the EKF's estimates before and after, recording by recording."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from brushgrip.estimation import OBSERVERS, ObserverName, has_aligning_torque, observe
from identification import FoundModel, Recording
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
