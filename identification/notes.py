"""Remarks on a diagnosis: recordings that got worse, parameters at their bounds, unfinished fits."""

import numpy as np

from identification.findings import Errors
from identification.fits.fitting import Fit
from symbolic import TOLERATED, parameter_name

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
    notes += _at_their_tolerances(fitted)
    if not fitted.converged:
        notes.append(f"the final fit stopped early ({fitted.status}); more samples or bounds may help")
    return tuple(notes)


def _at_their_bounds(fitted: Fit) -> list[str]:
    """Effects whose parameter ends where its range does; such an effect may stand in for another."""
    return [
        f"{effect}: {what}; the effect may stand in for one that is not in the library"
        for effect, what in parameters_at_bounds(fitted)
    ]


def parameters_at_bounds(fitted: Fit) -> list[tuple[str, str]]:
    """Effects of which a shared parameter ends where its range does, and which one."""
    found = []
    named = {parameter_name(effect, p): (effect, p) for effect, p in fitted.model.parameters}
    for (owner, name), own in zip(fitted.labels, fitted.own, strict=True):
        effect, parameter = named.get(name, (None, None))
        if effect is None or parameter is None or own:
            continue
        ends = [end for end in (parameter.lower, parameter.upper) if end != parameter.neutral]
        value = fitted.values.at((owner, name))
        near = [end for end in ends if abs(value - end) <= AT_BOUND * parameter.scale]
        unit = "" if parameter.unit == "1" else f" {parameter.unit}"
        ground = f" on {owner}" if owner else ""
        found += [
            (effect.name, f"{parameter.name}{ground} is at the end of its range, {end:g}{unit}")
            for end in near
        ]
    return found


def _at_their_tolerances(fitted: Fit) -> list[str]:
    """Recordings of which a declared value is off by all that its tolerance allows."""
    room = np.abs(fitted.bound_distances).min(axis=0)
    return [
        f"{owner}: {name} is at the end of its tolerance, {fitted.values.at((owner, name)):g}"
        f" {TOLERATED[name]}".removesuffix(" 1")
        for (owner, name), weight, least in zip(fitted.labels, fitted.prior_weights, room, strict=True)
        if weight > 0 and least <= AT_BOUND
    ]
