"""Know friction with the least steering
======================================

How far must a wheel turn until friction is known to 5 %? A ``Probe`` leads the independent rig's wheel
on four grounds, none of which it knows; beside it the sine that one would steer by hand.

.. code-block:: sh

    python examples/least_steering.py [PICTURE.png]

:doc:`/start/least_steering` tells how to plan, what it costs and what cannot be reached.
"""

import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from brushgrip.pictures.style import TRACKS, figure_saved_as_png
from observers import AligningTorque, Ekf, Loop, Probe, Sample, SteeringLimits, profile
from reference_rig import RigTyre, SteeredWheel
from symbolic import Model, Rig, Tolerances

GROUNDS = {"ice": 0.07, "snow": 0.2, "wet": 0.5, "dry": 0.9}
A, E, K, LOAD, DT, NOISE = 0.045, 0.009, 2.4e6, 400.0, 0.01, 0.03
"""Lengths [m], k [N/m^2], load [N], time between samples [s], noise of the torque [N m]."""
KNOWN = Tolerances(a=5e-4, e=5e-4, load=0.01, k=0.1 * K)
TARGET, LIMITS, MAX_TIME = 0.05, SteeringLimits(angle=0.4, rate=0.5, time=6.0), 10.0


class Way(NamedTuple):
    """Angle [rad] and travel [rad] at each sample, and mu as found in the end [1]."""

    psi: list[float]
    travel: list[float]
    mu: float


def steer(observer: Ekf, mu: float, command: Callable[[Sample, Loop, float], float]) -> Way:
    """A wheel under a command (sample, loop, time) -> next angle, until friction is known."""
    wheel, loop = SteeredWheel(RigTyre(a=A, e=E, k=K, mu=mu), load=LOAD), Loop(observer)
    rng = np.random.default_rng(1)
    psi, way = 0.0, Way([0.0], [0.0], np.nan)
    for step in range(int(MAX_TIME / DT)):
        torque = wheel.turn(psi, DT) + NOISE * rng.standard_normal()
        rate = (psi - way.psi[-1]) / DT
        sample = Sample(psi=psi, psi_dot=rate, F_N=LOAD, dt=DT, M_z=torque)
        now = loop(sample)
        way.travel.append(way.travel[-1] + abs(psi - way.psi[-1]))
        way.psi.append(psi)
        if now.usable and now.mu_eff_std <= TARGET * now.mu_eff:
            return way._replace(mu=now.mu_eff)
        psi = command(sample, loop, step * DT)
    return way._replace(travel=[*way.travel[:-1], np.inf])


def led(observer: Ekf) -> Callable[[Sample, Loop, float], float]:
    """As a Probe says."""
    probe = Probe(observer, TARGET, LIMITS)
    return lambda sample, loop, _: probe(sample, loop.state).psi


def draw(path: Path, ways: dict[str, tuple[Way, Way]]) -> None:
    """The angle over time, led by a Probe, and the travel until friction is known."""
    with figure_saved_as_png(path, 3.4) as figure:
        angle, travel = figure.subplots(1, 2)
        for place, ((ground, found), colour) in enumerate(zip(ways.items(), TRACKS, strict=True)):
            psi = found[0].psi
            angle.plot(
                DT * np.arange(len(psi)), psi, color=colour, label=f"{ground}, μ = {GROUNDS[ground]:g}"
            )
            angle.plot(DT * (len(psi) - 1), psi[-1], "o", color=colour)
            for way, name, shift, alpha in zip(
                found, ("Probe", "sine"), (0.2, -0.2), (1.0, 0.35), strict=True
            ):
                travel.barh(place + shift, way.travel[-1], 0.36, color=colour, alpha=alpha)
                text = f"{way.travel[-1]:.2f}, {name}"
                travel.text(way.travel[-1] + 0.01, place + shift, text, va="center", fontsize=8)
        angle.set(xlabel="time t [s]", ylabel="angle ψ, led by a Probe [rad]")
        angle.legend(loc="lower left")
        travel.set_yticks(range(len(ways)), [*ways])
        travel.margins(x=0.2)
        travel.set_xlabel("travel until σ/μ is 5 % [rad]")


def main() -> None:
    """Print how far the wheel turns on each ground."""
    rig = Rig(a=A, e=E, tolerances=KNOWN)
    # A little steering tells k and mu apart badly: where k is a state, sigma knows that.
    torque = AligningTorque(stiffness=True)
    observer = Ekf(
        model=Model(), values={"k": K}, rig=rig, tuning=profile("clean"), measurement_model=torque
    )
    ways = {
        ground: (
            steer(observer, mu, led(observer)),
            steer(observer, mu, lambda _, __, t: 0.4 * np.sin(0.75 * t)),
        )
        for ground, mu in GROUNDS.items()
    }
    print("| ground | mu | turn, led by a Probe | found | turn in a sine | found |")
    for ground, (by_probe, by_sine) in ways.items():
        print(f"| {ground} | {GROUNDS[ground]} | {by_probe.travel[-1]:.3f} rad | {by_probe.mu:.3f}"
              f" | {by_sine.travel[-1]:.3f} rad | {by_sine.mu:.3f} |")  # fmt: skip
    if sys.argv[1:]:
        draw(Path(sys.argv[1]), ways)


if __name__ == "__main__":
    main()
