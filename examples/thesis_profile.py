"""The simulation of [Györök 2022], section 2.2: a wheel turned by a piecewise linear torque.

    python examples/thesis_profile.py [DIR]

J_A psi'' = -b_t psi' + M_z + M with the values of the thesis's table 3.1; M_z is the exact patch. The
thesis does not print its profile. The published motion gives it back: 0.4 to 0.8 N m in 2 s, to -0.9 N m
in another two, then up by 1.1 N m/s, all times 1, 2 or 3 for mu = 0.5, 1 and 1.8. The 2 follows from the
peaks of angle and torque that the thesis names for mu = 1: they are those of mu = 0.5 doubled.

The second profile, with turns inside turns, is ours; the thesis does not describe its own. The other
examples take their recordings from here; DIR holds the published simulations, default
see published.py.
"""

import sys
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from identification import Recording
from observers import zone_history
from published import published_simulation, simulation_folder
from symbolic import Rig, TorqueProfile, Tyre, simulate_motion

RIG, K, LOAD = Rig(a=0.04, e=0.01, J_A=0.1, b_t=0.4827), 6e4, 180.0
KNOTS = ((0.0, 0.4), (2.0, 0.8), (4.0, -0.9), (6.0, 1.3))
NESTED = ((0.0, 0.4), (1.4, 0.8), (2.4, -0.4), (3.4, 0.5), (4.3, -0.2), (6.0, 0.8))
"""Time [s] and steering torque [N m] at the corners of the profile of one turn and back, and of ours."""
FACTORS = {0.5: 1.0, 1.0: 2.0, 1.8: 3.0}
"""What the thesis multiplies the torque by, for every coefficient of friction."""
SECONDS, DT = 5.11, 0.01
"""Length [s], time between samples [s]."""
SETTLED = 0.5
"""From here on errors count: before, the thesis says, the angle is too small [s]."""
PEAKS = (0.7126, 1.5129)
"""Greatest angle [rad] and torque [N m] of the thesis's simulation with mu = 1, section 4.3."""


@cache
def steered(mu: float, knots: tuple[tuple[float, float], ...] = KNOTS) -> Recording:
    """The recording that the thesis's simulation makes with one of `FACTORS`, without noise."""
    profile = TorqueProfile(t=tuple(t for t, _ in knots), M=tuple(FACTORS[mu] * M for _, M in knots))
    tyre = Tyre(k=K, mu=mu)
    motion = simulate_motion(RIG, tyre, profile, LOAD, duration=SECONDS, rate=1 / DT)
    return Recording(
        name=f"mu = {mu:g}{'' if knots is KNOTS else ', nested'}",
        t=motion.t,
        psi=motion.psi,
        psi_dot=motion.psi_dot,
        psi_dot_recorded=True,
        M_z=motion.M_z,
        F_N=np.full(motion.t.size, LOAD),
        M=motion.M,
        rig=RIG,
        tyre=tyre,
    )


def rmse(recording: Recording, mu: np.ndarray, settled: float = SETTLED) -> float:
    """Root mean square of the error of mu from a time [s] on [1]."""
    return float(np.sqrt(np.mean((mu - recording.tyre.mu)[recording.t >= settled] ** 2)))


def zones(psi: np.ndarray) -> NDArray[np.int_]:
    """How many zones the patch has at every angle: 3, and 2 more for every turn not yet wiped out."""
    return zone_history(psi, least_turn=0.0).true_zones


def main() -> None:
    """Print the peaks of both profiles, and how close the first comes to what is published."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else simulation_folder()
    for mu in FACTORS:
        for knots in (KNOTS, NESTED):
            recording = steered(mu, knots)
            print(
                f"{recording.name}: angle to {recording.psi.max():.4f} rad,"
                f" torque to {-recording.M_z.min():.4f} N m,"
                f" at most {zones(recording.psi).max()} zones"
            )
    print(f"the thesis, mu = 1: angle to {PEAKS[0]} rad, torque to {PEAKS[1]} N m")
    for mu in FACTORS:
        if columns := published_simulation(folder, mu):
            psi = columns["psi"]
            off = np.abs(steered(mu).psi - psi).max() / np.ptp(psi)
            print(f"mu = {mu:g}: angle within {off:.1%} of the published range")


if __name__ == "__main__":
    main()
