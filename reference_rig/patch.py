"""Fine-bristle patch: every bristle is an elastoplastic stop on a uniform midpoint grid.

Where friction grows with the logarithm of a bristle's own sliding speed, a bristle that a step loads to
`size` slides at v with size = A v + L (1 + c ln(v/v_ref)), A v being the stress that its slip relieves.
The root is Wright's omega function.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import exp, expm1, prod

import numpy as np
from scipy.optimize import brentq
from scipy.special import wrightomega

from reference_rig.hooks import Array, BristleStep, MaxwellBranch, PlantedEffect, RigDrive, RigHistory

REFERENCE_SPEED = 1e-3
"""Sliding speed at which the factor on the limit is one [m/s]."""
REST_SPEED = 1e-4
"""Sliding speed below which the limit is constant [m/s]."""


def friction_stress(size: Array, limit: Array, c: float, relief: float) -> tuple[Array, Array]:
    """Stress that friction balances [m], and its derivative by the stress before the slip [1].

    The size of that stress [m] and the friction bound at the reference speed [m] have the shape (n,). c
    is the growth of the bound with ln v [1], relief the stress that a slip at 1 m/s relieves in the
    step [m].
    """
    if c == 0:
        return np.minimum(size, limit), (size <= limit).astype(float)
    least = limit * (1 + c * np.log(REST_SPEED / REFERENCE_SPEED))
    sticking = size <= least
    balanced, slope = np.where(sticking, size, least), sticking.astype(float)
    over = np.flatnonzero(~sticking)
    growth, size = c * limit[over], size[over]
    excess = (size - limit[over]) / growth
    speed = growth / relief * wrightomega(excess + np.log(REFERENCE_SPEED * relief / growth))
    sliding = speed > REST_SPEED
    over, growth, speed = over[sliding], growth[sliding], speed[sliding]
    balanced[over] = limit[over] * (1 + c * np.log(speed / REFERENCE_SPEED))
    slope[over] = growth / (growth + relief * speed)
    return balanced, slope


NOTHING = 1e-12
"""Pressure where a bristle does not touch the ground; not zero, as creep divides by it [1]."""
ROWS = 12
"""Rows of bristles across half the width; the other half is its mirror image."""
TURN_TOLERANCE = 1e-13
"""Residual of the turn of a compliant carcass [rad]; the turn's error is not larger."""
TURN_ITERATIONS = 60
RENEWAL = 0.1
"""Turn over which a contact becomes another one [rad]."""


@dataclass(frozen=True, kw_only=True)
class RigTyre:
    """Patch half-length a [m], caster e [m], lateral stiffness k [N/m²], friction mu [1]."""

    a: float = 0.045
    e: float = 0.009
    k: float = 2.4e6
    mu: float = 1.3


@dataclass(frozen=True, kw_only=True, eq=False)
class BristleGrid:
    """The grid, arrays of shape (bristles,). The shares sum to one."""

    lever: Array  # Distance from the kingpin [m]; a bristle moves along its own tangent about it.
    share: Array  # Stiffness times lever, so that torque = share · stretch [N].
    # Growth of the patch [1] -> stretch at which a bristle slides, for one newton of load [m/N].
    limit_of: Callable[[float], Array]
    relaxation: MaxwellBranch  # Maxwell branch beside each spring.
    rate: float  # Growth of the limit with the logarithm of a bristle's own speed.

    @property
    def limit(self) -> Array:
        """The stretch while the patch has its declared length [m/N]."""
        return self.limit_of(1.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class PatchState:
    """Stretch of the springs and of their branches [m], and the angle of the patch [rad]."""

    spring: Array
    branch: Array
    psi: float


def simulate_bristles(
    drive: RigDrive, tyre: RigTyre, effects: Sequence[PlantedEffect] = (), *, bristles: int = 2000
) -> RigHistory:
    """Turn the tyre through a drive, one step a sample.

    Args:
        drive: what the sensors see. The limit during a step is that of the sample at its end.
        tyre: the brush model's parameters.
        effects: effects to plant; each acts at its own hooks.
        bristles: number of bristles; a patch with width has a fifth as many columns.

    Returns:
        Angle of the patch, aligning torque (moment of the ground on the wheel: negative for a
        positive turn from rest) and share of sliding bristles, all of shape (n,).
    """
    seen = drive
    for effect in effects:
        drive = effect.drive(drive)
    n = len(drive.t)
    grid = lay_out(tyre, effects, bristles)
    compliance = sum(effect.compliance for effect in effects)
    gap = sum(effect.lost_motion for effect in effects)
    travel = np.cumsum(np.abs(np.diff(drive.psi, prepend=drive.psi[0])))
    dt = np.diff(drive.t)
    dt = np.concatenate([dt[:1], dt])
    age = contact_age(drive.psi, dt)
    still = np.zeros_like(grid.lever)
    state = PatchState(spring=still, branch=still, psi=drive.psi_virgin)
    psi_patch, M_z, sliding = np.empty(n), np.empty(n), np.empty(n)
    for i in range(n):
        sample = BristleStep(
            psi_dot=float(drive.psi_dot[i]), F_N=float(drive.F_N[i]), travel=float(travel[i]),
            lever=grid.lever, age=float(age[i]),
        )  # fmt: skip
        growth = prod(effect.growth(sample.F_N, tyre.a) for effect in effects)
        factor = sample.F_N * prod(effect.friction(sample) for effect in effects)
        step = PatchStep(grid, state, grid.limit_of(growth) * factor, float(dt[i]))
        psi_patch[i] = step.solve_with_play(float(drive.psi[i]), compliance, gap)
        state, M_z[i], sliding[i] = step.take(psi_patch[i])
    history = RigHistory(drive=seen, psi_patch=psi_patch, M_z=M_z, sliding=sliding)
    for effect in sorted(effects, key=lambda effect: effect.in_sensor):
        history = replace(history, M_z=effect.torque(history))
    return history


def contact_age(psi: Array, dt: Array) -> Array:
    """Age of the contact at every sample [s]: it grows with time and dies with the turn.

    Ruina's law d age/dt = 1 - |psi_dot| age / RENEWAL; a contact is new at the first sample. Yaw angle
    [rad] and time since the sample before [s] have the shape (n,).
    """
    age, now = np.zeros_like(psi), 0.0
    for i in range(1, len(psi)):
        turned = abs(psi[i] - psi[i - 1]) / RENEWAL
        # The exact solution for an even turn.
        grown = -expm1(-turned) / turned if turned > 0 else 1.0
        now = now * exp(-turned) + float(dt[i]) * grown
        age[i] = now
    return age


def lay_out(tyre: RigTyre, effects: Sequence[PlantedEffect], bristles: int) -> BristleGrid:
    """The grid of bristles and the stretch at which each of them slides."""
    half_width = max((effect.half_width for effect in effects), default=0.0)
    columns, rows = (bristles // 5, ROWS) if half_width > 0 else (bristles, 1)
    span = max((effect.span for effect in effects), default=1.0)
    xi = span * ((2 * np.arange(columns) + 1) / columns - 1)
    y = half_width * (np.arange(rows) + 0.5) / rows
    lever = np.hypot(tyre.a * xi[:, None] - tyre.e, y[None, :])

    @lru_cache(maxsize=1)
    def limit_of(growth: float) -> Array:
        place = xi / growth
        touching = np.abs(place) < 1
        pressure = np.full(columns, NOTHING)
        factor = prod(effect.pressure(place[touching]) for effect in effects)
        pressure[touching] = 0.75 * (1 - place[touching] ** 2) * factor
        return np.repeat(tyre.mu * pressure / (growth * tyre.a * tyre.k), rows)

    branches = [effect.relaxation for effect in effects if effect.relaxation.gain]
    if len(branches) > 1:
        raise ValueError("the rig has one Maxwell branch beside each bristle spring")
    return BristleGrid(
        lever=lever.ravel(),
        share=(tyre.k * 2 * span * tyre.a / lever.size) * lever.ravel(),
        limit_of=limit_of,
        relaxation=branches[0] if branches else MaxwellBranch(),
        rate=sum(effect.rate for effect in effects),
    )


class PatchStep:
    """One step of the patch: a trial for any angle, and the step itself."""

    def __init__(self, grid: BristleGrid, state: PatchState, limit: Array, dt: float) -> None:
        """Prepare the step from the state at its beginning, for the limit at its end."""
        relaxation = grid.relaxation
        self._grid, self._state, self._limit = grid, state, limit
        self._fade = exp(-dt / relaxation.time)
        # Share of the stretch that a branch keeps when it is stretched at a steady rate.
        share = -relaxation.time * expm1(-dt / relaxation.time) / dt
        self._stretch = 1 + relaxation.gain * share
        self._relief = (1 + relaxation.gain) * dt

    @cached_property
    def _at_rest(self) -> Array:
        """Stress if the patch did not turn."""
        return self._state.spring + self._fade * self._state.branch

    def solve(self, psi: float, compliance: float) -> float:
        """Angle p of the patch with p = psi + compliance · M_z(p) [rad].

        M_z falls with p, so the residual rises with slope >= 1 and has one root. Newton's method ends
        in a few steps, and a bracket holds it.
        """
        if compliance == 0:
            return psi
        M_z, _ = self._trial(psi)
        low, high = sorted((psi, psi + compliance * M_z))
        p = low if abs(low - self._state.psi) < abs(high - self._state.psi) else high
        for _ in range(TURN_ITERATIONS):
            M_z, slope = self._trial(p)
            residual = p - psi - compliance * M_z
            if abs(residual) <= TURN_TOLERANCE:
                return p
            low, high = (low, p) if residual > 0 else (p, high)
            p -= residual / (1 - compliance * slope)
            if not low < p < high:
                p = 0.5 * (low + high)
        raise RuntimeError(f"no turn of the patch found at {psi} rad, residual {residual} rad")

    def solve_with_play(self, psi: float, compliance: float, gap: float) -> float:
        """Angle p of the patch behind a gap: at a flank it is driven, between them it turns freely."""
        if gap == 0:
            return self.solve(psi, compliance)
        flanks = [self.solve(psi + side * gap / 2, compliance) for side in (-1.0, 1.0)]
        torques = [self._trial(flank)[0] for flank in flanks]
        # A patch behind its lower flank is driven upwards, against its torque; and the other way round.
        if torques[0] <= 0:
            return flanks[0]
        if torques[1] >= 0:
            return flanks[1]
        return float(brentq(lambda p: self._trial(p)[0], *flanks, xtol=TURN_TOLERANCE))

    def take(self, psi: float) -> tuple[PatchState, float, float]:
        """Turn the patch to psi; state, torque [N m] and share of sliding bristles."""
        grid, state, gain = self._grid, self._state, self._grid.relaxation.gain
        turned = grid.lever * (psi - state.psi)
        spring = state.spring - turned
        if gain == 0 and grid.rate == 0:
            # The stop alone: what follows does the same, in twice the time.
            stress_after = np.copysign(np.minimum(np.abs(spring), self._limit), spring)
            slip = spring - stress_after
            after = PatchState(spring=spring - slip, branch=state.branch, psi=psi)
            return after, float(grid.share @ stress_after), np.count_nonzero(slip) / slip.size
        branch = self._fade * state.branch - (self._stretch - 1) * turned
        stress = spring + branch
        size, _ = friction_stress(np.abs(stress), self._limit, grid.rate, self._relief)
        stress_after = np.copysign(size, stress)
        # Slip relieves spring and branch together, in the ratio of their stiffnesses.
        slip = (stress - stress_after) / (1 + gain)
        after = PatchState(spring=spring - slip, branch=branch - gain * slip, psi=psi)
        return after, float(grid.share @ stress_after), np.count_nonzero(slip) / slip.size

    def _trial(self, psi: float) -> tuple[float, float]:
        """Torque at psi [N m] and its slope [N m/rad]."""
        grid = self._grid
        stress = self._at_rest - (self._stretch * (psi - self._state.psi)) * grid.lever
        size, give = friction_stress(np.abs(stress), self._limit, grid.rate, self._relief)
        slope = -self._stretch * float(grid.share @ (grid.lever * give))
        return float(grid.share @ np.copysign(size, stress)), slope
