"""A learned torque for what no known effect explains: offered last, kept only where it holds elsewhere.

The physics keeps its parameters, so that nothing of it is swallowed. How many units and how much weight
decay is chosen by leaving training recordings out; recordings that are held out take no part in that and
judge the result alone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.error_stages import errors_of
from identification.fits.fitting import Fit
from identification.fits.loss import rmse_of
from identification.learned.network import (
    SAMPLES,
    Array,
    NetworkFit,
    TrainingData,
    material_of,
    torque_of,
)
from identification.reading.recordings import Recording
from identification.results import Learned
from identification.selection.criteria import DEFAULT_CRITERIA, error_falls
from identification.selection.trials import Judgement, judge, leave_one_out
from symbolic import LearnedTorque, full_slide_torque
from symbolic.effects.learned import weights_needed

UNITS = (4, 8)
"""Numbers of tanh units that are tried."""
DECAYS = (1e-1, 1e-2, 1e-3)
"""Weight decays that are tried; the first leaves little of the network."""
HEADROOM = 1.5
"""Greatest learned torque, in shares of the greatest that is missing from the recordings [1]."""
LEAST_BOUND = 1e-3
"""Where less is missing, the learned torque may still go this far [1]."""
STRETCHES = 4
"""Stretches of time into which a recording is cut that has no other beside it."""


def learn(
    fitted: Fit,
    held_out: Fit | None,
    training: Sequence[Recording],
    holdout: Sequence[Recording] = (),
) -> Learned:
    """Train a torque on what a fitted model leaves, and say whether it is worth keeping.

    Args:
        fitted: the model fitted to the training recordings.
        held_out: the same model on the held-out recordings, shared parameters as in `fitted`; None
            without any.
        training: recordings to learn from.
        holdout: recordings that judge. Without any, training recordings left out in turn do; a single
            recording alone judges nothing, so nothing is kept.
    """
    blank = _blank(fitted, training)
    lessons = [material_of(fitted, recording, blank) for recording in training]
    tests = [material_of(held_out, recording, blank) for recording in holdout] if held_out else []
    unseen = leave_one_out(fitted, training)
    choice = _chosen(blank, _parts(lessons, unseen))
    effect = _trained(blank, lessons, choice)
    before = {**fitted.residuals, **(held_out.residuals if held_out else {})}
    after = {m.name: before[m.name] + torque_of(effect, m) for m in (*lessons, *tests)}
    stages = [errors_of(residuals, training, holdout) for residuals in (before, after)]
    if tests:
        falls, verdict = _falls(judge(after, holdout), judge(before, holdout), "held-out")
    elif len(training) > 1:
        after_unseen, before_unseen = judge(choice.residuals, training), judge(unseen, training)
        falls, verdict = _falls(after_unseen, before_unseen, "left-out")
    else:
        falls, verdict = False, "a single recording alone cannot judge it"
    kept = falls and choice.after < (1 - DEFAULT_CRITERIA.least_gain) * choice.before
    return Learned(
        effect=effect,
        model=replace(fitted.model, effects=(*fitted.model.effects, effect)) if kept else fitted.model,
        before=stages[0],
        after=stages[1],
        left_out=(choice.before, choice.after),
        residuals=after,
        decay=choice.decay,
        kept=kept,
        note=_note(kept, verdict, choice),
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class _Part:
    """What is left out in turn: its material, and its residual had the physics not seen it [N m]."""

    material: TrainingData
    unseen: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class _Choice:
    """Units and weight decay, with the errors over range of left-out parts before and after."""

    units: int
    decay: float
    before: float
    after: float
    residuals: Mapping[str, Array]


def _blank(fitted: Fit, training: Sequence[Recording]) -> LearnedTorque:
    """A learned torque of no weight, with the sizes that these recordings ask for."""
    shares = [
        fitted.residuals[r.name] / full_slide_torque(float(np.median(r.F_N)), r.rig.a) for r in training
    ]
    missing = float(np.nanquantile(np.abs(np.concatenate(shares)), 0.99))
    return LearnedTorque(
        angle=float(np.std(np.concatenate([r.psi for r in training]))),
        bound=max(HEADROOM * missing, LEAST_BOUND),
        units=1,
        weights=(0.0,) * weights_needed(1),
    )


def _parts(lessons: Sequence[TrainingData], unseen: Mapping[str, Array]) -> list[_Part]:
    if len(lessons) > 1:
        return [_Part(material=m, unseen=unseen[m.name]) for m in lessons]
    (only,) = lessons
    stretches = np.array_split(np.arange(only.slide.size), STRETCHES)
    return [_Part(material=only.at(s), unseen=unseen[only.name][s]) for s in stretches]


def _chosen(blank: LearnedTorque, parts: Sequence[_Part]) -> _Choice:
    """The units and the decay that do best on parts that were left out, each in turn."""
    before = _mean([(part.unseen, part.material) for part in parts])
    choices = []
    for units in UNITS:
        for decay in DECAYS:
            tried = _Choice(units=units, decay=decay, before=before, after=before, residuals={})
            left = []
            for part in parts:
                others = [other.material for other in parts if other is not part]
                effect = _trained(blank, others, tried)
                left.append((part.unseen + torque_of(effect, part.material), part.material))
            residuals = {material.name: residual for residual, material in left}
            choices.append(replace(tried, after=_mean(left), residuals=residuals))
    return min(choices, key=lambda choice: choice.after)


def _mean(left: Sequence[tuple[Array, TrainingData]]) -> float:
    return float(np.mean([rmse_of(residual) / material.span for residual, material in left]))


def _trained(blank: LearnedTorque, material: Sequence[TrainingData], choice: _Choice) -> LearnedTorque:
    stride = max(1, sum(m.slide.size for m in material) // SAMPLES)
    lesson = NetworkFit([m.every(stride) for m in material], choice.units, blank.bound)
    weights = tuple(lesson.learned(choice.decay).tolist())
    return replace(blank, units=choice.units, weights=weights)


def _falls(after: Judgement, before: Judgement, kind: str) -> tuple[bool, str]:
    """Whether the judged error falls by a clear margin, and both errors in words."""
    said = f"{kind} error {before.nrmse:.2%} of range before, {after.nrmse:.2%} after"
    return error_falls(after, before, DEFAULT_CRITERIA), said


def _note(kept: bool, verdict: str, choice: _Choice) -> str:
    if kept:
        return (
            f"a torque was learned that no known effect explains ({choice.units} tanh units): {verdict};"
            " it is learned, not physics, and says nothing about a cause"
        )
    return (
        f"a learned torque ({choice.units} tanh units) was tried and not kept, as it does not hold on"
        f" recordings that it was not trained on: {verdict}; recordings left out of the training in"
        f" turn {choice.before:.2%} before, {choice.after:.2%} after"
    )
