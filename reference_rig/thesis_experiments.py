"""The two identification experiments of [Györök 2022], chapter 5.

Free vibration after an impact, with the thesis's rig, contact lengths and encoder (section 5.2.2); a
block towed over a plate, with the three forces of a dynamometer and their faults (table 5.1).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from reference_rig.hooks import Array
from reference_rig.patch import RigTyre
from reference_rig.sensors import FOURTEEN_BIT_STEP, quantise, sample_instants
from reference_rig.steering import Wheel

THESIS_TYRE = RigTyre(a=0.045, e=0.009, k=2.438e6, mu=1.674)
"""Tyre on steel, [Györök 2022], tables 5.1 and 5.2."""
THESIS_DAMPING = 1.04
"""Torsional damping [N m s/rad]."""
CONTACT_HALF_LENGTHS = (0.030, 0.034, 0.038, 0.042, 0.046, 0.050, 0.054)
"""Seven contact half-lengths [m]."""
IMPACTS = 5
"""Impacts at each of them."""
BRISTLES = 400
IMPACT_STEP = 2e-4
"""Step of the wheel's motion [s]."""
IMPACT_PULSE = 0.006
"""Duration of an impact [s], half a sine."""
QUIET = (0.05, 0.15)
"""Least and greatest time at rest before the impact [s]."""
_gauss_legendre = cache(np.polynomial.legendre.leggauss)
"""Nodes and weights in [-1, 1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ImpactRecording:
    """Encoder channel of one impact with the true values beside it; arrays of shape (n,).

    Time `t` [s]; yaw angle `psi` in steps of the encoder, from its own zero, and `psi_true` since rest
    [rad]; `zero`, the angle of the encoder at rest before quantisation [rad]; load `F_N` [N].
    """

    name: str
    t: Array
    psi: Array
    psi_true: Array
    zero: float
    F_N: float
    tyre: RigTyre
    wheel: Wheel


def inertia(e: float) -> float:
    """J_A of the thesis's rig at caster length e [kg m²]; e and all other lengths in metres."""
    return 0.145228 + 2.513 * (0.042 + e) ** 2


def load_at(a: float) -> float:
    """Vertical load that makes a contact of half-length a, as in the published recordings [N]."""
    return 400.0 * (a / 0.045) ** 2


def simulate_impact(
    tyre: RigTyre,
    wheel: Wheel,
    impulse: float,
    *,
    load: float,
    at: float = 0.1,
    duration: float = 1.5,
    step: float = IMPACT_STEP,
    bristles: int = BRISTLES,
) -> tuple[Array, Array]:
    """Time [s] and yaw angle [rad] of a resting wheel that is struck on a virgin patch and swings, (n,).

    Only the ends of the patch slide, and little of them, so the bristles stand at Gauss-Legendre nodes,
    which crowd there. Velocity Verlet, as in `simulate_steering`. The impulse [N m s] is the time
    integral of half a sine that begins at a time [s]; with an infinite load [N] the patch sticks.
    """
    t = np.arange(round(duration / step) + 1, dtype=np.float64) * step
    struck = (t >= at) & (t < at + IMPACT_PULSE)
    shape = np.where(struck, np.sin(np.pi * (t - at) / IMPACT_PULSE), 0.0)
    impact = (impulse * shape / (step * shape.sum())).tolist()
    nodes, weights = _gauss_legendre(bristles)
    lever = tyre.a * nodes - tyre.e
    share = tyre.k * tyre.a * weights * lever
    limit = 0.75 * load * tyre.mu / (tyre.a * tyre.k) * (1 - nodes**2)
    q, psi = np.zeros(bristles), np.zeros(len(t))
    half = 0.5 * step / wheel.J_A
    angle, rate, torque = 0.0, 0.0, impact[0]
    for i in range(1, len(t)):
        middle = rate + half * (torque - wheel.b_t * rate)
        q -= lever * (step * middle)
        np.minimum(q, limit, out=q)
        np.maximum(q, -limit, out=q)
        angle += step * middle
        torque = impact[i] + float(share @ q)
        rate = (middle + half * torque) / (1 + half * wheel.b_t)
        psi[i] = angle
    return t, psi


def make_impact(
    seed: int,
    *,
    tyre: RigTyre = THESIS_TYRE,
    wheel: Wheel | None = None,
    swing: float = 0.008,
    load: float | None = None,
    duration: float = 1.5,
    rate: float = 1000.0,
    noise: float = 0.0,
    encoder_step: float = FOURTEEN_BIT_STEP,
    step: float = IMPACT_STEP,
    bristles: int = BRISTLES,
    name: str = "impact",
) -> ImpactRecording:
    """Record one impact.

    Args:
        seed: of the strength and the side of the impact, the encoder's zero and the noise; equal
            arguments give equal recordings.
        tyre: the tyre.
        wheel: inertia and damping; None for those of the thesis.
        swing: angle to which the impact would throw the wheel without friction and damping [rad]; it
            is between 0.7 and 1.3 of that.
        load: vertical load [N]; None for that of the contact length.
        duration: length [s].
        rate: samples a second [Hz].
        noise: standard deviation of the angle before the encoder counts it [rad].
        encoder_step: angle step of the encoder [rad]; 0 for none.
        step: of the motion [s].
        bristles: number of bristles.
        name: of the recording.
    """
    rng = np.random.default_rng([seed, 21])
    wheel = wheel or Wheel(J_A=inertia(tyre.e), b_t=THESIS_DAMPING)
    load = load_at(tyre.a) if load is None else load
    stiffness = 2 * tyre.a * tyre.k * (tyre.e**2 + tyre.a**2 / 3)
    impulse = rng.choice([-1.0, 1.0]) * rng.uniform(0.7, 1.3) * swing * np.sqrt(stiffness * wheel.J_A)
    at, zero = rng.uniform(*QUIET), rng.uniform(-0.01, 0.01)
    t, psi = simulate_impact(
        tyre, wheel, impulse, load=load, at=at, duration=duration, step=step, bristles=bristles
    )
    instants = sample_instants(duration, rate)
    true = np.interp(instants, t, psi)
    seen = true + zero + noise * rng.standard_normal(len(true))
    return ImpactRecording(
        name=name,
        t=instants,
        psi=quantise(seen, encoder_step),
        psi_true=true,
        zero=zero,
        F_N=load,
        tyre=tyre,
        wheel=wheel,
    )


def make_impacts(
    seed: int,
    *,
    lengths: Sequence[float] = CONTACT_HALF_LENGTHS,
    impacts: int = IMPACTS,
    **settings: object,
) -> list[ImpactRecording]:
    """Impacts at several contact lengths, [Györök 2022], section 5.2.2; settings as of `make_impact`."""
    return [
        make_impact(
            seed * 1000 + 10 * i + j,
            tyre=replace(THESIS_TYRE, a=a),
            name=f"a{1000 * a:.0f}_{j + 1}",
            **settings,  # type: ignore[arg-type]
        )
        for i, a in enumerate(lengths)
        for j in range(impacts)
    ]


def write_impacts(folder: Path, recordings: Sequence[ImpactRecording]) -> list[Path]:
    """Write a file for every recording, as the tool reads it: its contact length, then t and psi."""
    paths = []
    for made in recordings:
        rows = (f"{t:.6g},{psi + 0.0:.8g}" for t, psi in zip(made.t, made.psi, strict=True))
        text = "\n".join([f"# a = {made.tyre.a:.6g}", "t,psi", *rows]) + "\n"
        paths.append(folder / f"{made.name}.csv")
        paths[-1].write_text(text, encoding="utf-8", newline="\n")
    return paths


def impact_rig_toml() -> str:
    """The rig file for the tool, with a first guess of k."""
    return (
        f"[rig]\na = {THESIS_TYRE.a:g}  # m; every recording has its own\ne = {THESIS_TYRE.e:g}  # m\n"
        f"J_A = {inertia(THESIS_TYRE.e):.7g}  # kg m^2\n\n[tyre]\nk = 2e+06  # a first guess, N/m^2\n"
    )


TOWING_RATE = 1000.0
"""Samples a second [Hz]."""
TOWING_LOADS = (20.0, 35.0, 50.0, 65.0, 80.0, 95.0, 110.0, 125.0, 140.0, 155.0)
"""Normal forces of the tows [N]."""


@dataclass(frozen=True, kw_only=True)
class Towing:
    """Friction of the block and errors of the dynamometer."""

    mu: float = 0.6757  # Coefficient of friction; its mean over the plate [1].
    scatter: float = 0.03  # Standard deviation of mu from tow to tow in shares of it [1].
    adhesion: float = 0.0  # Force without load [N].
    zero: float = 0.5  # Standard deviation of the sensor's zero from tow to tow, each channel [N].
    judder: float = 0.05  # Swing of the friction force in shares of it, about 12 Hz [1].
    noise: float = 1.0  # Standard deviation of every sample, each channel [N].
    duration: float = 0.8  # Length of one tow [s].


def make_tows(seed: int, towing: Towing, loads: tuple[float, ...] = TOWING_LOADS) -> list[Array]:
    """F_x, F_y, F_z of a block towed once at every load [N], (3, n), each time at another slant."""
    rng = np.random.default_rng([seed, 11])
    t = np.arange(round(towing.duration * TOWING_RATE)) / TOWING_RATE
    tows = []
    for load in loads:
        force = towing.mu * (1 + towing.scatter * rng.standard_normal()) * load + towing.adhesion
        swing = 1 + towing.judder * np.sin(2 * np.pi * (12.0 * t + rng.random()))
        slant = rng.uniform(-0.2, 0.2)
        drag = force * swing
        clean = np.vstack([drag * np.cos(slant), drag * np.sin(slant), np.full_like(t, load)])
        zeros = towing.zero * rng.standard_normal((3, 1))
        tows.append(clean + zeros + towing.noise * rng.standard_normal(clean.shape))
    return tows
