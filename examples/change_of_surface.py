"""The ground changes under a turning wheel
========================================

The ground changes under a turning wheel, mu from 1.2 to 0.5: how far until an observer knows?

.. code-block:: sh

    python examples/change_of_surface.py [PICTURE.png]

The wheel turns out, back and out again; on the way back the friction drops. The torque is the model's,
with white noise of 0.4 % of its range. The observers are tuned to that: an innovation beyond five times
its noise is rejected, and five in a row are a change of the ground. The default tuning, made for models
that are wrong by far more than that, notices the change too.

Two patches are compared. The exact one keeps its memory in units of mu, so it reads all of the past at
the present mu: right where the ground stays, wrong for what the old ground has left in the patch.
Bristles keep what the ground did. Within 0.1 rad of a reversal the torque hardly tells mu, see
`observability.py`.
"""

import sys
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from brushgrip.pictures.style import AFTER, BEFORE, MEASURED, figure_saved_as_png, legend_above
from observers import AligningTorque, Ekf, Estimates, Mhe, Observer, Status, Tuning, run
from symbolic import Model, Rig, simulate

RIG, K, LOAD = Rig(a=0.045, e=0.009), 2.4e6, 400.0
FROM, TO = 1.2, 0.5
"""Friction coefficient before and after the change [1]."""
CORNERS = (0.0, 0.25, -0.25, 0.25)
"""Angles between which the wheel turns [rad]."""
RATE, DT = 0.4, 0.01
"""Yaw rate [rad/s] and time between samples [s]."""
NOISE = 0.004
"""Standard deviation of the torque noise over the torque's range [1]."""
CLOSE = 0.05
"""Share of mu within which an estimate counts as right [1]."""
PLACES = (0.05, 0.1, 0.15, 0.25, 0.35, 0.45)
"""Turns since the first reversal at which the ground changes [rad]."""
MIDDLE = 0.35
"""The one that is drawn: in mid-turn, well away from both reversals."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Drive:
    """What happens to the wheel; arrays of shape (n,).

    Attributes:
        t: time [s].
        psi: yaw angle [rad].
        turned: angle turned since the start, to and fro [rad].
        mu: true friction coefficient [1].
        M_z: measured aligning torque [N m].
    """

    t: np.ndarray
    psi: np.ndarray
    turned: np.ndarray
    mu: np.ndarray
    M_z: np.ndarray


def drive(place: float, before: float = FROM, after: float = TO) -> Drive:
    """The wheel turned, with the ground changing so far after the first reversal [rad]."""
    legs = [np.linspace(a, b, round(abs(b - a) / RATE / DT) + 1)[1:] for a, b in pairwise(CORNERS)]
    psi = np.concatenate([CORNERS[:1], *legs])
    turned = np.cumsum(np.abs(np.diff(psi, prepend=psi[0])))
    mu = np.where(turned < CORNERS[1] + place, before, after)
    # Friction acts as mu F_N alone: at mu = 1 the load mu F_N makes the torque that F_N makes at mu.
    signals = np.vstack([psi, np.gradient(psi, DT), mu * LOAD, np.full(psi.size, DT)])
    M_z = simulate(Model(), signals, np.array([1.0, K]), np.array([RIG.a, RIG.e])).M_z
    noise = NOISE * np.ptp(M_z) * np.random.default_rng(1).standard_normal(psi.size)
    return Drive(t=np.arange(psi.size) * DT, psi=psi, turned=turned, mu=mu, M_z=M_z + noise)


def observers(model: Model, tuning: Tuning) -> dict[str, Observer]:
    """Both; the zero of the torque is known."""
    measurement_model = AligningTorque(zero=False)
    kinds = {"EKF": Ekf, "MHE": Mhe}
    return {
        name: kind(
            model=model, values={"k": K}, rig=RIG, tuning=tuning, measurement_model=measurement_model
        )
        for name, kind in kinds.items()
    }


def further_turn(motion: Drive, estimates: Estimates) -> float:
    """How far the wheel turns after the change until mu is close, and stays close [rad]."""
    final = motion.mu[-1]
    change = int(np.argmax(motion.mu == final))
    off = np.flatnonzero(np.abs(estimates.mu[change:] - final) > CLOSE * final)
    right = change + (int(off[-1]) + 1 if off.size else 0)
    if right >= motion.t.size:
        return float("inf")
    return float(motion.turned[right] - motion.turned[change - 1])


def draw(path: Path, motion: Drive, estimates_by_kind: dict[str, Estimates]) -> None:
    """Friction and torque over the angle turned."""
    with figure_saved_as_png(path, 5.0) as figure:
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=[3, 2])
        lines = above.plot(motion.turned, motion.mu, color=MEASURED, lw=1.0, label="true μ")
        looks = zip(estimates_by_kind.items(), ((BEFORE, "-"), (AFTER, (0, (3, 2)))), strict=True)
        for (name, estimates), (colour, stroke) in looks:
            label = f"{name}, ± 2 standard deviations"
            lines += above.plot(
                motion.turned, estimates.mu, color=colour, ls=stroke, lw=1.8, label=label
            )
            reach = 2 * estimates.mu_std
            low, high = estimates.mu - reach, estimates.mu + reach
            above.fill_between(motion.turned, low, high, color=colour, alpha=0.15, lw=0)
        above.set(ylim=(0, 2), ylabel="friction coefficient μ [1]")
        below.plot(motion.turned, motion.M_z, color=MEASURED, lw=0.9)
        below.set(
            ylabel="aligning torque\n$M_z$ [N m]",
            xlabel="angle turned since the start, to and fro [rad]",
        )
        below.margins(x=0.01)
        figure.align_ylabels()
        legend_above(figure, lines)


# The torque's range is about twice its level in full slide, which is mu times the unit of noise.
CLEAN = Tuning(noise=NOISE * 2 * FROM, error=float("inf"), gate=5)
RUNS = (
    ("exact patch", Model(), CLEAN, (FROM, TO)),
    ("bristles", Model(discretised=True), CLEAN, (FROM, TO)),
    ("bristles, friction rises", Model(discretised=True), CLEAN, (TO, FROM)),
    ("bristles, default tuning", Model(discretised=True), Tuning(), (FROM, TO)),
)
"""Name, patch, tuning, and friction before and after."""


def main() -> None:
    """Print how far the wheel turns until a change is known, for changes at several places."""
    print(f"further turn until within {CLOSE:.0%} for good (inf: not before the end), and resets")
    middle = None
    for name, model, tuning, (before, after) in RUNS:
        print(f"{f'{name}, {before} -> {after}, after the reversal':>58}{'EKF':>20}{'MHE':>20}")
        for place in PLACES:
            motion = drive(place, before, after)
            load = np.full(motion.t.size, LOAD)
            pairs = observers(model, tuning).items()
            estimates_by_kind = {
                kind: run(o, motion.t, motion.psi, load, motion.M_z) for kind, o in pairs
            }
            row = f"{place:54.2f} rad"
            for estimates in estimates_by_kind.values():
                resets = np.count_nonzero(estimates.status & Status.RESET)
                row += f"{further_turn(motion, estimates):11.3f} rad,{resets:4d}"
            print(row)
            if (name, place) == ("bristles", MIDDLE):
                middle = motion, estimates_by_kind
    if middle is not None:
        turns = (f"{kind} after {further_turn(middle[0], e):.3f} rad" for kind, e in middle[1].items())
        print(f"known in mid-turn, bristles: {', '.join(turns)}")
        if sys.argv[1:]:
            draw(Path(sys.argv[1]), *middle)


if __name__ == "__main__":
    main()
