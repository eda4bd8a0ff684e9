"""The result of a search: errors, effects with their parameters, unexplained structure."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.error_stages import (
    declared_friction,
    declared_residuals,
    declared_unrefitted,
    errors_of,
    trial_residuals,
)
from identification.experiments.proposals import Proposal
from identification.findings import Candidate, Errors, FoundEffect, Series
from identification.fits.covariance import standard_deviations
from identification.fits.fitting import Fit
from identification.fits.values import Values
from identification.grades import distance_from_neutral, grade_of
from identification.notes import notes_on, parameters_at_bounds
from identification.parameter_estimate import ParameterEstimate
from identification.prediction import unrefitted_residuals
from identification.reading.recordings import Recording
from identification.residuals.model_error import model_error
from identification.residuals.signatures import Signatures, signatures
from identification.residuals.unexplained import unexplained
from identification.results import Diagnosis
from identification.selection.criteria import (
    DEFAULT_CRITERIA,
    SelectionCriteria,
    advantage,
    delta_bic,
)
from identification.selection.search_step import SearchStep
from identification.selection.trial_runner import Effects
from identification.selection.trials import Trial
from symbolic import TOLERATED, Effect, ModelError, Scope, parameter_name, units_of

Array = NDArray[np.float64]
SCOPES: tuple[Scope, ...] = ("ground", "tyre", "recording")
"""An effect belongs to the first of these that one of its parameters belongs to."""


def build_diagnosis(
    steps: Sequence[SearchStep],
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    left_out: Sequence[Mapping[str, Array]],
    proposals: Mapping[Effects, Proposal],
    candidates: Sequence[Effect],
    criteria: SelectionCriteria,
) -> Diagnosis:
    """The result of a search.

    Args:
        steps: of the search, the last one with nothing chosen.
        training: recordings that the shared parameters were fitted to.
        holdout: recordings that judged, may be empty.
        left_out: residuals before and after of each training recording left out in turn, or empty.
        proposals: for a set of effects that was chosen, the experiment to distinguish it from its rival.
        candidates: the effects that the search could choose.
        criteria: its thresholds.
    """
    everything = [*training, *holdout]
    before, after = steps[0].before, steps[-1].before
    residuals, stages, unfitted = _errors_by_stage(before, after, training, holdout, left_out)
    followed = [_signatures(trial, everything, candidates) for trial in (before, after)]
    estimates = _estimates(after.fitted, training)
    if after.held_out is not None:
        estimates |= _estimates(after.held_out, holdout)
    return Diagnosis(
        recordings=tuple(r.name for r in training),
        holdout=tuple(r.name for r in holdout),
        declared=stages[0],
        before=stages[1],
        after=stages[2],
        effects=_found_effects(steps, estimates, training, proposals),
        candidates=_candidates(steps[0], training),
        unexplained=unexplained(residuals[2], everything, followed[1], after.fitted.loss),
        parameters=estimates,
        signatures_before=followed[0],
        signatures_after=followed[1],
        model=after.fitted.model,
        values=_all_values(after.fitted, after.held_out),
        series=_series(everything, holdout, residuals[1], residuals[2]),
        notes=notes_on(stages[1], stages[2], after.fitted),
        criteria=criteria,
        model_error_before=unfitted[0],
        model_error=unfitted[1],
    )


def _errors_by_stage(
    before: Trial,
    after: Trial,
    training: Sequence[Recording],
    holdout: Sequence[Recording],
    left_out: Sequence[Mapping[str, Array]],
) -> tuple[list[dict[str, Array]], list[Errors], list[ModelError | None]]:
    """Residuals [N m] and errors as declared, before and after; the model's error before and after."""
    everything, loss = [*training, *holdout], after.fitted.loss
    friction = declared_friction(everything, loss)
    residuals = [
        declared_residuals(everything, friction),
        trial_residuals(before),
        trial_residuals(after),
    ]
    unrefitted = [
        declared_unrefitted(friction, training, holdout),
        *(unrefitted_residuals(trial.fitted, training, holdout) for trial in (before, after)),
    ]
    stages = [
        errors_of(stage, training, holdout, unseen, own)
        for stage, unseen, own in zip(residuals, ({}, *left_out), unrefitted, strict=True)
    ]
    unfitted = [
        model_error(seen if holdout else unseen, holdout if holdout else training[: len(unseen)], loss)
        for seen, unseen in zip(residuals[1:], left_out, strict=True)
    ]
    return residuals, stages, unfitted


def _signatures(
    trial: Trial, recordings: Sequence[Recording], candidates: Sequence[Effect]
) -> Signatures:
    """Signals that the residuals of a trial follow."""
    fits = [trial.fitted, *([trial.held_out] if trial.held_out else [])]
    return signatures(trial_residuals(trial), recordings, fits, candidates)


def _candidates(first: SearchStep, recordings: Sequence[Recording]) -> tuple[Candidate, ...]:
    return tuple(
        Candidate(
            name=trial.effects[-1].name,
            summary=trial.effects[-1].summary,
            holdout_nrmse=trial.nrmse,
            delta_bic=delta_bic(trial.fitted, first.ranked_before.fitted, recordings),
        )
        for trial in first.trials
    )


def _all_values(fitted: Fit, held_out: Fit | None) -> Values:
    own, rig = dict(fitted.values.own), dict(fitted.values.rig)
    if held_out:
        own |= held_out.values.own
        rig |= held_out.values.rig
    return replace(fitted.values, own=own, rig=rig)


def _estimates(fitted: Fit, recordings: Sequence[Recording]) -> dict[str, ParameterEstimate]:
    """Every fitted parameter with its deviation, in physical units."""
    parameters = {parameter_name(e, p): p for e, p in fitted.model.parameters}
    units = units_of(fitted.model) | TOLERATED
    estimates = {}
    spread = standard_deviations(fitted, recordings)
    for (recording, name), deviation in zip(fitted.labels, spread, strict=True):
        value = fitted.values.at((recording, name))
        if name in parameters and parameters[name].inverse:
            deviation = deviation * value**2
        std = float(deviation) if np.isfinite(deviation) else None
        label = name if recording is None else f"{name} [{recording}]"
        estimates[label] = ParameterEstimate(value=value, std=std, unit=units[name])
    return estimates | {
        name: ParameterEstimate(value=fitted.values.tyre[name], std=None, unit=parameter.unit)
        for name, parameter in parameters.items()
        if parameter.fixed
    }


def _found_effects(
    steps: Sequence[SearchStep],
    estimates: Mapping[str, ParameterEstimate],
    recordings: Sequence[Recording],
    proposals: Mapping[Effects, Proposal],
) -> tuple[FoundEffect, ...]:
    effects = []
    for step in steps:
        if step.after is None:
            continue
        effect = step.after.effects[-1]
        # Effects that were dropped later are not among the estimates of the final model.
        if effect not in steps[-1].before.effects or effect in step.before.effects:
            continue
        final = steps[-1].before.fitted
        scope, own = _scope_and_parameters(effect, final, estimates)
        gain, error = advantage(step.after.judgement, step.before.judgement, DEFAULT_CRITERIA.long_block)
        bic = delta_bic(step.after.fitted, step.before.fitted, recordings)
        errors = gain / error if error > 0 else 0.0
        grade = grade_of(
            errors,
            bic,
            distance_from_neutral(effect, own),
            has_rivals=bool(step.indistinguishable),
            at_bound=effect.name in dict(parameters_at_bounds(final)),
        )
        effects.append(
            FoundEffect(
                name=effect.name,
                summary=effect.summary,
                scope=scope,
                parameters=own,
                holdout_nrmse_after=step.after.nrmse,
                delta_bic=bic,
                indistinguishable_from=tuple(other.name for other in step.indistinguishable),
                experiment=proposals.get(step.after.effects),
                grade=grade,
                standard_errors=errors,
                deviations=distance_from_neutral(effect, own),
            )
        )
    return tuple(effects)


def _scope_and_parameters(
    effect: Effect, fitted: Fit, estimates: Mapping[str, ParameterEstimate]
) -> tuple[Scope, dict[str, ParameterEstimate]]:
    """What an effect belongs to, and its parameters; those of others that it gave to each ground."""
    prefix, parameters = f"{effect.name}.", fitted.model.parameters
    own = {k.removeprefix(prefix): e for k, e in estimates.items() if k.startswith(prefix)}
    if own:
        scopes = {p.scope for owner, p in parameters if owner == effect}
        return next(s for s in SCOPES if s in scopes), own
    without = replace(fitted.model, effects=tuple(e for e in fitted.model.effects if e != effect))
    moved = {
        parameter_name(*after)
        for after, before in zip(parameters, without.parameters, strict=True)
        if after != before
    }
    return "ground", {k: e for k, e in estimates.items() if k.split(" ")[0] in moved}


def _series(
    everything: Sequence[Recording],
    holdout: Sequence[Recording],
    before: Mapping[str, Array],
    after: Mapping[str, Array],
) -> tuple[Series, ...]:
    held_out = {r.name for r in holdout}
    return tuple(
        Series(
            name=r.name,
            held_out=r.name in held_out,
            t=r.t,
            psi=r.psi,
            F_N=r.F_N,
            measured=r.M_z,
            before=r.M_z + before[r.name],
            after=r.M_z + after[r.name],
        )
        for r in everything
    )
