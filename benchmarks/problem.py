"""The problem that observers are timed on: declared model, torque with noise, states ln mu and M_0.

Gaussian throughout, no gate and no Huber weights, so that other filters can be given the very same.
"""

from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from observers import Tuning, causal_rate
from symbolic import SIGNALS, Model, Rig, full_slide_torque, simulate
from symbolic.float_array_type import Array

RIG, K, MU = Rig(a=0.045, e=0.009), 2.4e6, 1.3
MODEL, VALUES = Model(), {"k": K}
GEOMETRY = ca.DM([RIG.a, RIG.e])
DT = 0.01
"""Time between samples [s]."""
TUNING = Tuning(noise=0.02, error=float("inf"), gate=float("inf"), zero_walk=0.001)


@dataclass(frozen=True, kw_only=True)
class TimedProblem:
    """So many samples of a path with reversals under a load that varies."""

    count: int = 1000

    @cached_property
    def t(self) -> Array:
        """Time [s]."""
        return np.arange(self.count) * DT

    @cached_property
    def signals(self) -> Array:
        """Rows psi, psi_dot, F_N, dt."""
        psi = 0.3 * np.sin(self.t) + 0.15 * np.sin(2.7 * self.t)
        load = np.full(self.count, 400.0)
        return np.vstack([psi, causal_rate(self.t, psi), load, np.full(self.count, DT)])

    @cached_property
    def M_z(self) -> Array:
        """Measured torque, its noise as `TUNING` has it [N m]."""
        torque = simulate(MODEL, self.signals, np.array([MU, K]), np.array([RIG.a, RIG.e])).M_z
        noise = np.random.default_rng(1).standard_normal(self.count)
        return torque + TUNING.noise * self.slide * noise

    @property
    def slide(self) -> float:
        """Torque of full slide at mu = 1 [N m]."""
        return float(full_slide_torque(400.0, RIG.a))

    @property
    def walks(self) -> Array:
        """Variances of what disturbs ln mu and M_0 from sample to sample."""
        return DT * np.array([TUNING.mu_walk, TUNING.zero_walk * self.slide]) ** 2

    @property
    def spreads(self) -> Array:
        """Prior standard deviations of ln mu and M_0."""
        return np.array([TUNING.prior_log_mu_std, TUNING.zero_std * self.slide])

    @property
    def prior(self) -> Array:
        """Prior mean of ln mu and M_0."""
        return np.array([np.log(TUNING.mu), 0.0])

    @property
    def noise(self) -> float:
        """Standard deviation of the torque noise [N m]."""
        return TUNING.noise * self.slide

    @property
    def advance(self) -> ca.Function:
        """(memory, signals) -> (memory, seen): the memory of the patch after a sample."""
        memory, signals = ca.MX.sym("memory", MODEL.memory_size), ca.MX.sym("signals", len(SIGNALS))
        after = MODEL.advance(memory, signals, ca.DM([MU, K]), GEOMETRY)
        return ca.Function("bench_advance", [memory, signals], list(after))

    @property
    def torque(self) -> ca.Function:
        """(memory, seen, x) -> M_z + M_0 of a sample for x = (ln mu, M_0) [N m]."""
        memory, inputs = ca.MX.sym("memory", MODEL.memory_size), ca.MX.sym("seen", len(SIGNALS))
        x = ca.MX.sym("x", 2)
        M_z = MODEL.torque(memory, inputs, ca.vertcat(ca.exp(x[0]), K), GEOMETRY)
        return ca.Function("bench_torque", [memory, inputs, x], [M_z + x[1]])

    @property
    def slopes(self) -> ca.Function:
        """(memory, seen, x) -> derivative of `torque` by x, (1, 2)."""
        symbols = [ca.MX.sym(f"s_{i}", self.torque.size1_in(i)) for i in range(3)]
        jacobian = ca.jacobian(self.torque.call(symbols, True, False)[0], symbols[2])
        return ca.Function("bench_slopes", symbols, [ca.densify(jacobian)])

    @property
    def start(self) -> Array:
        """The memory of the patch before the first sample."""
        return MODEL.initial(self.signals[:, 0], ca.DM([MU, K]), GEOMETRY).full().ravel()

    @cached_property
    def memories(self) -> Array:
        """Memory and signals seen, one below the other, after every sample in its column."""
        advance, memory, columns = self.advance, self.start, []
        for signals in self.signals.T:
            after, inputs = advance(memory, signals)
            memory = after.full().ravel()
            columns.append(np.concatenate([memory, inputs.full().ravel()]))
        return np.array(columns).T
