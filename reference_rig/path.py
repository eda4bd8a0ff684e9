"""Angle paths as a hand steers them, and the vertical load that goes with them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from reference_rig.hooks import Array, RigDrive

SAMPLE_RATE = 100
SUBSTEPS = 4
"""Steps of the patch a sample: the wheel also turns, and turns back, between samples."""
STEP_RATE = float(SAMPLE_RATE * SUBSTEPS)
"""Steps of the patch a second [Hz]."""


MIN_HAND_RATE, MAX_HAND_RATE = 0.03, 0.35
"""Turning speed of a hand away from its reversals [rad/s]."""


@dataclass(frozen=True, kw_only=True)
class Hand:
    """Style of turning the wheel by hand."""

    amplitude: float = 0.45  # Largest angle [rad].
    first: float = 0.25  # First reversal in shares of the amplitude [1].
    pace: float = 0.17  # Typical turning speed [rad/s].
    nesting: float = 0.35  # Probability that a turn is interrupted by a short way back [1].
    quiet: float = 0.5  # Time before the first turn [s].


def hand_path(
    seed: int,
    duration: float = 14.0,
    *,
    hand: Hand | None = None,
    load: float = 400.0,
    rate: float = 400.0,
) -> RigDrive:
    """Steer a wheel by hand: quiet start, growing turns, nested loops, uneven speed.

    Args:
        seed: of the generator; equal seeds give equal paths.
        duration: length [s].
        hand: how it is turned; None for the usual way.
        load: mean vertical load [N]; it wanders by 5 % at most.
        rate: samples a second [Hz].

    Returns:
        The true angle, rate and load, without encoder steps or noise.
    """
    rng = np.random.default_rng([seed, 1])
    hand = hand or Hand()
    n = round(duration * rate) + 1
    pieces = [np.zeros(round(hand.quiet * rate))]
    length, here = len(pieces[0]), 0.0
    for target in _targets(rng, hand):
        pieces.append(_turn(rng, target - here, hand.pace, rate))
        length, here = length + len(pieces[-1]), target
        if length >= n:
            break
    psi_dot = np.concatenate(pieces)[:n]
    psi = np.concatenate([[0.0], np.cumsum(0.5 * (psi_dot[1:] + psi_dot[:-1]) / rate)])
    t = np.arange(n) / rate
    return RigDrive(
        t=t, psi=psi, psi_dot=psi_dot, F_N=load * _load_share(rng, t, psi, psi_dot), psi_virgin=0.0
    )


def _targets(rng: np.random.Generator, hand: Hand) -> Iterator[float]:
    """Angles at which the hand reverses [rad], growing, with short ways back in between."""
    side = rng.choice([-1.0, 1.0])
    share, here = hand.first * rng.uniform(0.8, 1.2), 0.0
    while True:
        target = side * hand.amplitude * min(share, 1.0) * rng.uniform(0.85, 1.0)
        if rng.random() < hand.nesting:
            halt = here + rng.uniform(0.45, 0.75) * (target - here)
            yield halt
            yield halt - rng.uniform(0.15, 0.5) * (halt - here)
        yield target
        here, side = target, -side
        share = share * rng.uniform(1.25, 1.9) if share < 1 else rng.uniform(0.45, 1.0)


def _turn(rng: np.random.Generator, angle: float, pace: float, rate: float) -> Array:
    """Turning speed of one turn through an angle [rad/s]; now and then it begins with a rest."""
    speed = np.clip(pace * rng.lognormal(0.0, 0.3), 1.5 * MIN_HAND_RATE, 0.7 * MAX_HAND_RATE)
    ramp = min(rng.uniform(0.25, 0.6), 0.8 * abs(angle) / speed)
    count = max(round((abs(angle) / speed + ramp) * rate), 8)
    time = np.arange(count) / rate
    unevenness = np.exp(0.22 * _slow_noise(rng, time, 0.35) + 0.12 * _slow_noise(rng, time, 0.12))
    even = np.clip(speed * unevenness, MIN_HAND_RATE, MAX_HAND_RATE)
    edge = np.minimum(time + 0.5 / rate, time[-1] + 0.5 / rate - time) / ramp
    shape = even * np.sin(0.5 * np.pi * np.clip(edge, 0, 1)) ** 2
    rest = round(rng.uniform(0.1, 0.5) * rate) if rng.random() < 0.3 else 0
    return np.concatenate([np.zeros(rest), shape * (angle * rate / shape.sum())])


def _load_share(rng: np.random.Generator, t: Array, psi: Array, psi_dot: Array) -> Array:
    """Load over its mean: slow wander, and a dip that grows along every turn."""
    progress, last, turned = np.empty_like(psi), 0.0, 0.0
    for i in range(len(psi)):
        step = psi[i] - psi[max(i - 1, 0)]
        turned = turned + step if psi_dot[i] * last >= 0 else step
        last = psi_dot[i] if psi_dot[i] else last
        progress[i] = abs(turned)
    dip = np.tanh(progress / 0.35)
    decay, level = np.exp(-(t[1] - t[0]) / 0.25), 0.0
    for i in range(len(dip)):
        level = decay * level + (1 - decay) * dip[i]
        dip[i] = level
    wander = np.tanh(0.6 * _slow_noise(rng, t, 4.0)) - 0.3 * t / t[-1]
    return 1 + 0.026 * wander - 0.03 * (dip - 0.5)


def _slow_noise(rng: np.random.Generator, t: Array, time: float) -> Array:
    """Smooth noise of about unit level with a correlation time [s]: cosine between random knots."""
    count = int(t[-1] / time) + 3
    knots = rng.standard_normal(count)
    place = t / time + rng.random()
    left = place.astype(int)
    blend = 0.5 - 0.5 * np.cos(np.pi * (place - left))
    return (1 - blend) * knots[left] + blend * knots[left + 1]


def free_path(t: Array, psi: Array, *, load: float | Array = 400.0, rate: float = STEP_RATE) -> RigDrive:
    """Path through angles [rad] at times [s], shape (n,), linear between; virgin at the first.

    One load [N] for all or each; the rate is that of the patch's steps [Hz].
    """
    fine = t[0] + np.arange(round((t[-1] - t[0]) * rate) + 1) / rate
    angle = np.interp(fine, t, psi)
    return RigDrive(
        t=fine,
        psi=angle,
        psi_dot=np.gradient(angle, fine),
        F_N=np.interp(fine, t, np.broadcast_to(load, np.shape(t))),
        psi_virgin=float(psi[0]),
    )


def constant_turn(psi_dot: float, duration: float, *, load: float = 400.0) -> RigDrive:
    """Turn at a constant rate [rad/s] for a duration [s]."""
    ends = np.array([0.0, duration])
    return free_path(ends, psi_dot * ends, load=load)
