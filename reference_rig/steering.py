"""The wheel with its inertia, turned by a steering torque: J_A psi'' = -b_t psi' + M_z + M."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from reference_rig.ground import BRISTLES, Friction, InPlacePatch, constant_friction
from reference_rig.hooks import Array
from reference_rig.patch import RigTyre
from reference_rig.path import STEP_RATE, Hand, hand_path
from reference_rig.sensors import FOURTEEN_BIT_STEP, record_channels, require_instants, sample_instants

MOTION_STEP = 1e-4
"""Step of the wheel's motion [s]; it swings at about 5 Hz."""


@dataclass(frozen=True, kw_only=True)
class Wheel:
    """Inertia about the kingpin J_A [kg m²] and torsional damping b_t [N m s]."""

    J_A: float = 0.15
    b_t: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Grip:
    """The arms behind the hands: M = stiffness (psi_ref - psi) + damping (psi_ref' - psi').

    Its lag is about M/stiffness. No grip at all leaves an imposed torque.
    """

    stiffness: float = 200.0  # [N m/rad]
    damping: float = 8.0  # [N m s/rad]


LOOSE = Grip(stiffness=0.0, damping=0.0)
WIDE = Hand(amplitude=0.6, first=0.5)
TEMPO = 2.0
"""The hand's path is run through this much faster than where the angle is imposed [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SteeredMotion:
    """Motion of the wheel at every step; arrays of shape (n,).

    Time [s], yaw angle [rad] and rate [rad/s], steering torque `M` and moment of the ground `M_z` [N m],
    load [N], friction coefficient [1].
    """

    t: Array
    psi: Array
    psi_dot: Array
    M: Array
    M_z: Array
    F_N: Array
    mu: Array

    def at(self, times: Array) -> "SteeredMotion":
        """The motion at other times [s], linear between the steps."""
        require_instants(times, self.t)
        moved = {name: np.interp(times, self.t, values) for name, values in vars(self).items()}
        return SteeredMotion(**{**moved, "t": times})


@dataclass(frozen=True, kw_only=True, eq=False)
class SteeringRecording:
    """Channels of the sensors with the true values beside them; arrays of shape (n,).

    Time `t` [s], yaw angle `psi` in steps of the encoder [rad], and with noise the steering torque `M`
    [N m] and the load `F_N` [N]. The true values are as in `SteeredMotion`; tyre, whose `mu` is the
    friction at the first sample, and wheel are true too.
    """

    name: str
    t: Array
    psi: Array
    M: Array
    F_N: Array
    psi_true: Array
    psi_dot_true: Array
    M_true: Array
    F_N_true: Array
    M_z_true: Array
    mu_true: Array
    tyre: RigTyre
    wheel: Wheel


def full_slide_moment(tyre: RigTyre, friction_force: float) -> float:
    """Size of M_z when all bristles slide, for |e| <= a and mu F_N [N].

    The mean of |x - e| over the parabola: a (3/8) (1 + 2 (e/a)² - (e/a)⁴/3).
    """
    share = (tyre.e / tyre.a) ** 2
    return 3 / 8 * friction_force * tyre.a * (1 + 2 * share - share**2 / 3)


def simulate_steering(
    command: Array,
    F_N: Array,
    mu: Array,
    *,
    step: float = MOTION_STEP,
    tyre: RigTyre | None = None,
    wheel: Wheel | None = None,
    grip: Grip = LOOSE,
    bristles: int = BRISTLES,
) -> SteeredMotion:
    """Move a wheel from rest on a virgin patch with the torque M = command - K_p psi - K_d psi'.

    Velocity Verlet; the damping is taken with the velocity at both ends of the step in turn, which
    keeps the second order and is solved in closed form.

    Args:
        command: torque at angle and rate zero [N m], shape (n,).
        F_N: vertical load [N], shape (n,).
        mu: friction coefficient [1], shape (n,).
        step: between two entries of these [s].
        tyre: a, e and k; None for the rig's usual ones.
        wheel: inertia and damping; None for the usual ones.
        grip: K_p and K_d; by default none, so that the command is the torque.
        bristles: number of bristles.
    """
    wheel, patch, n = wheel or Wheel(), InPlacePatch(tyre or RigTyre(), bristles), len(command)
    damping, half = wheel.b_t + grip.damping, 0.5 * step / wheel.J_A
    divisor = 1 + half * damping
    psi, psi_dot, M_z = np.zeros(n), np.zeros(n), np.zeros(n)
    commands, forces = command.tolist(), (mu * F_N).tolist()
    angle, rate, torque = 0.0, 0.0, commands[0]
    for i in range(1, n):
        middle = rate + half * (torque - damping * rate)
        moment = patch.turn(step * middle, forces[i])
        angle += step * middle
        torque = commands[i] - grip.stiffness * angle + moment
        rate = (middle + half * torque) / divisor
        psi[i], psi_dot[i], M_z[i] = angle, rate, moment
    M = command - grip.stiffness * psi - grip.damping * psi_dot
    return SteeredMotion(
        t=np.arange(n, dtype=np.float64) * step, psi=psi, psi_dot=psi_dot, M=M, M_z=M_z, F_N=F_N, mu=mu
    )


def make_steering_recording(
    seed: int,
    friction: Friction | None = None,
    *,
    tyre: RigTyre | None = None,
    wheel: Wheel | None = None,
    torque: Array | Callable[[Array], Array] | None = None,
    hand: Hand | None = None,
    grip: Grip | None = None,
    load: float = 400.0,
    duration: float = 10.0,
    rate: float = 1000.0,
    times: Array | None = None,
    noise: float = 0.004,
    encoder_step: float = FOURTEEN_BIT_STEP,
    step: float = MOTION_STEP,
    bristles: int = BRISTLES,
    name: str = "steering",
) -> SteeringRecording:
    """Steer the wheel and record it; seed, load, noise and encoder are as in `make_recording`.

    Args:
        seed: of the hand's path, the load and the noise.
        friction: friction over time; None for the tyre's.
        tyre: the tyre; None for the rig's usual one.
        wheel: inertia and damping; None for the usual ones.
        torque: imposed torque [N m]: samples at the rate, linear between, or a function of time
            [s]; None for a hand that follows a path.
        hand: how that path runs, at double tempo; None for turns into full slide.
        grip: how hard the hand follows it; None for the usual way.
        load: mean vertical load [N].
        duration: length [s].
        rate: samples a second [Hz].
        times: sampling instants [s], increasing, in place of the rate.
        noise: of the torque channel.
        encoder_step: of the angle [rad].
        step: of the motion [s].
        bristles: their number.
        name: of the recording.
    """
    tyre = tyre or RigTyre()
    path = hand_path(seed, duration * TEMPO, hand=hand or WIDE, load=load, rate=STEP_RATE)
    path = replace(path, t=path.t / TEMPO, psi_dot=path.psi_dot * TEMPO)
    t = np.arange(round(duration / step) + 1, dtype=np.float64) * step
    instants = sample_instants(duration, rate)
    if torque is None:
        grip = grip or Grip()
        followed = path.at(t)
        command = grip.stiffness * followed.psi + grip.damping * followed.psi_dot
    else:
        grip = LOOSE
        if not callable(torque) and np.shape(torque) != instants.shape:
            raise ValueError(f"the torque needs {len(instants)} samples, not shape {np.shape(torque)}")
        command = torque(t) if callable(torque) else np.interp(t, instants, torque)
    mu = (friction or constant_friction(tyre.mu))(t)
    F_N = np.interp(t, path.t, path.F_N)
    motion = simulate_steering(
        command, F_N, mu, step=step, tyre=tyre, wheel=wheel, grip=grip, bristles=bristles
    )
    seen = motion.at(instants if times is None else times)
    psi, M, load_shown = record_channels(
        seed, seen.psi, seen.M, seen.F_N, noise=noise, encoder_step=encoder_step
    )
    return SteeringRecording(
        name=name,
        t=seen.t,
        psi=psi,
        M=M,
        F_N=load_shown,
        psi_true=seen.psi,
        psi_dot_true=seen.psi_dot,
        M_true=seen.M,
        F_N_true=seen.F_N,
        M_z_true=seen.M_z,
        mu_true=seen.mu,
        tyre=replace(tyre, mu=float(seen.mu[0])),
        wheel=wheel or Wheel(),
    )
