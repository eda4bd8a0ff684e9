"""The diagnosis that a search comes to."""

from collections.abc import Mapping, Sequence

import numpy as np

from identification.diagnosis.found_vs_declared_stiffness import (
    compare_fitted_stiffness,
    farthest_stiffness_ratio,
)
from identification.diagnosis.graded_effects import (
    final_model_notes,
    found_effects,
    inclination_note_of_effect,
)
from identification.diagnosis.mechanisms_of_final_model import families_with_curves
from identification.diagnosis.result import Diagnosis
from identification.diagnosis.result_parts import Candidate, FoundEffect, Series, TorqueErrors
from identification.diagnosis.stand_ins_for_unknown_cause import stand_in_effect_names
from identification.diagnosis.torque_errors_by_stage import torque_and_model_errors
from identification.experiments.model_separation import Proposal
from identification.fits.covariance import standard_deviations
from identification.fits.fitting import Fit, parameters_at_bounds
from identification.fits.least_squares_problem import signals_of
from identification.fits.values_by_ground_and_recording import (
    UNNAMED_GROUND,
    ParameterEstimate,
    Values,
    replaced_rig,
)
from identification.reading.declared_sensor_range import counts_beyond_range, max_measurable_friction
from identification.reading.recordings import Recording
from identification.residuals.full_slide_repeatability import repeatability
from identification.residuals.partial_correlations import Signatures
from identification.residuals.residual_structure import find_residual_structure
from identification.selection.criteria import delta_bic
from identification.selection.search_step import SearchStep
from identification.selection.stepwise_search import Search
from identification.selection.trial import Trial
from identification.selection.trial_runner import Effects
from symbolic import TOLERATED, Effect, Model, parameter_name, units_of
from symbolic.float_array_type import Array
from symbolic.trajectory_sensitivity import final_full_slide_memory


def build_diagnosis(
    search: Search,
    steps: Sequence[SearchStep],
    rests: Mapping[Effect, Trial],
    declared: TorqueErrors,
    followed: Sequence[Signatures],
    left_out: Sequence[Mapping[str, Array]],
    proposals: Mapping[Effects, Proposal],
) -> Diagnosis:
    """The result of a search whose last step chose nothing.

    `rests` are the final model without each of its effects; `followed` and `left_out` (residuals of each
    training recording left out in turn, or nothing) are those before and after; `proposals` are by the
    set of effects that was chosen.
    """
    training, holdout = search.runner.training, search.runner.holdout
    everything = [*training, *holdout]
    before, after = steps[0].before, steps[-1].before
    fitted = after.fitted
    errors_before, error_before = torque_and_model_errors(before, training, holdout, left_out[0])
    errors_after, error_after = torque_and_model_errors(after, training, holdout, left_out[1])
    values = _values_with_tare_added(fitted.model, after.values, everything)
    estimates = _estimates(after, values, training, holdout)
    left = find_residual_structure(after.residuals, everything, followed[1], fitted.loss)
    standing_in = stand_in_effect_names(steps, rests, everything, left)
    effects = found_effects(steps, rests, estimates, training, proposals, standing_in)
    kingpins = [inclination_note_of_effect(effect, fitted, training)[1] for effect in effects]
    return Diagnosis(
        recordings=tuple(r.name for r in training),
        holdout=tuple(r.name for r in holdout),
        declared=declared,
        before=errors_before,
        after=errors_after,
        effects=effects,
        families=families_with_curves(effects, fitted, training),
        candidates=_candidates(steps[0], training),
        unexplained=left,
        parameters=estimates,
        signatures_before=followed[0],
        signatures_after=followed[1],
        model=fitted.model,
        values=values,
        series=_series(before, after, everything, holdout),
        notes=final_model_notes(
            errors_before, errors_after, fitted, training, after.fits[1:], effects, estimates
        ),
        criteria=search.criteria,
        inclination=next((one for one in kingpins if one is not None), None),
        stiffness_ratio=farthest_stiffness_ratio(fitted, training),
        stiffness=compare_fitted_stiffness(fitted, training),
        repeatability=repeatability(everything, fitted.values.tyre["k"]),
        model_error_before=error_before,
        model_error=error_after,
        without_stand_ins=_model_without_stand_ins(
            [*rests.values(), *(s.before for s in steps)], effects
        ),
    )


def _model_without_stand_ins(
    trials: Sequence[Trial], effects: Sequence[FoundEffect]
) -> tuple[Model, Values] | None:
    """The model of all effects but the stand-ins, with its values, if it is among these."""
    kept = {effect.name for effect in effects if effect.grade != "stands_in"}
    if len(kept) == len(effects):
        return None
    alike = (trial for trial in trials if {effect.name for effect in trial.effects} == kept)
    return next(((trial.fitted.model, trial.values) for trial in alike), None)


BEYOND_RANGE = "full slide is beyond the range of the torque's sensor"
"""How the note on it begins."""


def note_slide_beyond_sensor(
    model: Model, values: Values, recordings: Sequence[Recording]
) -> tuple[str, ...]:
    """Note on recordings, as read, whose full slide is beyond the range of the torque's sensor, if any.

    What was fitted as their friction rests on the torque below full slide, and so on the model. A lower
    bound is measured only where the torque reached the range.
    """
    least = []
    for recording in (r for r in recordings if counts_beyond_range(r)[0]):
        found = replaced_rig(recording, values)
        rig, load = found.rig, float(np.median(found.F_N[found.F_N > 0]))
        theta = np.asarray(model.theta(values.of(recording))).ravel()
        memory = final_full_slide_memory(model, signals_of(found), theta)
        _, torque = model.full_slide(memory, load, theta, [rig.a, rig.e], rig.slide_rate)
        if abs(float(torque)) >= rig.sensor_torque_limit:
            least.append(f"{recording.name} {max_measurable_friction(recording):.2f} or more")
    told = f"{BEYOND_RANGE}, so that friction is inferred from the model's curve below it"
    return (f"{told}; measured is only {', '.join(least)}",) if least else ()


def _candidates(first: SearchStep, recordings: Sequence[Recording]) -> tuple[Candidate, ...]:
    return tuple(
        Candidate(
            name=(name := trial.effects[-1].name),
            summary=trial.effects[-1].summary,
            holdout_nrmse=trial.nrmse,
            delta_bic=delta_bic(trial.fitted, first.coarse_before.fitted, recordings),
            parameters={
                label.removeprefix(f"{name}."): estimate
                for label, estimate in _fitted_estimates(trial.fitted, recordings, shared=True).items()
                if label.startswith(f"{name}.")
            },
            at_bound=tuple(p for one, p, _ in parameters_at_bounds(trial.fitted) if one == name),
        )
        for trial in first.trials
    )


def _values_with_tare_added(model: Model, values: Values, recordings: Sequence[Recording]) -> Values:
    """The values with what a taring took off, which `simulate` does without, see `Effect.tare`.

    It is what the model bears at the first sample, the mean over these recordings [N m].
    """
    name = next((f"{effect.name}.{effect.tare}" for effect in model.effects if effect.tare), None)
    if name is None:
        return values
    torques = []
    for recording in (replaced_rig(r, values) for r in recordings):
        first, theta = signals_of(recording)[:, 0], model.theta(values.of(recording))
        geometry = [recording.rig.a, recording.rig.e]
        memory = model.initial(first, theta, geometry)
        torques.append(float(model.step(memory, first, theta, geometry)[1]))
    return values.having({(None, name): values.tyre[name] - float(np.mean(torques))})


def _estimates(
    trial: Trial, values: Values, training: Sequence[Recording], holdout: Sequence[Recording]
) -> dict[str, ParameterEstimate]:
    """Every parameter in physical units; one that was fitted with its deviation."""
    estimates: dict[str, ParameterEstimate] = {}
    for fitted, recordings in zip(trial.fits, (training, holdout), strict=False):
        estimates |= _fitted_estimates(fitted, recordings)
    return estimates | {
        parameter_name(effect, parameter): ParameterEstimate(
            value=values.tyre[parameter_name(effect, parameter)], std=None, unit=parameter.unit
        )
        for effect, parameter in trial.fitted.model.parameters
        if parameter.fixed
    }


def _fitted_estimates(
    fitted: Fit, recordings: Sequence[Recording], *, shared: bool = False
) -> dict[str, ParameterEstimate]:
    """What a fit found, physical units; own values of recordings, none if `shared`, as `mu [fem1]`."""
    parameters = {parameter_name(e, p): p for e, p in fitted.model.parameters}
    units, estimates = units_of(fitted.model) | TOLERATED, {}
    spread = standard_deviations(fitted, recordings)
    nameless = {None, UNNAMED_GROUND} if len(fitted.values.grounds) == 1 else {None}
    for (owner, name), deviation, own in zip(
        fitted.labels, spread, fitted.recording_columns, strict=True
    ):
        if shared and own:
            continue
        value = fitted.values.at((owner, name))
        if name in parameters and parameters[name].inverse:
            deviation = deviation * value**2
        std = float(deviation) if np.isfinite(deviation) else None
        label = name if owner in nameless else f"{name} [{owner}]"
        estimates[label] = ParameterEstimate(value=value, std=std, unit=units.get(name, "1"))
    return estimates


def _series(
    before: Trial, after: Trial, everything: Sequence[Recording], holdout: Sequence[Recording]
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
            before=r.M_z + before.residuals[r.name],
            after=r.M_z + after.residuals[r.name],
        )
        for r in everything
    )
