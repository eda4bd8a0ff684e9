"""The moving window by the book: whole history kept, dense least squares, nothing recursive inside."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from observers import Sample
from tests.observers.chains import Chain, dense
from tests.observers.textbook import Beliefs, History

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True, eq=False)
class Met:
    """What is kept of a sample: the patch after it, what reached the patch, and its angle and slope."""

    sample: Sample
    history: History
    seen: Array
    psi: float
    by_psi: float


class WindowOracle:
    """The estimator; errors are not judged, so that its tuning must believe everything."""

    def __init__(self, observer: Any) -> None:
        """Take its settings."""
        self.observer, self.beliefs = observer, Beliefs(observer)
        self.torque_jacobian = observer.model.torque.jacobian()

    def run(self, samples: list[Sample]) -> Iterator[tuple[Array, Array]]:
        """After every sample: x over the window (N, n), and the covariance of the newest."""
        beliefs, window = self.beliefs, self.observer.window
        mean, P, history = beliefs.prior(samples[0])
        newest_P, met, x, latest = P, [], np.zeros((0, beliefs.n)), mean
        for now in samples:
            if x.shape[0] == window:
                mean, P = self.leave(mean, P, met[-window:], x[0], now)
                x = x[1:]
            if met:
                last = met[-1].sample
                entering, A, Q = beliefs.motion(latest, *self.torque(met[-1], latest), last, now)
            else:
                entering, A, Q = beliefs.motion(mean, 0.0, np.zeros(beliefs.n), None, now)
                mean, P = entering, A @ P @ A.T + np.diag(Q)
            history = beliefs.kept(history, newest_P, Q, latest)
            x = np.vstack([x, beliefs.projected(entering)])
            if not beliefs.steers:
                met.append(self.meet(history, x[-1], now))
            inside = [*met[len(met) - len(x) + beliefs.steers :], *([now] if beliefs.steers else [])]
            for _ in range(self.observer.iterations):
                self.problem = (mean, P, inside)
                x, newest_P = dense(self.chain(mean, P, inside, x))
                x = np.array([beliefs.projected(row) for row in x])
            if beliefs.steers:
                met.append(self.meet(history, x[-1], now))
            history, latest = met[-1].history, x[-1]
            yield x, newest_P

    def meet(self, history: History, x: Array, now: Sample) -> Met:
        """The sample as the patch met it."""
        beliefs = self.beliefs
        after, _, by_x = beliefs.meet(history, x, now)
        memory = history.memory + history.carried @ (beliefs.tyre(x) - history.held_at)
        signals = beliefs.signals(x, now)
        seen = beliefs.model.advance(memory, signals, beliefs.parameters(x), beliefs.geometry)[1]
        at = beliefs.at.get("psi", 0)
        return Met(sample=now, history=after, seen=np.asarray(seen).ravel(), psi=x[at], by_psi=by_x[at])

    def torque(self, met: Met | Sample, x: Array) -> tuple[float, Array]:
        """M_z of a sample at other states, and its derivative by them."""
        beliefs, by_x = self.beliefs, np.zeros(self.beliefs.n)
        if isinstance(met, Sample):
            return 0.0, by_x
        tyre, theta = beliefs.tyre(x), beliefs.parameters(x)
        memory = met.history.memory + met.history.carried @ (tyre - met.history.held_at)
        inputs = (memory, met.seen, theta, beliefs.geometry)
        M_z = beliefs.model.torque(*inputs)
        by_memory, _, by_theta, _ = (np.asarray(b) for b in self.torque_jacobian(*inputs, M_z))
        by_tyre = (by_memory @ met.history.carried)[0]
        by_tyre[0] += by_theta[0, 0]
        by_tyre[1:] += by_theta[0, 1] * beliefs.theta[1]
        by_x[beliefs.of_tyre] = by_tyre @ beliefs.by_state(x)
        if not beliefs.steers:
            return float(M_z), by_x
        at = beliefs.at["psi"]
        by_x[at] = met.by_psi
        return float(M_z) + met.by_psi * (x[at] - met.psi), by_x

    def leave(
        self, mean: Array, P: Array, inside: list[Met], x: Array, now: Sample
    ) -> tuple[Array, Array]:
        """The arrival without its oldest sample, measured once more and moved to the next."""
        following = inside[1].sample if len(inside) > 1 else now
        z, H, weight, A, b, Q = self.linear(inside[0], x, following)
        S = H @ P @ H * weight + 1
        mean = mean + P @ H * weight / S * (z - H @ mean)
        P = P - np.outer(P @ H, H @ P) * weight / S
        return self.beliefs.projected(A @ mean + b), A @ P @ A.T + np.diag(Q)

    def linear(self, met: Met | Sample, x: Array, following: Sample | None) -> tuple[Any, ...]:
        """z, H, weight, A, b and Q of one sample about x."""
        now = met if isinstance(met, Sample) else met.sample
        M_z, by_x = self.torque(met, x)
        measured, expected, H, weight = self.beliefs.reading(x, M_z, by_x, now)
        after, A, Q = self.beliefs.motion(x, M_z, by_x, now, following or now)
        return measured - expected + H @ x, H, weight, A, after - A @ x, Q

    def residuals(self, x: Array) -> Array:
        """Everything whose squares the window last minimised, at x (N, n); every Q > 0."""
        mean, P, inside = self.problem
        parts = [np.linalg.solve(np.linalg.cholesky(P), x[0] - mean)]
        for i, met in enumerate(inside):
            now = met if isinstance(met, Sample) else met.sample
            M_z, by_x = self.torque(met, x[i])
            measured, expected, _, weight = self.beliefs.reading(x[i], M_z, by_x, now)
            parts.append(np.array([np.sqrt(weight) * (measured - expected)]))
            if i + 1 < len(inside):
                onward = inside[i + 1]
                following = onward if isinstance(onward, Sample) else onward.sample
                after, _, Q = self.beliefs.motion(x[i], M_z, by_x, now, following)
                parts.append((x[i + 1] - after) / np.sqrt(Q))
        return np.concatenate(parts)

    def chain(self, mean: Array, P: Array, inside: list[Any], x: Array) -> Chain:
        """The linear problem of the window about x."""
        followings = [m if isinstance(m, Sample) else m.sample for m in inside[1:]]
        rows = [self.linear(*row) for row in zip(inside, x, [*followings, None], strict=True)]
        z, H, weight, A, b, Q = (np.array(part) for part in zip(*rows, strict=True))
        root = np.linalg.cholesky(P)
        return Chain(mean=mean, root=root, z=z, H=H, weight=weight, A=A, b=b, Q=Q)
