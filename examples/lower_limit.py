"""The least friction that a rig can tell
======================================

How little friction a rig can tell: by the noise of its torque sensor, the sensor's zero, dry friction
between sensor and patch, and load; and how far the wheel turns until friction is usable.

.. code-block:: sh

    python examples/lower_limit.py [PICTURE.png]

A run is told where friction is usable within a turn of 0.5 rad and its 95 % band holds 95 % of the
usable samples; a friction is, where half of the runs on it and on every greater one are. The torque is
that of the independent rig's bristles. Errors are declared to the observer but in the last table.
"""

import sys
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from brushgrip.pictures.style import TRACKS, figure_saved_as_png, legend_above
from observers import Ekf, run
from reference_rig import Hand, RigRecording, make_recording
from symbolic import Model, Rig, Tolerances, full_slide_torque


class SteeredTyre(NamedTuple):
    """Half-length and caster [m], k [N/m^2] and load [N]."""

    a: float
    e: float
    k: float
    load: float


class SensorErrors(NamedTuple):
    """Noise of a sample, zero, and dry friction, at the kingpin [N m]."""

    noise: float
    zero: float
    dry: float


class RunOutcome(NamedTuple):
    """Turn [rad] and time [s] until usable; the band holds; usable and beyond 3 sigma."""

    turn: float = np.inf
    time: float = np.inf
    held: bool = False
    wrong: bool = False


GROUNDS = {"ice": 0.05, "snow": 0.2, "wet": 0.5, "dry": 0.9}
MUS = tuple(np.geomspace(0.01, 0.9, 14).round(4).tolist())
LOW = MUS[2:6]
SEEDS, MANY, TURN = range(6), range(24), 0.5
LOADS, SHARES = (0.25, 0.5, 1.0, 2.0), (0.0005, 0.002, 0.01, 0.04, 0.15)
"""Loads over the usual one, and errors over full slide at mu = 1 [1]."""
SMALL, CAR = SteeredTyre(0.045, 0.009, 2.4e6, 400.0), SteeredTyre(0.075, 0.02, 5e6, 4000.0)
CASES = {
    "rig": (SMALL, SensorErrors(0.02, 0.02, 0.02)),
    "car, torque of the column": (CAR, SensorErrors(2.0, 2.0, 15.0)),  # the gear: 125 N at 0.12 m
    "car, torque at the tie rod": (CAR, SensorErrors(2.0, 2.0, 2.0)),
}


@cache
def exact(wheel: SteeredTyre, mu: float, seed: int) -> RigRecording:
    """A recording without errors."""
    settings = {**wheel._asdict(), "mu": mu, "duration": 8.0, "noise": 0.0}
    return make_recording(seed, **settings, bristles=200, hand=Hand())


@cache
def outcome(
    wheel: SteeredTyre, errors: SensorErrors, mu: float, seed: int, *, declared: bool = True
) -> RunOutcome:
    """One run of the filter; without errors declared it reckons with usual ones."""
    made, rng = exact(wheel, mu, seed), np.random.default_rng(seed)
    M_z = made.M_z - errors.dry * np.tanh(np.gradient(made.psi, made.t) / 0.005)
    M_z = M_z + errors.zero * rng.uniform(-1, 1) + errors.noise * rng.standard_normal(M_z.size)
    rig = Rig(a=wheel.a, e=wheel.e)
    if declared:
        zero = Tolerances(zero=errors.zero)
        rig = replace(rig, noise=errors.noise, dry_friction=errors.dry, tolerances=zero)
    ekf = Ekf(model=Model(), values={"k": wheel.k}, rig=rig)
    estimates = run(ekf, made.t, made.psi, made.F_N, M_z)
    usable, off = estimates.usable, np.abs(estimates.mu - mu) / estimates.mu_std
    if not usable.any():
        return RunOutcome()
    first, turn = int(np.argmax(usable)), np.cumsum(np.abs(np.diff(made.psi, prepend=0.0)))
    held, wrong = np.mean(off[usable] < 1.96) >= 0.95, np.mean(usable & (off > 3)) > 0.01
    return RunOutcome(float(turn[first]), float(made.t[first]), bool(held), bool(wrong))


def least(wheel: SteeredTyre, errors: SensorErrors) -> float:
    """The least mu of `MUS` that is told, as are all above; inf for none."""
    told = np.inf
    for mu in reversed(MUS):
        runs = [outcome(wheel, errors, mu, seed) for seed in SEEDS]
        if sum(one.held and one.turn <= TURN for one in runs) * 2 < len(runs):
            break
        told = mu
    return told


def shares(wheel: SteeredTyre, share: float) -> SensorErrors:
    """Three errors that are this share of full slide at mu = 1."""
    return SensorErrors(*[share * float(full_slide_torque(wheel.load, wheel.a))] * 3)


def row(*cells: object) -> None:
    """Print a table's row."""
    texts = (f"{cell:.3g}" if isinstance(cell, float) else str(cell) for cell in cells)
    print(f"| {' | '.join(texts)} |".replace("inf rad, inf s", "never").replace("inf", "never"))


def draw(
    path: Path, found: Mapping[tuple[str, str], list[float]], turns: Mapping[str, list[float]]
) -> None:
    """The least mu by each error, and the turn until usable by ground; never is on top."""
    titles = {"noise": "noise of a sample", "zero": "zero of the sensor", "dry": "dry friction"}
    styles = dict(zip(CASES, zip(TRACKS, "osd", strict=False), strict=True))
    marks = {**{mu: f"{mu:g}" for mu in (0.02, 0.05, 0.1, 0.2, 0.5, 1)}, 2: "never"}
    with figure_saved_as_png(path, 7.5) as figure:
        *panels, last = figure.subplots(2, 2).flat
        for (case, name), limit in found.items():
            axes, (colour, marker) = panels[[*titles].index(name)], styles[case]
            axes.loglog(SHARES, np.minimum(limit, 2), f"{marker}--", color=colour, mfc="none")
            axes.set(
                xlabel=f"{titles[name]} over full slide at μ = 1 [1]",
                ylabel="least μ told [1]",
                ylim=(0.015, 2.5),
            )
            axes.set_yticks([*marks], [*marks.values()])
            axes.minorticks_off()
        for case, (colour, marker) in styles.items():
            turn = np.minimum(turns[case], TURN)
            last.plot([*GROUNDS], turn, marker, color=colour, mfc="none", label=case)
        last.set_ylabel("turn until usable, all three errors [rad]")
        last.set_yticks([0, 0.1, 0.2, 0.3, 0.4, TURN], ["0", "0.1", "0.2", "0.3", "0.4", "never"])
        legend_above(figure, last.lines)


def main() -> None:
    """Print the least friction, turn and time until usable on four grounds, and what is wrong."""
    found, turns = {}, {}
    row("least mu by an error over full slide at mu = 1", *SHARES)
    for case in ("rig", "car, torque at the tie rod"):
        wheel = CASES[case][0]
        for name in SensorErrors._fields:
            best = shares(wheel, SHARES[0])
            each = [best._replace(**{name: shares(wheel, share).noise}) for share in SHARES]
            found[case, name] = [least(wheel, errors) for errors in each]
            row(f"{case.partition(',')[0]}, {name} alone", *found[case, name])
    print()
    row("all three errors", *(f"least mu at load × {part:g}" for part in LOADS), *GROUNDS)
    for case, (wheel, errors) in CASES.items():
        limits = [least(wheel._replace(load=part * wheel.load), errors) for part in LOADS]
        runs = [[outcome(wheel, errors, mu, seed) for seed in SEEDS] for mu in GROUNDS.values()]
        turns[case], times = (np.median(runs, axis=1)[:, i].tolist() for i in (0, 1))
        row(case, *limits, *(f"{r:.3f} rad, {t:.1f} s" for r, t in zip(turns[case], times, strict=True)))
    print()
    row("all three errors 0.01 of full slide, mu 0.02 to 0.06", "runs", "usable", "usable and wrong")
    for wheel, declared in product((SMALL, CAR), (True, False)):
        tasks = [(wheel, shares(wheel, 0.01), mu, seed) for mu in LOW for seed in MANY]
        low = [outcome(*task, declared=declared) for task in tasks]
        usable, wrong = sum(one.turn < np.inf for one in low), sum(one.wrong for one in low)
        title = f"{wheel.load:g} N, {'' if declared else 'not '}declared"
        row(title, len(low), usable, wrong)
    if sys.argv[1:]:
        draw(Path(sys.argv[1]), found, turns)


if __name__ == "__main__":
    main()
