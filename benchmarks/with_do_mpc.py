"""do-mpc's moving-horizon estimator on the same problem: same states, window, noises and torque.

The memory of the patch depends on neither mu nor k (`symbolic.exact_zone_patch`), so every node of the
window gets it as a time-varying parameter, and the measurement is the model's torque as a casadi
expression. IPOPT solves the problem anew with every sample. do-mpc weighs the oldest state of the window
by a constant matrix; here that is the prior's.
"""

import warnings
from collections.abc import Mapping
from typing import Any

import casadi as ca
import numpy as np

from benchmarks.problem import DT, MODEL, TUNING, TimedProblem

QUIET = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": 0, "record_time": True}
WARM = {
    "ipopt.warm_start_init_point": "yes",
    "ipopt.mu_init": 1e-6,
    "ipopt.warm_start_bound_push": 1e-8,
    "ipopt.warm_start_mult_bound_push": 1e-8,
}
"""IPOPT begins where the last sample ended; do-mpc hands the last solution and its multipliers over."""
ONE = {**WARM, "ipopt.max_iter": 1}
"""One step of IPOPT a sample, as our MHE takes one of Gauss-Newton."""
VARIANTS = {"converged, warm start": WARM, "one iteration, warm start": ONE}


def build_model(do_mpc: Any, problem: TimedProblem) -> Any:
    """States ln mu and M_0 that walk at random, measurement M_z + M_0, both with noise."""
    model = do_mpc.model.Model("discrete", "SX")
    log_mu, zero = (model.set_variable("_x", name) for name in ("log_mu", "M_0"))
    memory = model.set_variable("_tvp", "memory", (MODEL.memory_size, 1))
    inputs = model.set_variable("_tvp", "seen", (4, 1))
    model.set_meas(
        "M_z", problem.torque.expand()(memory, inputs, ca.vertcat(log_mu, zero)), meas_noise=True
    )
    model.set_rhs("log_mu", log_mu, process_noise=True)
    model.set_rhs("M_0", zero, process_noise=True)
    model.setup()
    return model


def estimator(do_mpc: Any, problem: TimedProblem, window: int, options: Mapping[str, Any]) -> Any:
    """do-mpc's estimator for the problem, at the last sample of the first full window."""
    mhe = do_mpc.estimator.MHE(build_model(do_mpc, problem), [])
    mhe.settings.n_horizon, mhe.settings.t_step = window, DT
    mhe.settings.store_lagr_multiplier = False
    mhe.settings.nlpsol_opts = {**QUIET, **options}
    mhe.set_default_objective(
        np.diag(problem.spreads**-2), np.array([[problem.noise**-2]]), P_w=np.diag(1 / problem.walks)
    )
    mhe.bounds["lower", "_x", "log_mu"] = np.log(TUNING.least)
    mhe.bounds["upper", "_x", "log_mu"] = np.log(TUNING.greatest)
    # The template has a node more than the window, which is of no use.
    memories = np.pad(problem.memories, ((0, 0), (0, 1)))
    template, measured = mhe.get_tvp_template(), mhe.get_y_template()

    def first(t: Any) -> int:
        return max(round(float(np.asarray(t).item()) / DT) + 1 - window, 0)

    def parameters(t: Any) -> Any:
        template.master = ca.DM(memories[:, first(t) : first(t) + window + 1].ravel(order="F"))
        return template

    def torques(t: Any) -> Any:
        measured.master = ca.DM(problem.M_z[first(t) : first(t) + window])
        return measured

    mhe.set_tvp_fun(parameters)
    mhe.set_y_fun(torques)
    mhe.t0 = (window - 1) * DT
    mhe.setup()
    mhe.x0 = problem.prior
    mhe.set_initial_guess()
    return mhe


class Running:
    """The estimator on its way through the problem; what IPOPT took for every sample [s]."""

    def __init__(self, problem: TimedProblem, window: int, options: Mapping[str, Any]) -> None:
        """Stand before the last sample of the first full window.

        Raises:
            ImportError: do-mpc is not installed.
        """
        self._torques, self._at = problem.M_z, window - 1
        self._accepted = {"Maximum_Iterations_Exceeded"} if "ipopt.max_iter" in options else set()
        self.solver_times: list[float] = []
        with warnings.catch_warnings():
            # It warns of everything optional that it misses, and casadi once of its arrays.
            warnings.simplefilter("ignore")
            import do_mpc

            self._mhe = estimator(do_mpc, problem, window, options)

    def step(self) -> float:
        """One more sample; mu after it.

        Raises:
            RuntimeError: IPOPT has failed.
        """
        x = self._mhe.make_step(self._torques[self._at].reshape(1, 1))
        self._at += 1
        stats = self._mhe.solver_stats
        if not (stats["success"] or stats["return_status"] in self._accepted):
            raise RuntimeError(f"IPOPT: {stats['return_status']}")
        self.solver_times.append(stats["t_wall_total"])
        return float(np.exp(x[0, 0]))

    def steps(self, count: int) -> None:
        """So many more samples."""
        for _ in range(count):
            self.step()
