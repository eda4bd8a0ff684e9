"""Recordings predicted with nothing of their own fitted: friction comes from their ground.

On one ground ln mu of recordings is taken as a line over ln F_N with scatter about it. A slope of the
size that contact mechanics allows is expected before anything is measured: mu falls with the load to the
power of 1/3 for a smooth elastic contact (Hertz), by nothing for a rough one. Few recordings leave the
slope near zero, many determine it: it is the mean of its posterior in a linear regression with known
scatter (Gelman and others, Bayesian Data Analysis, 3rd ed., section 14.8).
"""

from collections.abc import Mapping, Sequence

import numpy as np

from identification.fits.fitting import Fit
from identification.fits.least_squares_problem import signals_of
from identification.fits.values_by_ground_and_recording import Values, complete_values, ground_of
from identification.reading.recordings import Recording
from symbolic import RIG_DIRECTIONS, Model, parameter_name, simulate
from symbolic.float_array_type import Array

SCATTER = 0.05
"""Standard deviation of ln mu between recordings of one ground and load [1]."""
SLOPE = 1 / 3
"""Standard deviation of the slope of ln mu over ln F_N between grounds [1]."""


def friction_from_training(
    known: Mapping[str, float], training: Sequence[Recording], recording: Recording
) -> float:
    """Friction coefficient by ground and load; by other grounds where no recording is on this one."""
    alike = [r for r in training if ground_of(r) == ground_of(recording)] or list(training)
    loads = np.log([float(r.F_N.mean()) for r in alike])
    mu = np.log([known[r.name] for r in alike])
    off = loads - loads.mean()
    slope = float(off @ mu) / (float(off @ off) + (SCATTER / SLOPE) ** 2)
    return float(np.exp(mu.mean() + slope * (np.log(recording.F_N.mean()) - loads.mean())))


def values_from_training(fitted: Fit, training: Sequence[Recording], recording: Recording) -> Values:
    """Values for a recording of which nothing is fitted.

    mu is predicted, all else that belongs to a recording is neutral, its rig is as declared; a ground
    without training recordings has the mean over grounds.
    """
    known = {name: own["mu"] for name, own in fitted.values.own.items()}
    own = {
        parameter_name(effect, p): p.neutral
        for effect, p in fitted.model.parameters
        if p.scope == "recording" and p.neutral is not None
    }
    own["mu"] = friction_from_training(known, training, recording)
    alone = Values(tyre=fitted.values.tyre, grounds=fitted.values.grounds, own={recording.name: own})
    return complete_values(fitted.model, alone, [recording])


def unrefitted_residuals(
    fitted: Fit, training: Sequence[Recording], recordings: Sequence[Recording]
) -> dict[str, Array]:
    """Residuals of recordings of which nothing was fitted, by a fit on the training recordings [N m]."""
    values = {r.name: values_from_training(fitted, training, r).of(r) for r in recordings}
    return {r.name: simulated_minus_measured(fitted.model, r, values[r.name]) for r in recordings}


def simulated_minus_measured(model: Model, recording: Recording, values: Mapping[str, float]) -> Array:
    """Simulated minus measured torque with the rig as declared [N m]."""
    theta = np.asarray(model.theta(values)).ravel()
    geometry = np.array([recording.rig.a, recording.rig.e])
    # With all directions, as in a fit: that Function is compiled already.
    directions = np.eye(theta.size + len(RIG_DIRECTIONS))
    simulated = simulate(model, signals_of(recording), theta, geometry, directions)
    return np.asarray(simulated.M_z - recording.M_z)
