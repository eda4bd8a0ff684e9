"""Bayes' rule on a grid of ln mu: what torques say of a friction that stays, nothing linearised."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from observers import causal_rate
from reference_rig import GroundRecording
from symbolic import Model, simulate
from symbolic.float_array_type import Array
from tests.observers.conftest import RIG, K
from tests.observers.monte_carlo import ALLOWANCE, GREATEST, LEAST, NOISE, PRIOR

COARSE, FINE, MARGIN = 200, 8000, 0.9
"""Torques simulated, points of the posterior between them, and how far in ln mu the grid goes on."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Posterior:
    """Mean and standard deviation of ln mu after each sample, shape (n,)."""

    mean: Array
    std: Array


def posterior(made: GroundRecording, count: int) -> Posterior:
    """The posterior of constant friction after each of the first `count` samples."""
    rate = causal_rate(made.t, made.psi)
    grid = np.linspace(np.log(LEAST) - MARGIN, np.log(GREATEST) + MARGIN, COARSE)
    signals = np.vstack([made.psi, rate, made.F_N, np.full_like(rate, made.t[1] - made.t[0])])[:, :count]
    sigma = ALLOWANCE * NOISE * np.ptp(made.M_z_true)
    costs = []
    for ln_mu in grid:
        theta, geometry = np.array([np.exp(ln_mu), K]), np.array([RIG.a, RIG.e])
        residual = made.M_z[:count] - simulate(Model(), signals, theta, geometry).M_z
        costs.append(np.cumsum((residual / sigma) ** 2) / 2)
    fine = np.linspace(grid[0], grid[-1], FINE)[:, None]
    prior = ((fine - np.log(PRIOR["mu"])) / PRIOR["mu_std"]) ** 2 / 2
    cost = CubicSpline(grid, np.array(costs))(fine.ravel()) + prior
    weight = np.exp(cost.min(axis=0) - cost)
    weight = weight / weight.sum(axis=0)
    mean = (fine * weight).sum(axis=0)
    return Posterior(mean=mean, std=np.sqrt(((fine - mean) ** 2 * weight).sum(axis=0)))
