"""State space of an observer, written out once more in NumPy, and filterpy's filter that rests on it.

Nothing is shared with the observers but the model: its step, or halves of it, as a black box with
casadi's full Jacobians.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from observers import Sample
from symbolic.float_array_type import Array
from tests.observers.factories import slide


@dataclass(frozen=True, kw_only=True, eq=False)
class History:
    """The patch before a sample: its memory, the derivative by the tyre, and the tyre it stands for."""

    memory: Array
    sensitivity: Array
    linearisation_point: Array


class StateSpace:
    """Motion, measurement and patch of an observer; x in the order of its states."""

    def __init__(self, observer: Any) -> None:
        """Take its settings; nothing of its inside."""
        self.observer, self.tuning, self.model = observer, observer.tuning, observer.model
        self.at = {name: i for i, name in enumerate(observer.states)}
        self.n, self.steers = len(self.at), "psi" in self.at
        self.of_tyre = [self.at[name] for name in ("log_mu", "stiffness") if name in self.at]
        self.geometry = np.array([observer.rig.a, observer.rig.e])
        self.theta = np.asarray(self.model.theta({**observer.values, "mu": self.tuning.mu})).ravel()
        self.jacobian = self.model.step.jacobian()

    def prior(self, first: Sample) -> tuple[Array, Array, History]:
        """Mean, covariance and patch before the first sample."""
        tuning = self.tuning
        means = {"log_mu": np.log(tuning.mu), "stiffness": 1.0, "psi": first.psi}
        spreads = {
            "log_mu": tuning.mu_std / tuning.mu,
            "M_0": tuning.zero_std * slide(first.F_N),
            "stiffness": tuning.stiffness_std,
            "psi": tuning.psi_noise,
            "psi_dot": tuning.psi_dot_std,
        }
        x = np.array([means.get(name, 0.0) for name in self.at])
        signals = np.array([first.psi, first.psi_dot, first.F_N, first.dt])
        memory = np.asarray(self.model.initial(signals, self.theta, self.geometry)).ravel()
        tyre = self.tyre(x)
        sensitivity = np.zeros((memory.size, tyre.size))
        history = History(memory=memory, sensitivity=sensitivity, linearisation_point=tyre)
        return x, np.diag([spreads[name] ** 2 for name in self.at]), history

    def tyre(self, x: Array) -> Array:
        """mu, and the stiffness share where it is a state."""
        return np.array([np.exp(x[self.of_tyre[0]]), *x[self.of_tyre[1:]]])

    def by_state(self, x: Array) -> Array:
        """Derivative of `tyre` by its states, diagonal."""
        return np.diag([np.exp(x[self.of_tyre[0]]), *np.ones(len(self.of_tyre) - 1)])

    def parameters(self, x: Array) -> Array:
        """Parameter vector at the states."""
        tyre = self.tyre(x)
        k = self.theta[1] * (tyre[1] if tyre.size > 1 else 1.0)
        return np.array([tyre[0], k, *self.theta[2:]])

    def motion(
        self, x: Array, M_z: float, by_x: Array, last: Sample | None, now: Sample
    ) -> tuple[Array, Array, Array]:
        """The states at `now`, their derivative, and variances of disturbances; last None at rest."""
        tuning, level, A, after = self.tuning, slide(now.F_N), np.eye(self.n), x.copy()
        Q = np.zeros(self.n)
        Q[self.at["log_mu"]] = now.dt * tuning.mu_walk**2
        if "M_0" in self.at:
            i, fade = self.at["M_0"], np.exp(-now.dt / tuning.zero_time)
            after[i], A[i, i] = fade * x[i], fade
            Q[i] = now.dt * fade * (tuning.zero_walk * level) ** 2
        if "stiffness" in self.at:
            Q[self.at["stiffness"]] = now.dt * tuning.stiffness_walk**2
        if self.steers:
            self._swing(x, M_z, by_x, last, now, after, A, Q)
        return after, A, Q

    def _swing(self, x: Array, M_z: float, by_x: Array, last: Any, now: Any, after: Array, A: Array,
               Q: Array) -> None:  # fmt: skip
        """J_A (v' - v) / kick = -b_t (v' + v) / 2 + M_z + M + M_0; psi' = psi + dt v'."""
        J, b, i, j = self.observer.rig.J_A, self.observer.rig.b_t, self.at["psi"], self.at["psi_dot"]
        kick = now.dt / 2 if last is None else (last.dt + now.dt) / 2
        torque, by_torque = M_z + (0.0 if last is None else last.M), by_x.copy()
        if "M_0" in self.at:
            torque += x[self.at["M_0"]]
            by_torque[self.at["M_0"]] += 1.0
        push, drag = kick / J / (1 + kick * b / (2 * J)), kick * b / (2 * J)
        rate = (1 - drag) / (1 + drag) * x[j] + push * torque
        A[j] = push * by_torque
        A[j, j] += (1 - drag) / (1 + drag)
        A[i] += now.dt * A[j]
        after[i], after[j] = x[i] + now.dt * rate, rate
        # The damping may be off by 20 %, evenly, for as long as the model's error lasts.
        lasting = self.tuning.error_travel / max(0.1, abs(x[j]))
        off = (0.2 * b * x[j]) ** 2 / 3 * lasting
        Q[j] = ((self.tuning.noise * slide(now.F_N)) ** 2 * 0.01 + off) * kick / J**2

    def measurement(
        self, x: Array, M_z: float, by_x: Array, now: Sample
    ) -> tuple[float, Array, float, float]:
        """Measured, expected, derivative, and weight, 0 where nothing is measured."""
        if self.steers:
            H, expected = np.eye(self.n)[self.at["psi"]], x[self.at["psi"]]
            measured, weight = now.psi, self.tuning.psi_noise**-2
        else:
            H, expected, measured = by_x.copy(), M_z, now.M_z
            if "M_0" in self.at:
                H[self.at["M_0"]] += 1.0
                expected = M_z + x[self.at["M_0"]]
            weight = now.dt / 0.01 / (self.tuning.noise * slide(now.F_N)) ** 2
        return (measured, expected, H, weight) if np.isfinite(measured) else (expected, expected, H, 0.0)

    def predicted_history(self, history: History, P: Array, Q: Array, x: Array) -> History:
        """The history after a walk: of its derivative the regression of the past tyre on the present."""
        at, scale = self.of_tyre, self.by_state(x)
        P_tyre = scale @ P[np.ix_(at, at)] @ scale
        walked = P_tyre + scale @ np.diag(Q[at]) @ scale
        share = np.linalg.solve(walked, P_tyre).T if Q[at].any() else np.eye(len(at))
        return replace(history, sensitivity=history.sensitivity @ share)

    def signals(self, x: Array, now: Sample) -> Array:
        """What the patch sees of a sample."""
        psi, rate = (x[self.at["psi"]], x[self.at["psi_dot"]]) if self.steers else (now.psi, now.psi_dot)
        return np.array([psi, rate, now.F_N, now.dt])

    def update_patch(self, history: History, x: Array, now: Sample) -> tuple[History, float, Array]:
        """The history after a sample, M_z, and its derivative by x."""
        tyre, theta = self.tyre(x), self.parameters(x)
        memory = history.memory + history.sensitivity @ (tyre - history.linearisation_point)
        inputs = (memory, self.signals(x, now), theta, self.geometry)
        after, M_z = self.model.step(*inputs)
        J = [np.asarray(block) for block in self.jacobian(*inputs, after, M_z)]
        by_tyre = np.zeros((theta.size, tyre.size))
        by_tyre[0, 0] = 1.0
        by_tyre[1, 1:] = self.theta[1]
        sensitivity = J[0] @ history.sensitivity + J[2] @ by_tyre
        by_x = np.zeros(self.n)
        by_x[self.of_tyre] = (J[4] @ history.sensitivity + J[6] @ by_tyre)[0] @ self.by_state(x)
        if self.steers:
            by_x[self.at["psi"]] = J[5][0, 0]
        memory = np.asarray(after).ravel()
        new = History(memory=memory, sensitivity=sensitivity, linearisation_point=tyre)
        return new, float(M_z), by_x

    def projected(self, x: Array) -> Array:
        """The states with mu within its bounds."""
        x, i = x.copy(), self.at["log_mu"]
        x[i] = np.clip(x[i], np.log(self.tuning.least), np.log(self.tuning.greatest))
        return x


class Filter:
    """filterpy's extended Kalman filter on `StateSpace`."""

    def __init__(self, observer: Any, first: Sample) -> None:
        """Begin where the filter under test begins."""
        self.space = StateSpace(observer)
        x, P, self.history = self.space.prior(first)
        self.filter = ExtendedKalmanFilter(dim_x=x.size, dim_z=1)
        self.filter.x, self.filter.P = x.reshape(-1, 1), P
        self.last: Sample | None = None
        self.M_z, self.by_x = 0.0, np.zeros(x.size)
        self.nis, self.lag = np.nan, 0.0

    @property
    def x(self) -> Array:
        return np.asarray(self.filter.x).ravel()

    @property
    def P(self) -> Array:
        return np.asarray(self.filter.P)

    def step(self, now: Sample) -> float:
        """Take a sample; the aligning torque that was expected."""
        space, filter_ = self.space, self.filter
        after, A, Q = space.motion(self.x, self.M_z, self.by_x, self.last, now)
        history = space.predicted_history(self.history, self.P, Q, self.x)
        filter_.F, filter_.Q = A, np.diag(Q)
        filter_.predict()
        filter_.x = after.reshape(-1, 1)
        patch = (
            (self.history, 0.0, self.by_x) if space.steers else space.update_patch(history, after, now)
        )
        measured, expected, H, weight = space.measurement(after, patch[1], patch[2], now)
        self.nis = np.nan
        if weight > 0:
            observed = {"HJacobian": lambda _: H.reshape(1, -1), "Hx": lambda _: np.array([[expected]])}
            i, before = space.at["log_mu"], self.P.copy()
            filter_.update(np.array([[measured]]), R=1 / weight, **observed)
            # The mean of the corrections, each of which took a share of the variance.
            share, correction = 1 - self.P[i, i] / before[i, i], self.x[i] - after[i]
            self.lag = (1 - share) ** 2 * self.lag + 2 * (1 - share) * correction
            filter_.x = space.projected(self.x).reshape(-1, 1)
            self.nis = float(filter_.y[0, 0] ** 2 / filter_.S[0, 0])
        # The aligned patch is corrected when it meets the next sample, to first order.
        self.history, self.M_z, self.by_x = (
            space.update_patch(history, self.x, now) if space.steers else patch
        )
        self.last = now
        return self.M_z if space.steers else expected
