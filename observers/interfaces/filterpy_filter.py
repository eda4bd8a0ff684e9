"""Our model inside filterpy's extended Kalman filter, with exact derivatives.

It stands outside `import observers`, as filterpy loads SciPy's statistics:

    from observers.interfaces.filterpy_filter import FilterpyEkf
"""

import math
from collections.abc import Mapping

import casadi as ca
import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from observers.layout import symbols
from observers.protocol import Sample
from observers.tuning import Tuning
from symbolic import DECLARED, GEOMETRY, SIGNALS, InvalidInputError, Model, Rig, compiled

SHARE = 3 / 8
"""Full-slide torque of the declared patch at mu = 1 over F_N a [1]."""


class FilterpyEkf(ExtendedKalmanFilter):  # type: ignore[misc]
    """filterpy's filter for ln mu from the aligning torque; what it offers is filterpy's.

    The patch remembers how it was turned. Its memory does not depend on mu and is not filtered: `step`
    follows it, then calls `predict` and `update` with the model's torque and its derivative by ln mu,
    which CasADi derives. A gate, Huber's loss, a torque zero and a floor of mu's deviation are what
    `observers.Ekf` has beside that.
    """

    def __init__(
        self, *, model: Model, values: Mapping[str, float], rig: Rig, tuning: Tuning | None = None
    ) -> None:
        """Prior and noises as of a tuning.

        Args:
            model: whose memory does not depend on mu.
            values: every parameter of the model but mu, by name.
            rig: geometry.
            tuning: prior, random walk and torque noise; those of `Tuning()` without.

        Raises:
            InvalidInputError: the memory depends on mu, or a value is missing or out of bounds.
        """
        super().__init__(dim_x=1, dim_z=1)
        self.tuning = Tuning() if tuning is None else tuning
        if model.memory_depends_on("mu"):
            raise InvalidInputError(
                "the memory of this model depends on mu, which filterpy's filter cannot follow;"
                " take observers.Ekf"
            )
        self.x = np.array([[math.log(self.tuning.mu)]])
        self.P = np.array([[self.tuning.prior_log_mu_std**2]])
        self._rig = rig
        self._initial, self._advance, self._torque = _patch_functions(model, values, rig)
        self._memory: ca.DM | None = None

    @property
    def mu(self) -> float:
        """The friction coefficient [1]."""
        return math.exp(self.x[0, 0])

    @property
    def mu_std(self) -> float:
        """Its standard deviation [1]."""
        return self.mu * math.sqrt(self.P[0, 0])

    def step(self, sample: Sample) -> float:
        """The friction coefficient after one more sample [1]; at the first the patch is at rest.

        A sample whose M_z is NaN is predicted alone.

        Raises:
            InvalidInputError: another signal is not finite.
        """
        signals = [getattr(sample, name) for name in SIGNALS]
        if not np.isfinite(signals).all():
            raise InvalidInputError(
                f"{', '.join(SIGNALS)} must be finite, got {signals}; hold what is missing"
            )
        if self._memory is None:
            self._memory = self._initial(signals)
        self._memory, patch_signals = self._advance(self._memory, signals)
        self.Q = np.array([[self.tuning.mu_walk**2 * sample.dt]])
        self.predict()
        if math.isfinite(sample.M_z):
            spread = self.tuning.noise * SHARE * sample.F_N * self._rig.a
            self.R = np.array([[spread**2]])
            results = self._torque(self._memory, patch_signals, self.x[0, 0])
            torque, slope = (result.full() for result in results)
            self.update(np.array([[sample.M_z]]), lambda _: slope, lambda _: torque)
        return self.mu


def _patch_functions(
    model: Model, values: Mapping[str, float], rig: Rig
) -> tuple[ca.Function, ca.Function, ca.Function]:
    """Memory before the first signals, after a sample, and torque with its derivative by ln mu."""
    nominal = model.theta({**values, "mu": DECLARED[0].start})
    geometry = ca.DM([getattr(rig, name) for name in GEOMETRY])
    sizes = {"memory": model.memory_size, "patch_signals": len(SIGNALS), "signals": len(SIGNALS)}
    memory, patch_signals, signals, log_mu = symbols(ca.MX, **sizes, log_mu=1).values()
    theta = ca.vertcat(ca.exp(log_mu), nominal[1:])
    torque = model.torque(memory, patch_signals, theta, geometry)
    slope = ca.densify(ca.jacobian(torque, log_mu))
    advance = ca.Function(
        "filterpy_advance", [memory, signals], model.advance.call([memory, signals, nominal, geometry])
    )
    predicted = ca.Function("filterpy_torque", [memory, patch_signals, log_mu], [torque, slope])
    initial = ca.Function("filterpy_initial", [signals], [model.initial(signals, nominal, geometry)])
    return initial, compiled(advance), compiled(predicted)
