"""The moving window by the book: whole history kept, dense least squares, nothing recursive inside."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from observers import Sample
from symbolic.float_array_type import Array
from tests.observers.chains import Chain, dense
from tests.observers.textbook import History, StateSpace


@dataclass(frozen=True, kw_only=True, eq=False)
class PatchAtSample:
    """A sample, the patch after it, the signals that reached the patch, its angle and slope."""

    sample: Sample
    history: History
    patch_signals: Array
    psi: float
    by_psi: float


class WindowOracle:
    """The estimator; errors are not judged, so that its tuning must accept everything."""

    def __init__(self, observer: Any) -> None:
        """Take its settings."""
        self.observer, self.space = observer, StateSpace(observer)
        self.torque_jacobian = observer.model.torque.jacobian()

    def run(self, samples: list[Sample]) -> Iterator[tuple[Array, Array]]:
        """After every sample: x over the window (N, n), and the covariance of the newest."""
        space, window = self.space, self.observer.window
        mean, P, history = space.prior(samples[0])
        newest_P, patches, x, latest = P, [], np.zeros((0, space.n)), mean
        for now in samples:
            if x.shape[0] == window:
                mean, P = self.leave(mean, P, patches[-window:], x[0], now)
                x = x[1:]
            if patches:
                last = patches[-1].sample
                entering, A, Q = space.motion(latest, *self.torque(patches[-1], latest), last, now)
            else:
                entering, A, Q = space.motion(mean, 0.0, np.zeros(space.n), None, now)
                mean, P = entering, A @ P @ A.T + np.diag(Q)
            history = space.predicted_history(history, newest_P, Q, latest)
            x = np.vstack([x, space.projected(entering)])
            if not space.steers:
                patches.append(self.update_patch(history, x[-1], now))
            inside = [*patches[len(patches) - len(x) + space.steers :], *([now] if space.steers else [])]
            for _ in range(self.observer.iterations):
                x, newest_P = dense(self.chain(mean, P, inside, x))
                x = np.array([space.projected(row) for row in x])
            if space.steers:
                patches.append(self.update_patch(history, x[-1], now))
            history, latest = patches[-1].history, x[-1]
            yield x, newest_P

    def update_patch(self, history: History, x: Array, now: Sample) -> PatchAtSample:
        """The sample and the patch after it."""
        space = self.space
        after, _, by_x = space.update_patch(history, x, now)
        memory = history.memory + history.sensitivity @ (space.tyre(x) - history.linearisation_point)
        signals = space.signals(x, now)
        patch_signals = space.model.advance(memory, signals, space.parameters(x), space.geometry)[1]
        at = space.at.get("psi", 0)
        signals = np.asarray(patch_signals).ravel()
        parts = {"patch_signals": signals, "psi": x[at], "by_psi": by_x[at]}
        return PatchAtSample(sample=now, history=after, **parts)

    def torque(self, patch: PatchAtSample | Sample, x: Array) -> tuple[float, Array]:
        """M_z of a sample at other states, and its derivative by them."""
        space, by_x = self.space, np.zeros(self.space.n)
        if isinstance(patch, Sample):
            return 0.0, by_x
        tyre, theta = space.tyre(x), space.parameters(x)
        away = tyre - patch.history.linearisation_point
        memory = patch.history.memory + patch.history.sensitivity @ away
        inputs = (memory, patch.patch_signals, theta, space.geometry)
        M_z = space.model.torque(*inputs)
        by_memory, _, by_theta, _ = (np.asarray(b) for b in self.torque_jacobian(*inputs, M_z))
        by_tyre = (by_memory @ patch.history.sensitivity)[0]
        by_tyre[0] += by_theta[0, 0]
        by_tyre[1:] += by_theta[0, 1] * space.theta[1]
        by_x[space.of_tyre] = by_tyre @ space.by_state(x)
        if not space.steers:
            return float(M_z), by_x
        at = space.at["psi"]
        by_x[at] = patch.by_psi
        return float(M_z) + patch.by_psi * (x[at] - patch.psi), by_x

    def leave(
        self, mean: Array, P: Array, inside: list[PatchAtSample], x: Array, now: Sample
    ) -> tuple[Array, Array]:
        """The arrival without its oldest sample, measured once more and moved to the next."""
        following = inside[1].sample if len(inside) > 1 else now
        z, H, weight, A, b, Q = self.linear(inside[0], x, following)
        S = H @ P @ H * weight + 1
        mean = mean + P @ H * weight / S * (z - H @ mean)
        P = P - np.outer(P @ H, H @ P) * weight / S
        return self.space.projected(A @ mean + b), A @ P @ A.T + np.diag(Q)

    def linear(
        self, patch: PatchAtSample | Sample, x: Array, following: Sample | None
    ) -> tuple[Any, ...]:
        """z, H, weight, A, b and Q of one sample about x."""
        now = patch if isinstance(patch, Sample) else patch.sample
        M_z, by_x = self.torque(patch, x)
        measured, expected, H, weight = self.space.measurement(x, M_z, by_x, now)
        after, A, Q = self.space.motion(x, M_z, by_x, now, following or now)
        return measured - expected + H @ x, H, weight, A, after - A @ x, Q

    def chain(self, mean: Array, P: Array, inside: list[Any], x: Array) -> Chain:
        """The linear problem of the window about x."""
        followings = [m if isinstance(m, Sample) else m.sample for m in inside[1:]]
        rows = [self.linear(*row) for row in zip(inside, x, [*followings, None], strict=True)]
        z, H, weight, A, b, Q = (np.array(part) for part in zip(*rows, strict=True))
        root = np.linalg.cholesky(P)
        return Chain(mean=mean, root=root, z=z, H=H, weight=weight, A=A, b=b, Q=Q)
