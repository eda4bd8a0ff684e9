"""Ground whose friction changes with time under an imposed angle, quick enough for hundreds of runs."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from reference_rig.hooks import Array, RigDrive
from reference_rig.patch import RigTyre, lay_out
from reference_rig.path import SAMPLE_RATE, STEP_RATE, hand_path
from reference_rig.recording import RigRecording
from reference_rig.sensors import ENCODER_STEP, record_channels, require_instants, sample_instants

Friction = Callable[[Array], Array]
"""Friction coefficient [1] at times [s]; same shape."""

BRISTLES = 400
WALK_KNOT = 1e-3
"""A random walk is linear between knots this far apart [s], whatever the sampling."""


class InPlacePatch:
    """Bristles as elastoplastic stops, turned in place: a few microseconds a step."""

    def __init__(self, tyre: RigTyre, bristles: int = BRISTLES) -> None:
        """Lay the bristles out free of deformation; the tyre's own mu is not used."""
        grid = lay_out(replace(tyre, mu=1.0), (), bristles)
        # Each bristle counts its stretch in stretches that one newton of mu F_N holds: its state
        # is then the friction force at which it would just slide, and one scalar clips them all.
        self._rate = grid.lever / grid.limit
        self._share = grid.share * grid.limit
        self._state = np.zeros_like(grid.lever)
        self._turned = np.empty_like(grid.lever)

    def turn(self, angle: float, friction_force: float) -> float:
        """M_z [N m] after a turn [rad] on a ground that holds friction_force = mu F_N [N] at its end.

        Where the limit has fallen, the deformation is cut to it; where it has risen, it stays.
        """
        np.multiply(self._rate, angle, out=self._turned)
        np.subtract(self._state, self._turned, out=self._state)
        np.minimum(self._state, friction_force, out=self._state)
        np.maximum(self._state, -friction_force, out=self._state)
        return float(self._share @ self._state)


@dataclass(frozen=True, kw_only=True, eq=False)
class GroundRecording(RigRecording):
    """A recording on changing ground; `tyre.mu` is the friction at the first sample."""

    mu_true: Array  # Friction coefficient [1], shape (n,).


def constant_friction(mu: float) -> Friction:
    """The same friction throughout."""
    return lambda t: np.full_like(t, mu)


def friction_step(when: float, before: float, after: float) -> Friction:
    """Friction that is `before` until the time `when` [s] and `after` from it on."""
    return lambda t: np.where(t < when, before, after)


def friction_between(t: Array, mu: Array) -> Friction:
    """Friction given at times of one's own choice, linear between them."""
    return lambda at: np.interp(at, t, mu)


def simulate_ground(drive: RigDrive, mu: Array, tyre: RigTyre, *, bristles: int = BRISTLES) -> Array:
    """Aligning torque [N m], shape (n,), of a tyre on ground whose friction mu [1] has that shape.

    One step of the patch a sample of the drive; the tyre's own mu is not used.
    """
    patch = InPlacePatch(tyre, bristles)
    angles = np.diff(drive.psi, prepend=drive.psi_virgin).tolist()
    forces = (mu * drive.F_N).tolist()
    return np.array([patch.turn(*step) for step in zip(angles, forces, strict=True)])


def make_ground_recording(
    seed: int,
    friction: Friction,
    *,
    drive: RigDrive | None = None,
    tyre: RigTyre | None = None,
    duration: float = 10.0,
    rate: float = SAMPLE_RATE,
    times: Array | None = None,
    noise: float = 0.004,
    encoder_step: float = ENCODER_STEP,
    bristles: int = BRISTLES,
) -> GroundRecording:
    """Steer the rig on changing ground and record it.

    Args:
        seed: of the path and of the noise; equal arguments give equal recordings.
        friction: friction over time.
        drive: what is done, in steps fine enough for the friction; None for a hand's path.
        tyre: a, e and k; None for the rig's usual ones.
        duration: of the hand's path [s].
        rate: samples a second [Hz].
        times: sampling instants within the drive [s], increasing, in place of the rate.
        noise: standard deviation of the torque channel in shares of the torque's range [1];
            0 also silences the load.
        encoder_step: angle step of the encoder [rad]; 0 for none.
        bristles: number of bristles.
    """
    drive = drive or hand_path(seed, duration, rate=STEP_RATE)
    if times is None:
        times = drive.t[0] + sample_instants(drive.t[-1] - drive.t[0], rate)
    require_instants(times, drive.t)
    # Instants are among the steps, so that samples are exact.
    drive = drive.at(np.union1d(drive.t, times))
    mu = friction(drive.t)
    seen = np.searchsorted(drive.t, times)
    M_z = simulate_ground(drive, mu, tyre or RigTyre(), bristles=bristles)[seen]
    psi, F_N = drive.psi[seen], drive.F_N[seen]
    seen_psi, seen_M_z, seen_F_N = record_channels(
        seed, psi, M_z, F_N, noise=noise, encoder_step=encoder_step
    )
    return GroundRecording(
        name="ground",
        t=times,
        psi=seen_psi,
        M_z=seen_M_z,
        F_N=seen_F_N,
        psi_true=psi,
        psi_dot_true=drive.psi_dot[seen],
        psi_patch=psi,
        M_z_true=M_z,
        F_N_true=F_N,
        mu_true=mu[seen],
        tyre=replace(tyre or RigTyre(), mu=float(mu[seen[0]])),
        effects={},
    )
