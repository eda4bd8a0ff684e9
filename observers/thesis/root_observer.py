"""The method of [Györök 2022]: one root solve per sample, on the torque of three or five zones.

At every sample the coefficient of friction is the root of

    f(mu) = M_z measured - M_z of the zones at mu,

[Györök 2022], (3.7), where the aligning torque is measured, with the sign of M_z of (2.3) there. Where
the model is wrong, or the tyre sticks, there may be no root: then the nearest point is taken. In five
zones there may be two: then the solver converges to the one near the last estimate.
"""

from dataclasses import dataclass, field, replace
from math import isfinite, nan

import numpy as np
from scipy.optimize import fsolve, minimize_scalar

from observers.measurement.torque_error import SENSIBLE
from observers.protocol import Estimate, Sample, Status
from observers.thesis.zone_state_machine import (
    TorqueCurve,
    ZoneState,
    advance_zones,
    turns_from_rest_and_reversal,
    zone_torque_curve,
)
from symbolic import InvalidInputError, Rig, Tyre, full_slide_arm, full_slide_torque
from symbolic.float_array_type import Array

CLOSE = 1e-6
"""Share of the full-slide torque at mu = 1 below which f counts as zero [1]."""
SHOWS = 0.1
"""Share of the full-slide slope of M_z by mu from which a root counts as informed [1]."""


@dataclass(frozen=True, kw_only=True, slots=True)
class ZoneRootState:
    """State of a `RootObserver` between samples.

    Attributes:
        rest: angle at which the patch stood at rest, NaN before the first angle [rad].
        psi: last known angle from rest [rad].
        F_N: last known load, NaN before the first [N].
        zones: state machine of the zones.
        raw: last solution, from which the next one starts [1].
        mu: the estimate, `raw` smoothed [1].
        M_z_predicted: torque at the last sample by the estimate before it [N m].
        solved: True where the last sample gave a root, False where it gave the nearest point or none.
        informed: True once a root has been found where the patch slides noticeably.
        status: how the last sample was treated.
    """

    rest: float = nan
    psi: float = 0.0
    F_N: float = nan
    zones: ZoneState = field(default_factory=ZoneState)
    raw: float
    mu: float
    M_z_predicted: float = nan
    solved: bool = False
    informed: bool = False
    status: Status = Status.USED


@dataclass(frozen=True, kw_only=True)
class RootObserver:
    """The estimator of [Györök 2022], sections 3.1 and 3.2: a baseline by the present load and sample.

    Attributes:
        rig: geometry; a and e are used.
        k: distributed lateral stiffness [N/m^2].
        mu: first guess [1].
        bounds: least and greatest mu that are tried [1]; [Györök 2022] has none.
        smoothing: alpha of the exponential filter [Györök 2022], (5.9), at least 0 and below 1:
            mu <- alpha mu + (1 - alpha) root, so 0 is no filter. The printed alpha of 0.01 hardly
            filters; the lag of fig. 5.9 there takes 0.99.
        least_turn: turn back by which a reversal counts [rad], above the noise of the angle.

    Raises:
        InvalidInputError: a setting is out of range.
    """

    rig: Rig
    k: float
    mu: float = 1.0
    bounds: tuple[float, float] = (0.02, 4.0)
    smoothing: float = 0.0
    least_turn: float = 5e-4

    def __post_init__(self) -> None:
        """Check ranges and order."""
        Tyre(k=self.k)
        least, greatest = self.bounds
        if not 0 < least < self.mu < greatest < np.inf:
            raise InvalidInputError(
                f"bounds must be finite with 0 < least < mu < greatest, got {least}, {greatest} and"
                f" mu = {self.mu}"
            )
        if not 0 <= self.smoothing < 1:
            raise InvalidInputError(f"smoothing must lie in [0, 1), got {self.smoothing}")
        if not 0 <= self.least_turn < np.inf:
            raise InvalidInputError(
                f"least_turn must be a finite number of at least 0 rad, got {self.least_turn}"
            )

    @property
    def channel(self) -> str:
        """The torque that is used."""
        return "M_z"

    def init(self, first: Sample) -> ZoneRootState:
        """The state before the first sample, the patch at rest at its angle."""
        return ZoneRootState(rest=first.psi, raw=self.mu, mu=self.mu)

    def step(self, state: ZoneRootState, sample: Sample) -> ZoneRootState:
        """The state after one more sample; it keeps the estimate if angle, load or torque is missing.

        Raises:
            InvalidInputError: the state is that of another observer, or NaN.
        """
        state = self._state_at_sample(_require_valid_state(state), sample)
        if not (isfinite(state.rest) and isfinite(state.F_N)):
            return replace(state, M_z_predicted=nan, solved=False)
        torque = zone_torque_curve(
            turns_from_rest_and_reversal(state.zones, state.psi), state.F_N, self.k, self.rig
        )
        state = replace(state, M_z_predicted=torque(state.mu)[0], solved=False)
        if state.status:
            return state
        slide = full_slide_torque(state.F_N, self.rig.a)
        raw, solved = nearest_root(torque, sample.M_z, state.raw, self.bounds, CLOSE * slide)
        shows = solved and abs(torque(raw)[1]) >= SHOWS * slide
        return replace(
            state,
            raw=raw,
            mu=self.smoothing * state.mu + (1 - self.smoothing) * raw,
            solved=solved,
            informed=state.informed or shows,
            status=(Status.BOUND if raw in self.bounds else Status.USED)
            | (Status.USED if solved else Status.NO_ROOT),
        )

    def estimate(self, state: ZoneRootState) -> Estimate:
        """The estimate of a state.

        The method has no standard deviation, so `mu_std`, `mu_eff_std` and `nis` are NaN, and no measure
        of information.
        `informed` is an addition, and lenient: once a root was found while the patch slid noticeably it
        stays True, through full stick and through samples without a root. `ZoneRootState.solved` tells
        those. Errors are those of `step`.
        """
        state = _require_valid_state(state)
        return Estimate(
            mu=state.mu,
            mu_std=nan,
            M_z_predicted=state.M_z_predicted,
            informed=state.informed,
            mu_eff=state.mu,
            M_slide=state.mu * state.F_N * full_slide_arm(self.rig.a, self.rig.e),
            status=state.status,
        )

    def _state_at_sample(self, state: ZoneRootState, sample: Sample) -> ZoneRootState:
        """Angle, load and zones at the sample, and what is missing from it."""
        status = Status.USED if abs(sample.M_z) < SENSIBLE else Status.MISSING
        psi, F_N, rest, zones = state.psi, state.F_N, state.rest, state.zones
        if abs(sample.psi) < SENSIBLE:
            rest = rest if isfinite(rest) else sample.psi
            psi = sample.psi - rest
            zones = advance_zones(zones, psi, self.least_turn)
        else:
            status |= Status.HELD
        if 0 < sample.F_N < SENSIBLE:
            F_N = sample.F_N
        else:
            status |= Status.HELD
        return replace(state, rest=rest, psi=psi, F_N=F_N, zones=zones, status=status)


def _require_valid_state(state: ZoneRootState) -> ZoneRootState:
    if not isinstance(state, ZoneRootState):
        raise InvalidInputError(f"state must be what init or step returned, got {type(state).__name__}")
    if not (state.mu > 0 and state.raw > 0):
        raise InvalidInputError("state has NaN in mu; begin anew with init")
    return state


def nearest_root(
    torque: TorqueCurve, M_z: float, start: float, bounds: tuple[float, float], close: float
) -> tuple[float, bool]:
    """The root of f(mu) = M_z - torque(mu) near `start`; without one, where |f| is least in the bounds.

    scipy's fsolve is Powell's hybrid method, a trust region around the last estimate; [Györök 2022]
    used a trust region of MATLAB's fsolve. Beyond the bounds the curve goes on along its tangent, so
    that no negative mu is tried. |f| counts as zero up to `close` [N m]; the second result is whether
    mu is a root.
    """
    least, greatest = bounds

    def inside(mu: float) -> float:
        return min(max(mu, least), greatest)

    def f(x: Array) -> Array:
        mu = inside(x[0])
        expected, by_mu = torque(mu)
        return np.array([M_z - expected - by_mu * (x[0] - mu)])

    def slope(x: Array) -> Array:
        return np.array([[-torque(inside(x[0]))[1]]])

    def miss(mu: float) -> float:
        return abs(M_z - torque(mu)[0])

    solution, report, _, _ = fsolve(f, [start], fprime=slope, full_output=True)
    mu = float(solution[0])
    if least <= mu <= greatest and abs(report["fvec"].item()) <= close:
        return mu, True
    lowest = minimize_scalar(
        lambda mu: miss(mu) ** 2, bounds=bounds, method="bounded", options={"xatol": 1e-9}
    )
    mu = min((inside(mu), float(lowest.x), least, greatest), key=miss)
    return mu, miss(mu) <= close
