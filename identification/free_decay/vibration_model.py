r"""The free vibration with the sliding ends of the patch, as a casadi Function.

Sticking bristles make a spring, J_A psi'' + b_t psi' + K psi = 0 with K = 2 a k (e^2 + a^2/3)
([Györök 2022], (5.6) at rest, (5.7)). But friction holds nothing where the pressure ends, so
the outermost bristles slide in every swing, however small: on the rig of [Györök 2022], 5 mrad lower the
stiffness by 4 % and raise the damping by 7 %. Sliding lowers the torque of the virgin patch by

    M_v(psi) + K psi = k psi G(c / |psi|),     c = 3 F_N mu / (4 a^3 k),

with G of `symbolic.patch_moment_by_zones`. A decaying vibration never comes back to an earlier turning
point, so that Masing's rule holds with the last one alone: from psi_r on, the slip torque is
S = S_r + 2 (M_v + K .)((psi - psi_r) / 2). The unknown of friction is 1 / (mu F_N): 0 is a patch that
sticks, the slip is odd in it, and nothing else of load and friction matters.

A step is exact for the linear part, whatever its length: half a kick by the slip torque, the 2 x 2
matrix exponential, half a kick. Before the first turning point the motion depends on the impact and on
the patch's past; from there on, both are in the angle of that point and in the centre of the vibration.
Angle and rate at a sample close to it tell where it is.
"""

from functools import cache
from typing import NamedTuple

import casadi as ca
import numpy as np

from symbolic import Expression, compiled, full_slide_level
from symbolic.float_array_type import Array
from symbolic.named_and_buffered_functions import BufferedCall
from symbolic.patch_moment_by_zones import unit_corner_moment

UNKNOWNS = ("k", "b_t", "slip", "psi", "psi_dot", "centre")
"""Unknowns of a free vibration: k [N/m^2], b_t [N m s/rad], 1/(mu F_N) [1/N], then angle [rad] and
rate [rad/s] at the first sample and the angle about which the wheel swings [rad]."""
GEOMETRY = ("a", "e", "J_A")
_STATES = ("psi", "psi_dot", "psi_r", "S_r", "S", "heading")
PARAMETERS = ("k", "b_t", "slip", "centre")
_MIN_REACH = 1e-9
"""Least reach; below it the slip torque is its own limit for small turns [m]."""
_SAMPLES_PER_CALL = 100
"""Samples in one call."""


class VibrationTrajectory(NamedTuple):
    """Angles, shape (n,) [rad], and their derivatives by `UNKNOWNS`, shape (n, 6)."""

    psi: Array
    sensitivities: Array


def rotational_stiffness(k: Expression, a: Expression, e: Expression) -> Expression:
    """K = 2 a k (e^2 + a^2/3), the stiffness of the sticking patch [N m/rad], [Györök 2022], (5.7)."""
    return k * unit_corner_moment(0, a, e)


def sliding_torque_deficit(
    turn: Expression, k: Expression, slip: Expression, a: Expression, e: Expression
) -> Expression:
    """M_v + K psi [N m], which a virgin patch lacks by sliding; odd in the turn and in 1/(mu F_N)."""
    per_turn = k * slip / full_slide_level(1, a)
    reach = ca.fmax(ca.fabs(per_turn * turn), _MIN_REACH)
    return k * turn * ca.fabs(turn) * per_turn * unit_corner_moment(1 / reach, a, e) / reach


def simulate_vibration(t: Array, unknowns: Array, geometry: Array) -> VibrationTrajectory:
    """The vibration at increasing times [s], the first one close to the first turning point.

    NaN where the wheel would not vibrate, 4 K J_A <= b_t^2. Unknowns and geometry are in the order of
    `UNKNOWNS` and of `GEOMETRY`.
    """
    first, stretch = _initial_and_stretch_steps()
    state, sensitivity = (matrix.full() for matrix in first(unknowns, geometry))
    theta = unknowns[[UNKNOWNS.index(name) for name in PARAMETERS]]
    # Matrices of casadi lie column by column: the transposes of these arrays, sample after sample.
    buffered = BufferedCall(stretch)
    constant = (np.tile(values, _SAMPLES_PER_CALL) for values in (theta, geometry))
    *given, dt = buffered.inputs
    for array, values in zip(given, (state, sensitivity.T, *constant), strict=True):
        array[:] = values.ravel()
    states = buffered.outputs[0].reshape(_SAMPLES_PER_CALL, len(_STATES))
    along = buffered.outputs[1].reshape(_SAMPLES_PER_CALL, len(UNKNOWNS), len(_STATES))
    psi, sensitivities = np.empty(t.size), np.empty((t.size, len(UNKNOWNS)))
    psi[0], sensitivities[0] = state[0, 0], sensitivity[0]
    for at in range(1, t.size, _SAMPLES_PER_CALL):
        count = min(_SAMPLES_PER_CALL, t.size - at)
        dt[:count], dt[count:] = np.diff(t[at - 1 : at + count]), 0
        buffered.call()
        psi[at : at + count], sensitivities[at : at + count] = states[:count, 0], along[:count, :, 0]
        buffered.inputs[0][:], buffered.inputs[1][:] = states[-1], along[-1].ravel()
    return VibrationTrajectory(psi, sensitivities)


def _parts(vector: Expression) -> list[Expression]:
    return list(ca.vertsplit(vector))


@cache
def _initial_and_stretch_steps() -> tuple[ca.Function, ca.Function]:
    """The state at the first sample, and a stretch of samples; with derivatives by `UNKNOWNS`."""
    unknowns, geometry = ca.SX.sym("unknowns", len(UNKNOWNS)), ca.SX.sym("geometry", len(GEOMETRY))
    state = initial_vibration_state(unknowns, geometry)
    first = ca.Function(
        "swing_first",
        [unknowns, geometry],
        [state, ca.densify(ca.jacobian(state, unknowns))],
        ["unknowns", "geometry"],
        ["state", "sensitivity"],
    )
    return first, compiled(_step_with_sensitivities().mapaccum("swing_along", _SAMPLES_PER_CALL, 2, {}))


def initial_vibration_state(unknowns: Expression, geometry: Expression) -> Expression:
    """The state close to the first turning point, which a parabola locates."""
    k, b_t, slip, psi, psi_dot, centre = _parts(unknowns)
    a, e, J_A = _parts(geometry)
    pull = (-b_t * psi_dot - rotational_stiffness(k, a, e) * (psi - centre)) / J_A
    psi_r = psi - psi_dot**2 / 2 / pull
    S = 2 * sliding_torque_deficit((psi - psi_r) / 2, k, slip, a, e)
    return ca.vertcat(psi, psi_dot, psi_r, 0, S, 0)


def _step_with_sensitivities() -> ca.Function:
    state = ca.SX.sym("state", len(_STATES))
    sensitivity = ca.SX.sym("sensitivity", len(_STATES), len(UNKNOWNS))
    theta, geometry = ca.SX.sym("theta", len(PARAMETERS)), ca.SX.sym("geometry", len(GEOMETRY))
    dt = ca.SX.sym("dt")
    after = vibration_step(state, theta, geometry, dt)
    seeds = ca.DM([[name == unknown for unknown in UNKNOWNS] for name in PARAMETERS])
    along = ca.jtimes(after, ca.vertcat(state, theta), ca.vertcat(sensitivity, seeds))
    return ca.Function(
        "swing_step",
        [state, sensitivity, theta, geometry, dt],
        [after, ca.densify(along)],
        ["state", "sensitivity", "theta", "geometry", "dt"],
        ["state_next", "sensitivity_next"],
        {"cse": True},
    )


def vibration_step(
    state: Expression, theta: Expression, geometry: Expression, dt: Expression
) -> Expression:
    """One step of the vibration."""
    psi, psi_dot, psi_r, S_r, S, heading = _parts(state)
    k, b_t, slip, centre = _parts(theta)
    a, e, J_A = _parts(geometry)
    K, decay = rotational_stiffness(k, a, e), b_t / (2 * J_A)
    omega = ca.sqrt(K / J_A - decay**2)
    fade, cosine, sine = ca.exp(-decay * dt), ca.cos(omega * dt), ca.sin(omega * dt) / omega
    offset, kicked = psi - centre, psi_dot + dt / 2 * S / J_A
    psi_next = centre + fade * (offset * (cosine + decay * sine) + kicked * sine)
    drifted = fade * (kicked * (cosine - decay * sine) - offset * K / J_A * sine)
    # The angle has turned about the last sample; a parabola tells where, a little before or after it.
    turned = (psi_next - psi) * heading < 0
    pull = (S - b_t * psi_dot - K * offset) / J_A
    turning = psi - psi_dot**2 / 2 / ca.if_else(turned, pull, 1)
    S_turning = S_r + 2 * sliding_torque_deficit((turning - psi_r) / 2, k, slip, a, e)
    psi_r, S_r = ca.if_else(turned, turning, psi_r), ca.if_else(turned, S_turning, S_r)
    S_next = S_r + 2 * sliding_torque_deficit((psi_next - psi_r) / 2, k, slip, a, e)
    return ca.vertcat(psi_next, drifted + dt / 2 * S_next / J_A, psi_r, S_r, S_next, psi_next - psi)
