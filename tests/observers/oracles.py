"""Least squares over a window by its dense normal equations, and an estimator that rests on them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from observers import Mhe, Sample

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Problem:
    """Arguments of the smoother, in its order."""

    mean: Array
    P: Array
    Q: Array
    z: Array
    H: Array
    weight: Array

    @property
    def all(self) -> tuple[Array, ...]:
        return self.mean, self.P, self.Q, self.z, self.H, self.weight


def dense(problem: Problem) -> tuple[Array, Array]:
    """Solution of the normal equations in x_0 ... x_N: x_1 ... x_N and the covariance of x_N."""
    states, window = problem.H.shape
    size = states * (window + 1)
    information, vector = np.zeros((size, size)), np.zeros(size)
    arrival = np.linalg.inv(problem.P)
    information[:states, :states] += arrival
    vector[:states] += arrival @ problem.mean
    for i in range(window):
        walk = np.zeros((states, size))
        walk[:, states * i : states * (i + 1)] = -np.eye(states)
        walk[:, states * (i + 1) : states * (i + 2)] = np.eye(states)
        information += walk.T @ np.diag(1 / problem.Q[:, i]) @ walk
        heard = np.zeros(size)
        heard[states * (i + 1) : states * (i + 2)] = problem.H[:, i]
        information += problem.weight[0, i] * np.outer(heard, heard)
        vector += problem.weight[0, i] * problem.z[0, i] * heard
    covariance = np.linalg.inv(information)
    solution = np.linalg.solve(information, vector)
    return solution[states:].reshape(window, states).T, covariance[-states:, -states:]


class WindowOracle:
    """The estimator by the book, declared model: the whole history kept, dense equations.

    The memory of the declared model does not depend on mu, so it is worked out once.
    """

    def __init__(self, mhe: Mhe, samples: list[Sample]) -> None:
        """Work out the memory before every sample."""
        self.mhe, self.samples = mhe, samples
        self.geometry = np.array([mhe.rig.a, mhe.rig.e])
        self.theta = np.asarray(mhe.model.theta({**mhe.values, "mu": 1.0})).ravel()
        self.jacobian = mhe.model.step.jacobian()
        signals = [np.array([s.psi, s.psi_dot, s.F_N, s.dt]) for s in samples]
        self.inputs = []
        memory = np.asarray(mhe.model.start(signals[0], self.theta, self.geometry)).ravel()
        for row in signals:
            self.inputs.append((memory, row))
            memory = np.asarray(mhe.model.step(memory, row, self.theta, self.geometry)[0]).ravel()

    def torque(self, i: int, mu: float) -> tuple[float, float]:
        """M_z of sample i at mu, and its slope."""
        memory, signals = self.inputs[i]
        theta = np.concatenate([[mu], self.theta[1:]])
        inputs = (memory, signals, theta, self.geometry)
        made = self.mhe.model.step(*inputs)
        return float(made[1]), float(np.asarray(self.jacobian(*inputs, *made)[6])[0, 0])

    def problem(self, mean: Array, P: Array, first: int, x: Array) -> Problem:
        """The problem of samples from `first` on, linearised at x (2, n)."""
        tuning, samples = self.mhe.tuning, self.samples[first : first + x.shape[1]]
        slide = np.array([0.375 * s.F_N * self.mhe.rig.a for s in samples])
        dt, measured = (np.array([getattr(s, name) for s in samples]) for name in ("dt", "M_z"))
        h, slope = np.array([self.torque(first + i, mu) for i, mu in enumerate(x[0])]).T
        heard = np.isfinite(measured)
        return Problem(
            mean=mean,
            P=P,
            Q=dt * np.array([np.full(len(dt), tuning.mu_walk), tuning.zero_walk * slide]) ** 2,
            z=np.where(heard, measured - h + slope * x[0], 0.0).reshape(1, -1),
            H=np.vstack([slope, np.ones_like(slope)]),
            weight=np.where(heard, dt / 0.01 * (tuning.noise * slide) ** -2.0, 0.0).reshape(1, -1),
        )

    def run(self) -> Iterator[tuple[Array, Array]]:
        """After every sample: x over the window, and the covariance of the newest."""
        tuning = self.mhe.tuning
        slide = 0.375 * self.samples[0].F_N * self.mhe.rig.a
        mean = np.array([tuning.mu, 0.0])
        P = np.diag([tuning.mu_std**2, (tuning.zero_std * slide) ** 2])
        x = np.zeros((2, 0))
        for newest in range(len(self.samples)):
            if x.shape[1] == self.mhe.window:
                leaving = self.problem(mean, P, newest - self.mhe.window, x[:, :1])
                solved, P = dense(leaving)
                mean, x = solved[:, 0], x[:, 1:]
            x = np.column_stack([x, x[:, -1] if newest else mean])
            for _ in range(self.mhe.iterations):
                x, covariance = dense(self.problem(mean, P, newest + 1 - x.shape[1], x))
                x[0] = np.clip(x[0], tuning.least, tuning.greatest)
            yield x, covariance
