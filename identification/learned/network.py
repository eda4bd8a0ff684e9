"""The network of a learned torque trained: least squares with weight decay, exact Jacobians.

The physics is frozen and the learned torque is added last, so what it adds to a free run is a plain
function of signals that the free run has: they are taken from it once.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from identification.fits.fitting import Fit, signals_of, torque_range
from identification.reading.recordings import Recording
from symbolic import SIGNALS, LearnedTorque, Model, PatchOutput, Signals, full_slide_torque, units_of
from symbolic.effects.learned import INPUTS, network_share, weights_needed

Array = NDArray[np.float64]
SAMPLES = 1000
"""Samples that the training looks at, evenly out of all recordings; neighbours say the same."""
RESTARTS, FIRST_EVALUATIONS = 3, 12
"""Starts of a training; evaluations after which only the best of them goes on."""
TOLERANCE, MOST_EVALUATIONS = 1e-4, 60
"""Relative change of cost and weights at which a training ends; evaluations that it may take."""


@dataclass(frozen=True, kw_only=True, eq=False)
class TrainingData:
    """What a recording has to teach.

    Attributes:
        name: the recording.
        inputs: what the units see, shape (INPUTS, n).
        slide: 3/8 F_N a, shape (n,) [N m].
        target: measured minus simulated torque, NaN where missing, shape (n,) [N m].
        span: torque range of the recording [N m].
    """

    name: str
    inputs: Array
    slide: Array
    target: Array
    span: float

    def at(self, chosen: NDArray[np.int_]) -> "TrainingData":
        """The material at these samples."""
        return replace(
            self,
            inputs=self.inputs[:, chosen],
            slide=self.slide[chosen],
            target=self.target[chosen],
        )

    def every(self, stride: int) -> "TrainingData":
        """Every so many samples that have a torque."""
        return self.at(np.flatnonzero(np.isfinite(self.target))[::stride])


def material_of(fitted: Fit, recording: Recording, blank: LearnedTorque) -> TrainingData:
    """The signals that a learned torque sees in the free run of a fitted model, and what it should make.

    Args:
        fitted: the fit that holds the recording.
        recording: what was measured.
        blank: the learned torque that is to be trained; its weights do not matter.
    """
    # What effects on the sensors let through does not depend on the patch: the smallest one does.
    sensors = tuple(effect for effect in fitted.model.effects if effect.sensor)
    model = Model(effects=(*sensors, blank), corners=4)
    values, names = fitted.values.of(recording.name), units_of(model)
    theta = model.theta({name: values[name] for name in names})
    rig, signals, n = recording.rig, signals_of(recording), recording.t.size
    constant = [ca.repmat(vector, 1, n) for vector in (theta, ca.DM([rig.a, rig.e]))]
    first = model.initial(signals[:, 0], theta, [rig.a, rig.e])
    memory, seen = model.advance.mapaccum(n)(first, signals, *constant)
    residual = fitted.residuals[recording.name]
    M_z = np.nan_to_num(recording.M_z + residual)
    inputs = _inputs(blank).map(n)(seen, memory[-blank.memory :, :], M_z[None], values["mu"], rig.a)
    return TrainingData(
        name=recording.name,
        inputs=inputs.full(),
        slide=full_slide_torque(seen.full()[SIGNALS.index("F_N")], rig.a),
        target=-residual,
        span=torque_range(recording),
    )


def torque_of(effect: LearnedTorque, material: TrainingData) -> Array:
    """What a learned torque adds to the free run, shape (n,) [N m]."""
    share, _ = _over_samples(effect.units, material.slide.size)
    made = share(material.inputs, effect.weights, effect.bound)
    return np.asarray(material.slide * made.full().ravel())


def _inputs(blank: LearnedTorque) -> ca.Function:
    seen, memory = ca.SX.sym("seen", len(SIGNALS)), ca.SX.sym("memory", blank.memory)
    M_z, mu, a = (ca.SX.sym(name) for name in ("M_z", "mu", "a"))
    signals = Signals(**dict(zip(SIGNALS, ca.vertsplit(seen), strict=True)))
    made = PatchOutput(M_z=M_z, slide=full_slide_torque(signals.F_N, a), mu=mu)
    return ca.Function("inputs", [seen, memory, M_z, mu, a], [blank.inputs(signals, memory, made)])


class NetworkFit:
    """Residuals and exact Jacobian of a network of so many units on material, over its weights.

    A residual is the torque error over the recording's range, in units in which a learned torque that is
    zero everywhere leaves a sum of squares of one.
    """

    def __init__(self, material: Sequence[TrainingData], units: int, bound: float) -> None:
        """Build the Functions over all samples."""
        self.units, self.inputs = units, ca.DM(np.hstack([m.inputs for m in material]))
        gain = np.concatenate([m.slide / m.span for m in material])
        target = np.concatenate([m.target / m.span for m in material])
        size = max(float(np.sqrt(np.sum(target**2))), np.finfo(float).tiny)
        self.gain, self.target = gain / size, target / size
        self.share, self.slopes = _over_samples(units, self.inputs.shape[1])
        self.bound = bound

    def residuals(self, weights: Array) -> Array:
        """Shape (n,)."""
        share = self.share(self.inputs, weights, self.bound).full().ravel()
        return np.asarray(self.gain * share - self.target)

    def jacobian(self, weights: Array) -> Array:
        """Derivatives of `residuals`, shape (n, weights)."""
        slopes = self.slopes(self.inputs, weights, self.bound).full()
        return np.asarray((slopes * self.gain).T)

    def learned(self, decay: float) -> Array:
        """Weights that minimise the sum of squares plus decay |w|^2; the best of a few starts.

        Starts are drawn from a fixed seed, so that the same material gives the same weights.
        """
        size = weights_needed(self.units)
        starts = np.random.default_rng(0).standard_normal((RESTARTS, size)) / np.sqrt(INPUTS)
        begun = [self._descended(start, decay, FIRST_EVALUATIONS) for start in starts]
        best = min(begun, key=lambda solution: solution[1])[0]
        return self._descended(best, decay, MOST_EVALUATIONS)[0]

    def _descended(self, start: Array, decay: float, evaluations: int) -> tuple[Array, float]:
        root, own = np.sqrt(decay), np.eye(start.size)
        solution = least_squares(
            lambda w: np.concatenate([self.residuals(w), root * w]),
            start,
            jac=lambda w: np.vstack([self.jacobian(w), root * own]),
            method="lm",
            ftol=TOLERANCE,
            xtol=TOLERANCE,
            max_nfev=evaluations,
        )
        return solution.x, float(solution.cost)


@cache
def _over_samples(units: int, samples: int) -> tuple[ca.Function, ca.Function]:
    """Shares of the full slide torque at every sample, and their slopes over the weights."""
    u, w = ca.SX.sym("u", INPUTS), ca.SX.sym("w", weights_needed(units))
    bound = ca.SX.sym("bound")
    share = network_share(u, w, units, bound)
    made = []
    for name, value in (("share", share), ("slopes", ca.jacobian(share, w).T)):
        # The weights and the bound are the same at every sample.
        one = ca.Function(name, [u, w, bound], [value], ["u", "w", "bound"], [name])
        made.append(one.map(f"every_{name}", "serial", samples, [1, 2], []))
    return made[0], made[1]
