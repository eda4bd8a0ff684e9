"""Close the loop: residual of the declared model, effects that it lacks, errors before and after."""

from collections.abc import Mapping, Sequence

import numpy as np

from identification.fitting import (
    Fit,
    Values,
    first_values,
    fit,
    signals_of,
    torque_range,
)
from identification.leftover import unexplained
from identification.recordings import Recording
from identification.results import Candidate, Diagnosis, Errors, Estimate, FoundEffect, Series
from identification.scoring import Array, delta_bic, deviations, rmse_of
from identification.selection import Progress, Step, search
from identification.trials import model_of
from symbolic import InvalidInputError, simulate
from symbolic.description import parameter_name

LEAST_TRAVEL = 0.01
"""Greatest minus least angle that a diagnosis needs [rad]."""


def diagnose(
    recordings: Sequence[Recording],
    holdout: Sequence[Recording] = (),
    *,
    jobs: int | None = None,
    progress: Progress | None = None,
) -> Diagnosis:
    """Find what the declared model lacks.

    Args:
        recordings: training recordings; shared parameters are fitted to these alone.
        holdout: recordings that judge. Every shared parameter stays frozen on them; only mu, torque
            zero and starting twist are refitted. Without any, training recordings are left out in turn.
        jobs: processes for the search; None for one per core.
        progress: called with (what is being done, trials done, trials in this step).

    Raises:
        InvalidInputError: no recording, a name stands twice, or a torque is constant.
    """
    everything = [*recordings, *holdout]
    _check(recordings, everything)
    declared = _declared(everything)
    steps = search(recordings, holdout, jobs=jobs, progress=progress)
    before, after = steps[0].before, steps[-1].before
    residuals_before = _all_residuals(before.fitted, before.held_out)
    residuals_after = _all_residuals(after.fitted, after.held_out)
    estimates = _estimates(after.fitted, recordings)
    if after.held_out is not None:
        estimates |= _estimates(after.held_out, holdout)
    stages = [
        _errors(residuals, recordings, holdout)
        for residuals in (declared, residuals_before, residuals_after)
    ]
    return Diagnosis(
        recordings=tuple(r.name for r in recordings),
        holdout=tuple(r.name for r in holdout),
        declared=stages[0],
        before=stages[1],
        after=stages[2],
        effects=_found(steps, estimates, recordings),
        candidates=tuple(
            Candidate(
                name=trial.effects[-1],
                summary=trial.fitted.model.effects[-1].summary,
                holdout_nrmse=trial.nrmse,
                delta_bic=delta_bic(trial.fitted, steps[0].ranked_before.fitted, recordings),
            )
            for trial in steps[0].tried
        ),
        unexplained=unexplained(residuals_after, everything),
        parameters=estimates,
        model=after.fitted.model,
        values=_all_values(after.fitted, after.held_out),
        series=_series(everything, holdout, residuals_before, residuals_after),
        notes=_notes(stages[1], stages[2], after.fitted),
    )


def _check(recordings: Sequence[Recording], everything: Sequence[Recording]) -> None:
    if not recordings:
        raise InvalidInputError("no recording given; at least one is needed")
    names = [r.name for r in everything]
    for name in names:
        if names.count(name) > 1:
            raise InvalidInputError(f"recording {name!r} is given twice; every recording counts once")
    for recording in everything:
        torque_range(recording)
        travel = float(np.ptp(recording.psi))
        if not travel > LEAST_TRAVEL:
            raise InvalidInputError(
                f"{recording.name}: the wheel turns by {travel:.2g} rad only; a diagnosis needs a"
                f" recording in which it turns by more than {LEAST_TRAVEL} rad"
            )


def _declared(recordings: Sequence[Recording]) -> dict[str, Array]:
    """Residuals of the declared model with k as given; mu as given, or fitted where none is."""
    residuals: dict[str, Array] = {}
    for recording in recordings:
        model = model_of(())
        if recording.tyre.mu is None:
            own = first_values(model, [recording]).own
            start = Values(shared={"k": recording.tyre.k}, own=own)
            residuals |= fit(model, [recording], start, free_shared=False).residuals
        else:
            values = {"mu": recording.tyre.mu, "k": recording.tyre.k}
            theta = np.asarray(model.theta(values)).ravel()
            geometry = np.array([recording.rig.a, recording.rig.e])
            made = simulate(model, signals_of(recording), theta, geometry, np.eye(theta.size))
            residuals[recording.name] = made.M_z - recording.M_z
    return residuals


def _all_residuals(fitted: Fit, held_out: Fit | None) -> dict[str, Array]:
    return {**fitted.residuals, **(held_out.residuals if held_out else {})}


def _all_values(fitted: Fit, held_out: Fit | None) -> Values:
    own = {**fitted.values.own, **(held_out.values.own if held_out else {})}
    return Values(shared=fitted.values.shared, own=own)


def _errors(
    residuals: Mapping[str, Array], recordings: Sequence[Recording], holdout: Sequence[Recording]
) -> Errors:
    everything = [*recordings, *holdout]
    rmse = {r.name: rmse_of(residuals[r.name]) for r in everything}
    return Errors(
        rmse=rmse,
        nrmse={r.name: rmse[r.name] / torque_range(r) for r in everything},
        training=tuple(r.name for r in recordings),
        holdout=tuple(r.name for r in holdout),
    )


def _estimates(fitted: Fit, recordings: Sequence[Recording]) -> dict[str, Estimate]:
    """Every fitted parameter with its deviation, in physical units."""
    parameters = {parameter_name(e, p): p for e, p in fitted.model.parameters}
    estimates = {}
    spread = deviations(fitted, recordings)
    for (recording, name), deviation in zip(fitted.labels, spread, strict=True):
        parameter = parameters[name]
        place = fitted.values.shared if recording is None else fitted.values.own[recording]
        value = place[name]
        if parameter.inverse:
            deviation = deviation * value**2
        std = float(deviation) if np.isfinite(deviation) else None
        label = name if recording is None else f"{name} [{recording}]"
        estimates[label] = Estimate(value=value, std=std, unit=parameter.unit)
    return estimates


def _found(
    steps: Sequence[Step], estimates: Mapping[str, Estimate], recordings: Sequence[Recording]
) -> tuple[FoundEffect, ...]:
    found = []
    for step in steps:
        # Effects that were dropped later are not among the estimates of the final model.
        if step.chosen is None or step.chosen.effects[-1] not in steps[-1].before.effects:
            continue
        effect = step.chosen.fitted.model.effects[-1]
        if effect.name in step.before.effects:
            continue
        prefix = f"{effect.name}."
        own = {k.removeprefix(prefix): e for k, e in estimates.items() if k.startswith(prefix)}
        found.append(
            FoundEffect(
                name=effect.name,
                summary=effect.summary,
                parameters=own,
                holdout_nrmse_after=step.chosen.nrmse,
                delta_bic=delta_bic(step.chosen.fitted, step.before.fitted, recordings),
                indistinguishable_from=step.indistinguishable,
            )
        )
    return tuple(found)


def _series(
    everything: Sequence[Recording],
    holdout: Sequence[Recording],
    before: Mapping[str, Array],
    after: Mapping[str, Array],
) -> tuple[Series, ...]:
    held = {r.name for r in holdout}
    return tuple(
        Series(
            name=r.name,
            held_out=r.name in held,
            t=r.t,
            psi=r.psi,
            F_N=r.F_N,
            measured=r.M_z,
            before=r.M_z + before[r.name],
            after=r.M_z + after[r.name],
        )
        for r in everything
    )


def _notes(before: Errors, after: Errors, fitted: Fit) -> tuple[str, ...]:
    """What got worse, and where the solver did not finish."""
    notes = [
        f"{name} got worse: {before.nrmse[name]:.2%} of range before, {after.nrmse[name]:.2%} after"
        for name in before.nrmse
        if after.nrmse[name] > before.nrmse[name]
    ]
    if not fitted.converged:
        notes.append(f"the final fit stopped early ({fitted.status}); more samples or bounds may help")
    return tuple(notes)
