"""What a diagnosis says: frozen results, and the dictionary that `diagnosis.json` holds."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.experiments.proposals import Proposal
from identification.fits.fitting import Values
from identification.residuals.signatures import Signatures
from symbolic import Model

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A parameter's value with its standard deviation and unit; std is None where it was not fitted."""

    value: float
    std: float | None
    unit: str


@dataclass(frozen=True, kw_only=True)
class Errors:
    """Free-run torque errors of one stage of the model.

    Attributes:
        rmse: root mean square torque error of each recording [N m].
        nrmse: the same over the recording's torque range [1].
        training: names over which the training figures are averaged.
        holdout: names over which the held-out figures are averaged.
        left_out: root mean square torque error over range of each recording by the shared parameters of
            the others, fitted anew without it; empty where recordings are held out or there is only one.
    """

    rmse: Mapping[str, float]
    nrmse: Mapping[str, float]
    training: tuple[str, ...]
    holdout: tuple[str, ...]
    left_out: Mapping[str, float] = field(default_factory=dict)

    def summary(self) -> dict[str, float | None]:
        """The figures of `diagnosis.json`; None where there is none."""
        return {
            "left_out_torque_nrmse": _mean(self.left_out, tuple(self.left_out)),
            "torque_rmse": _mean(self.rmse, self.training),
            "torque_nrmse": _mean(self.nrmse, self.training),
            "holdout_torque_rmse": _mean(self.rmse, self.holdout),
            "holdout_torque_nrmse": _mean(self.nrmse, self.holdout),
        }


@dataclass(frozen=True, kw_only=True)
class FoundEffect:
    """An effect that the search added.

    Attributes:
        name: the effect.
        summary: it in plain words.
        parameters: its parameters; a parameter that belongs to recordings stands as "M_0 [fem1]", one
            that is given and never fitted has no deviation.
        holdout_nrmse_after: judged error once it was added [1].
        delta_bic: change of the Bayesian information criterion as it was added; negative is better.
        indistinguishable_from: effects that the judged data cannot tell from it.
        experiment: what to steer to tell it from the nearest of those; None where there is none.
    """

    name: str
    summary: str
    parameters: Mapping[str, Estimate]
    holdout_nrmse_after: float
    delta_bic: float
    indistinguishable_from: tuple[str, ...]
    experiment: Proposal | None = None


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """An effect tried alone on top of the declared structure, in the first step of the search."""

    name: str
    summary: str
    holdout_nrmse: float
    delta_bic: float


@dataclass(frozen=True, kw_only=True)
class Unexplained:
    """Whether structure is left in the residual, and what shows it, in plain words."""

    present: bool
    evidence: str


@dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """One recording beside the models, for pictures; arrays of shape (n,).

    Attributes:
        name: the recording.
        held_out: True where its torque did not help to find shared parameters.
        t: time [s].
        psi: yaw angle [rad].
        F_N: vertical load [N].
        measured: measured aligning torque [N m], NaN where missing.
        before: torque of the declared structure, refitted [N m].
        after: torque with the effects found, refitted [N m].
    """

    name: str
    held_out: bool
    t: Array
    psi: Array
    F_N: Array
    measured: Array
    before: Array
    after: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagnosis:
    """The whole result of `diagnose`.

    Attributes:
        recordings: names of the training recordings.
        holdout: names of the held-out recordings.
        declared: errors with nominal parameters as given (mu fitted where none is declared).
        before: errors of the declared structure, no effect at all, refitted.
        after: errors with the effects, refitted.
        effects: what was found, in order of selection; empty if nothing is missing.
        candidates: every candidate's first step, best first.
        unexplained: what is left.
        parameters: every parameter of the final model; own ones as "mu [fem1]".
        signatures_before: what the residual follows before any effect is tried.
        signatures_after: what is left of that.
        model: the final model.
        values: its values.
        series: every recording with its curves.
        notes: sentences that the report should say, such as recordings that got worse.
    """

    recordings: tuple[str, ...]
    holdout: tuple[str, ...]
    declared: Errors
    before: Errors
    after: Errors
    effects: tuple[FoundEffect, ...]
    candidates: tuple[Candidate, ...]
    unexplained: Unexplained
    parameters: Mapping[str, Estimate]
    signatures_before: Signatures
    signatures_after: Signatures
    model: Model
    values: Values
    series: tuple[Series, ...]
    notes: tuple[str, ...] = ()

    def to_dict(self) -> dict[str, Any]:
        """The content of `diagnosis.json`."""
        return {
            "recordings": list(self.recordings),
            "holdout": list(self.holdout),
            "declared": self.declared.summary(),
            "before": self.before.summary(),
            "after": self.after.summary(),
            "per_recording": {
                stage: {
                    "torque_rmse": dict(errors.rmse),
                    "torque_nrmse": dict(errors.nrmse),
                    "left_out_torque_nrmse": dict(errors.left_out),
                }
                for stage, errors in (
                    ("declared", self.declared),
                    ("before", self.before),
                    ("after", self.after),
                )
            },
            "residual": {
                "before": self.signatures_before.to_dict(),
                "after": self.signatures_after.to_dict(),
            },
            "effects": [
                {
                    "name": effect.name,
                    "parameters": {p: _estimate(e) for p, e in effect.parameters.items()},
                    "holdout_nrmse_after": effect.holdout_nrmse_after,
                    "delta_bic": effect.delta_bic,
                    "indistinguishable_from": list(effect.indistinguishable_from),
                    "experiment": _experiment(effect.experiment),
                }
                for effect in self.effects
            ],
            "candidates": [
                {"name": c.name, "holdout_nrmse": c.holdout_nrmse, "delta_bic": c.delta_bic}
                for c in self.candidates
            ],
            "unexplained": {
                "present": self.unexplained.present,
                "evidence": self.unexplained.evidence,
            },
            "parameters": {name: _estimate(e) for name, e in self.parameters.items()},
            "notes": list(self.notes),
        }


def _mean(figures: Mapping[str, float], names: tuple[str, ...]) -> float | None:
    return float(np.mean([figures[name] for name in names])) if names else None


def _estimate(estimate: Estimate) -> dict[str, Any]:
    return {"value": estimate.value, "std": estimate.std, "unit": estimate.unit}


def _experiment(proposal: Proposal | None) -> dict[str, Any] | None:
    if proposal is None:
        return None
    return {
        "rival": proposal.rival,
        "sentence": proposal.sentence,
        "separation": proposal.separation,
        "times": proposal.times,
        "standard_errors": proposal.standard_errors,
    }
