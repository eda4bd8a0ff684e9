"""Residuals of every recording had it not been fitted, from one fit of all, to first order."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from identification.fits.fitting import Fit
from identification.fits.least_squares_problem import shares_of_torque_range, torque_range
from identification.fits.single_threaded_blas import one_thread
from identification.fits.values_by_ground_and_recording import ground_of
from identification.reading.recordings import Recording
from symbolic import parameter_name
from symbolic.float_array_type import Array

Mask = NDArray[np.bool_]


@one_thread
def leave_one_out(fitted: Fit, recordings: Sequence[Recording]) -> dict[str, Array]:
    """Residuals of every recording had it not been fitted, to first order of the parameters [N m].

    The shared parameters move by the Gauss-Newton step of the other recordings alone, as far as their
    ranges allow; those of a ground without another recording move to the mean of the other grounds. Then
    what belongs to the recording is refitted. In this refit a declared value may leave its tolerance.
    The other recordings hardly determine the common scale of all lengths, and this recording should not
    be penalised for that. A single recording keeps its residuals.
    """
    if len(recordings) < 2:
        return dict(fitted.residuals)
    owners = np.array([owner or "" for owner, _ in fitted.labels])
    grounds = [ground_of(recording) for recording in recordings]
    shared = ~np.array(fitted.recording_columns)
    relative = shares_of_torque_range(fitted.residuals, recordings)
    present = {name: np.isfinite(share) for name, share in relative.items()}
    stacked = np.concatenate([share[present[name]] for name, share in relative.items()])
    # The recording of each row.
    recorded = np.repeat(list(present), [int(mask.sum()) for mask in present.values()])
    # An outlier pulls as little as the loss lets it: rows weighted as in reweighted least squares.
    weight = np.sqrt(fitted.loss(stacked**2)[1])
    jacobian = fitted.jacobian * weight[:, None]
    beyond = np.where(fitted.prior_weights > 0, np.inf, 0.0)
    unbounded = replace(fitted, bound_distances=fitted.bound_distances + np.array([-beyond, beyond]))
    residuals: dict[str, Array] = {}
    for recording in recordings:
        name = recording.name
        rows, own = recorded == name, owners == name
        # Columns of a ground on which no other recording stands.
        alone = (owners == (ground := ground_of(recording))) & (grounds.count(ground) == 1)
        step = np.zeros(owners.size)
        others = ~(own | alone)
        step[others] = _bounded_step(fitted, jacobian[~rows], -(weight * stacked)[~rows], others)
        _step_to_mean_of_grounds(step, alone, fitted)
        left = stacked[rows] + fitted.jacobian[rows][:, shared] @ step[shared]
        refit = _bounded_step(unbounded, jacobian[rows], -weight[rows] * left, own)
        residuals[name] = np.full(present[name].size, np.nan)
        residuals[name][present[name]] = left + fitted.jacobian[rows][:, own] @ refit
        residuals[name] *= torque_range(recording)
    return residuals


def _step_to_mean_of_grounds(step: Array, alone: Mask, fitted: Fit) -> None:
    """Steps of a ground's columns to the mean of the other grounds' coordinates, where those will be."""
    parameters = {parameter_name(effect, p): p for effect, p in fitted.model.parameters}

    def coordinate(i: int) -> float:
        label = fitted.labels[i]
        return parameters[label[1]].to_coordinate(fitted.values.at(label)) / float(fitted.scales[i])

    for i in np.flatnonzero(alone).tolist():
        name = fitted.labels[i][1]
        others = [j for j, (_, other) in enumerate(fitted.labels) if other == name and not alone[j]]
        step[i] = np.mean([coordinate(j) + step[j] for j in others]) - coordinate(i)


def _bounded_step(fitted: Fit, matrix: Array, target: Array, columns: Mask) -> Array:
    """Least squares in some columns, within bounds; a declared tolerance counts as in the fit."""
    weights = fitted.prior_weights[columns]
    known = weights > 0
    matrix = np.concatenate([matrix[:, columns], np.diag(weights)[known]])
    target = np.concatenate([target, -(weights * fitted.prior_steps[columns])[known]])
    step = np.zeros(matrix.shape[1])
    free = np.ones(step.size, dtype=bool)
    while free.any():  # Components that reach their bounds are fixed there (active set).
        step[free] = _least_squares(matrix[:, free], target - matrix[:, ~free] @ step[~free])
        clipped = np.clip(step, *fitted.bound_distances[:, columns])
        free &= clipped == step
        if np.array_equal(clipped, step):
            break
        step = clipped
    return step


def _least_squares(matrix: Array, target: Array) -> Array:
    """Least squares; directions that the data do not determine stay zero."""
    size = np.sqrt((matrix**2).sum(axis=0))
    known = size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)
    solution = np.zeros(matrix.shape[1])
    scaled = matrix[:, known] / size[known]
    solution[known] = np.linalg.lstsq(scaled, target, rcond=1e-8)[0] / size[known]
    return solution
