"""A proposed experiment: by how much two models would differ, and how significant that would be."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from identification.experiments.manoeuvre_in_recorded_range import SAMPLE_PERIOD, SampledManoeuvre
from identification.fits.autocorrelation import autocorrelation_time
from identification.fits.fitting import Fit
from identification.fits.least_squares_problem import torque_range
from identification.fits.loss import rmse_of
from identification.reading.recordings import Recording
from identification.selection.criteria import DEFAULT_CRITERIA, SelectionCriteria
from symbolic.float_array_type import Array

PATIENCE = 600.0
"""Longest total duration of an experiment that is proposed [s]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Proposal:
    """The experiment that separates two models best; torques of shape (n,), as in the manoeuvre.

    Attributes:
        found: effects that the model taken for true has and the rival lacks; empty for none.
        rival: effects that the rival has and the model taken for true lacks; empty for none.
        manoeuvre: how to turn the wheel.
        torque: the model's torque in it [N m].
        rival_torque: the rival's, after a refit to the model's torque [N m].
        separation: rms of their difference, share of the torque range of the recordings [1].
        now: the same in the recordings at hand [1].
        noise: rms residual of the model in those [1].
        times: number of repetitions; None where not even `PATIENCE` would do.
        standard_errors: by how many the paired test over seconds would then distinguish the two, on all
            recordings; after one repetition where `times` is None [1].
        needed: standard errors from which on it does [1].
    """

    found: str
    rival: str
    manoeuvre: SampledManoeuvre
    torque: Array
    rival_torque: Array
    separation: float
    now: float
    noise: float
    times: int | None
    standard_errors: float
    needed: float = DEFAULT_CRITERIA.clear

    @property
    def feasible(self) -> bool:
        """Whether standard steering separates the two models within `PATIENCE`."""
        return self.times is not None

    @property
    def sentence(self) -> str:
        """How to turn the wheel and the expected difference, or that no standard manoeuvre would do."""
        one, other = _effects_in_words(self.found), _effects_in_words(self.rival)
        differ = f"differ by {self.separation:.2%} of range"
        if self.times is None:
            return (
                f"{one} and {other} cannot be distinguished by standard steering on this rig: in the"
                f" manoeuvre that separates them most ({self.manoeuvre.instruction}) they {differ}"
            )
        often = f", {self.times} times" if self.times > 1 else ""
        return (
            f"{self.manoeuvre.instruction}{often}: {one} and {other} then {differ}, with all recordings"
            f" {self.standard_errors:.1f} standard errors, of which {self.needed:g} are needed"
        )

    def to_dict(self) -> dict[str, Any]:
        """The content of `diagnosis.json`."""
        names = ("rival", "sentence", "separation", "feasible", "times", "standard_errors")
        return {name: getattr(self, name) for name in names}


def proposal_from_torques(
    found: Fit,
    rival: Fit,
    recordings: Sequence[Recording],
    manoeuvre: SampledManoeuvre,
    torques: tuple[Array, Array],
    criteria: SelectionCriteria,
) -> Proposal:
    """The proposal of a manoeuvre in which the two models have these torques [N m]."""
    spans = {r.name: torque_range(r) for r in recordings}
    difference = (torques[0] - torques[1]) / np.mean(list(spans.values()))
    present = _RecordedModelDifference(
        count=len(recordings),
        seconds=sum(float(r.t[-1] - r.t[0]) for r in recordings),
        now=_mean(rmse_of(found.residuals[n] - rival.residuals[n]) / span for n, span in spans.items()),
        noise=_mean(rmse_of(found.residuals[n]) / span for n, span in spans.items()),
        memory=_mean(
            autocorrelation_time(found.residuals[r.name]) * fitted_sample_period(found, r)
            for r in recordings
        ),
    )
    most = max(1, int(PATIENCE / manoeuvre.seconds))
    enough = (
        n for n in range(1, most + 1) if _is_distinguished_by_repeats(difference, present, n, criteria)
    )
    times = next(enough, None)
    return Proposal(
        found=_extra_effect_names(found, rival),
        rival=_extra_effect_names(rival, found),
        manoeuvre=manoeuvre,
        torque=torques[0],
        rival_torque=torques[1],
        separation=rmse_of(difference),
        now=present.now,
        noise=present.noise,
        times=times,
        standard_errors=_difference_in_standard_errors(difference, present, times or 1, criteria.block),
        needed=criteria.clear,
    )


def fitted_sample_period(fitted: Fit, recording: Recording) -> float:
    """Time between the samples of a recording that a fit has seen, on average [s]."""
    lasts = float(recording.t[-1] - recording.t[0])
    return lasts / (np.count_nonzero(np.isfinite(fitted.residuals[recording.name])) - 1)


@dataclass(frozen=True, kw_only=True)
class _RecordedModelDifference:
    """The recordings at hand, and how the two models differ in them."""

    count: int
    seconds: float  # Together.
    now: float  # Rms difference of the models over range [1].
    noise: float  # What the model that is taken for true leaves, over range [1].
    memory: float  # Autocorrelation time of that [s].


def _is_distinguished_by_repeats(
    difference: Array, present: _RecordedModelDifference, times: int, criteria: SelectionCriteria
) -> bool:
    """Whether the search would distinguish them with the manoeuvre recorded so many times."""
    size = rmse_of(difference)
    noise = max(present.noise, 1e-12)
    errors = times * np.hypot(noise, size) + present.count * np.hypot(noise, present.now)
    gain = errors / (times + present.count) / noise - 1
    clear = _difference_in_standard_errors(difference, present, times, criteria.block) > criteria.clear
    return bool(size > criteria.resolution and gain > criteria.least_gain and clear)


def _difference_in_standard_errors(
    difference: Array, present: _RecordedModelDifference, times: int, block: float
) -> float:
    """Standard errors of the paired test over blocks [s] on all recordings; see `error_reduction`."""
    # With the residual e of the true model and e + d of the other, squares differ by 2 e d + d^2.
    size = round(block / SAMPLE_PERIOD)
    whole = difference[: difference.size // size * size].reshape(-1, size)
    squares = (whole**2).mean(axis=1)
    new, old = times * squares.size, present.seconds / block
    share = new / (new + old)
    mean = share * squares.mean() + (1 - share) * present.now**2
    spread = share * (squares**2).mean() + (1 - share) * present.now**4 - mean**2
    variance = spread + 4 * present.noise**2 * present.memory / block * mean
    return float(mean / np.sqrt(variance / (new + old))) if variance > 0 else 0.0


def _mean(figures: Iterable[float]) -> float:
    return float(np.mean(list(figures)))


def _extra_effect_names(one: Fit, other: Fit) -> str:
    """Names of the effects that one model has and the other lacks."""
    theirs = {effect.name for effect in other.model.effects}
    return ", ".join(e.name for e in one.model.effects if e.name not in theirs)


def _effects_in_words(effects: str) -> str:
    return effects.replace("_", " ").replace(",", " with") or "the model without it"
