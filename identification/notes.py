"""Remarks on a diagnosis: recordings that got worse, parameters at their bounds, unfinished fits."""

from identification.fits.fitting import Fit
from identification.results import Errors
from symbolic import parameter_name

AT_BOUND = 1e-3
"""A parameter is at a bound within this share of its scale [1]."""


def notes_on(before: Errors, after: Errors, fitted: Fit) -> tuple[str, ...]:
    """Remarks on the final model of a diagnosis.

    Args:
        before: errors of the declared structure.
        after: errors of the final model.
        fitted: the final model on the training recordings.

    Returns:
        Sentences without a full stop: recordings that got worse, parameters at the end of their range,
        a fit that did not converge.
    """
    notes = [
        f"{name} got worse: {before.nrmse[name]:.2%} of range before, {after.nrmse[name]:.2%} after"
        for name in before.nrmse
        if after.nrmse[name] > before.nrmse[name]
    ]
    notes += [
        f"{name} got worse when left out: {before.left_out[name]:.2%} of range before,"
        f" {after.left_out[name]:.2%} after"
        for name in before.left_out
        if after.left_out[name] > before.left_out[name]
    ]
    notes += _at_their_bounds(fitted)
    if not fitted.converged:
        notes.append(f"the final fit stopped early ({fitted.status}); more samples or bounds may help")
    return tuple(notes)


def _at_their_bounds(fitted: Fit) -> list[str]:
    """Effects whose parameter ends where its range does; such an effect may stand in for another."""
    notes = []
    for effect, parameter in fitted.model.parameters:
        value = fitted.values.shared.get(parameter_name(effect, parameter))
        if effect is None or value is None:
            continue
        ends = [end for end in (parameter.lower, parameter.upper) if end != parameter.neutral]
        near = [end for end in ends if abs(value - end) <= AT_BOUND * parameter.scale]
        unit = "" if parameter.unit == "1" else f" {parameter.unit}"
        notes += [
            f"{effect.name}: {parameter.name} is at the end of its range, {end:g}{unit};"
            " the effect may stand in for one that is not in the library"
            for end in near
        ]
    return notes
