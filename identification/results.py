"""The result of a diagnosis: frozen values, and the content of `diagnosis.json`."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.experiments.proposals import Proposal
from identification.fits.values import Values
from identification.grades import Grade
from identification.parameter_estimate import ParameterEstimate
from identification.residuals.signatures import Signatures
from identification.residuals.unexplained import Unexplained
from identification.selection.criteria import DEFAULT_CRITERIA, SelectionCriteria
from symbolic import Model, ModelError, Scope

Array = NDArray[np.float64]


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
        unrefitted: root mean square torque error over range of each held-out recording of which nothing
            was fitted, see `identification.prediction`.
    """

    rmse: Mapping[str, float]
    nrmse: Mapping[str, float]
    training: tuple[str, ...]
    holdout: tuple[str, ...]
    left_out: Mapping[str, float] = field(default_factory=dict)
    unrefitted: Mapping[str, float] = field(default_factory=dict)

    def summary(self) -> dict[str, float | None]:
        """Averages for `diagnosis.json`; None without recordings to average over."""
        return {
            "left_out_torque_nrmse": _mean(self.left_out, tuple(self.left_out)),
            "torque_rmse": _mean(self.rmse, self.training),
            "torque_nrmse": _mean(self.nrmse, self.training),
            "holdout_torque_rmse": _mean(self.rmse, self.holdout),
            "holdout_torque_nrmse": _mean(self.nrmse, self.holdout),
            "holdout_torque_nrmse_unrefitted": _mean(self.unrefitted, tuple(self.unrefitted)),
        }


@dataclass(frozen=True, kw_only=True)
class FoundEffect:
    """An effect that the search added.

    Attributes:
        name: of the effect.
        summary: the effect in plain words.
        parameters: its parameters; one that belongs to a recording has a name like "M_0 [fem1]", one
            that is given and never fitted has no deviation.
        holdout_nrmse_after: judged error once it was added [1].
        delta_bic: change of the Bayesian information criterion by its addition; negative is better.
        indistinguishable_from: effects that the judged data cannot distinguish from it.
        scope: what its parameters belong to; "ground" where each ground has its own.
        grade: how sure it is, see `identification.grades`.
        standard_errors: by how many the judged error fell when it was added; None where that is unknown.
        deviations: between its clearest parameter and no effect at all; None where there is none.
        experiment: the manoeuvre that would distinguish it from the nearest of those; None without any.
    """

    name: str
    summary: str
    parameters: Mapping[str, ParameterEstimate]
    holdout_nrmse_after: float
    delta_bic: float
    indistinguishable_from: tuple[str, ...]
    experiment: Proposal | None = None
    scope: Scope = "tyre"
    grade: Grade = "strong"
    standard_errors: float | None = None
    deviations: float | None = None


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """An effect tried alone on top of the declared structure, in the first step of the search."""

    name: str
    summary: str
    holdout_nrmse: float
    delta_bic: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """One recording beside the models, for pictures; arrays of shape (n,).

    Attributes:
        name: the recording.
        held_out: True where shared parameters are not fitted to it.
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
        unexplained: whether the final residual has structure.
        parameters: every parameter of the final model; own ones as "mu [fem1]".
        signatures_before: signals that the residual of the declared structure follows.
        signatures_after: signals that the final residual follows.
        model: the final model.
        values: its values.
        series: every recording with its curves.
        notes: sentences for the report, such as recordings that got worse.
        criteria: thresholds of the search.
        model_error_before: how wrong the declared structure is on recordings that no shared parameter
            was fitted to, held out or left out in turn; None where there is no such recording.
        model_error: the same of the final model.
    """

    recordings: tuple[str, ...]
    holdout: tuple[str, ...]
    declared: Errors
    before: Errors
    after: Errors
    effects: tuple[FoundEffect, ...]
    candidates: tuple[Candidate, ...]
    unexplained: Unexplained
    parameters: Mapping[str, ParameterEstimate]
    signatures_before: Signatures
    signatures_after: Signatures
    model: Model
    values: Values
    series: tuple[Series, ...]
    notes: tuple[str, ...] = ()
    criteria: SelectionCriteria = DEFAULT_CRITERIA
    model_error_before: ModelError | None = None
    model_error: ModelError | None = None

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
                    "torque_nrmse_unrefitted": dict(errors.unrefitted),
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
                    "scope": effect.scope,
                    "grade": effect.grade,
                    "standard_errors": effect.standard_errors,
                    "deviations": effect.deviations,
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
            "model_error": _model_error(self.model_error, self.model_error_before),
            "notes": list(self.notes),
        }


def _mean(figures: Mapping[str, float], names: tuple[str, ...]) -> float | None:
    return float(np.mean([figures[name] for name in names])) if names else None


def _estimate(estimate: ParameterEstimate) -> dict[str, Any]:
    return {"value": estimate.value, "std": estimate.std, "unit": estimate.unit}


def _model_error(after: ModelError | None, before: ModelError | None) -> dict[str, Any] | None:
    if after is None:
        return None
    return {**asdict(after), "before": None if before is None else asdict(before)}


def _experiment(proposal: Proposal | None) -> dict[str, Any] | None:
    if proposal is None:
        return None
    return {
        "rival": proposal.rival,
        "sentence": proposal.sentence,
        "separation": proposal.separation,
        "feasible": proposal.times is not None,
        "times": proposal.times,
        "standard_errors": proposal.standard_errors,
    }
