"""Turn until a new ground is known, and alarms where the ground stays, on the independent rig.

    python benchmarks/ground_changes.py [--bristles N]

prints how long an estimate stays usable and wrong after a change while a hand turns the wheel, and when
it is usable and right again: default tuning and tolerances, k of the truth drawn within its own. With
`--steady` friction rises or falls all the time, by the same share a second; with `--bristles N` by
bristles in place of the exact patch, N recordings of each from M_z.
"""

from argparse import ArgumentParser
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np

from benchmarks.ice import OFF, RIG, K
from observers import PROFILES, AligningTorque, Ekf, Estimates, Mhe, Status, SteeringTorque, run, smooth
from reference_rig import (
    GroundRecording,
    RigTyre,
    constant_friction,
    friction_step,
    make_ground_recording,
    make_steering_recording,
)
from symbolic import Model
from symbolic.float_array_type import Array
from tests.observers.conftest import make
from tests.observers.factories import columns_of
from tests.observers.monte_carlo import drawn
from tests.observers.surface_changes import HIGH, LOW, PLACES, counted_turn, crossing

RATES = (0.1, 0.2, 0.4, 0.8)
"""Yaw rates [rad/s]."""
RUN = 10.0
"""Length of a recording on ground that stays [s]."""
BY_HAND = (
    (1.0, 0.05), (0.3, 0.05), (0.8, 0.3), (0.8, 0.5), (1.0, 0.8), (0.08, 0.05), (0.05, 1.0), (0.3, 0.8),
)  # fmt: skip
"""Friction before and after a change under a wheel that a hand turns [1]."""
STEERED = ((0.8, 0.3), (0.8, 0.5), (0.8, 0.6), (0.08, 0.05), (0.3, 0.8))
"""The same where the steering torque is measured."""
STEADY = ((0.5, 15.0), (2.0, 15.0), (0.5, 30.0), (2.0, 30.0), (0.5, 60.0), (2.0, 60.0))
"""Friction at the end over that at the start [1], and time between [s]."""
STEADILY = ("exact", "drawn", "changing_ground", "noise", "mhe", "smooth", "M")
"""A rig as declared; then k, half-length, caster and load drawn from their tolerances, as in all others:
another tuning, the sensor's noise declared as it is, the observer, and the steering torque."""
HAND_RUNS, STEADY_RUNS, HAND_LENGTH, FIRST_SEED = {"M_z": 200, "M": 60}, 40, 20.0, 680_000
"""Recordings of each change, those of each steady one, the length of the first [s] and the first seed;
smaller seeds were used to choose."""


def changes(tuning: str) -> None:
    """A line for each change and rate."""
    observer = make(Ekf, **vars(PROFILES[tuning]))
    print(f"\n{tuning}: turn until a new ground is known within 10 %, {len(PLACES)} places")
    for before, after in ((HIGH, LOW), (LOW, HIGH)):
        for rate in RATES:
            cases = [crossing(0, place, before, after, rate) for place in PLACES]
            turns = [counted_turn(c, run(observer, **columns_of(c.made))) for c in cases]
            print(
                f"{before} -> {after} at {rate} rad/s: median {np.median(turns):.3f}, most"
                f" {max(turns):.3f} rad",
                flush=True,
            )


def by_hand(before: float, after: float, torque: str = "M_z", *, bristles: int = 0) -> None:
    """A line for a change, at a time that is drawn, while a hand turns the wheel, from M_z or M.

    With bristles in so many runs, if any. Only runs count that are usable just before the change.
    """
    seeds = range(FIRST_SEED, FIRST_SEED + (bristles or HAND_RUNS[torque]))
    with ProcessPoolExecutor() as pool:
        found = list(
            pool.map(partial(_run_by_hand, torque, before, after, bool(bristles)), seeds, chunksize=4)
        )
    rows = [row for row in found if row is not None]
    wrong, turned, again = np.array(rows).T
    print(
        f"{torque}, {before} -> {after}: usable and more than 3 deviations off for"
        f" {np.median(wrong):.2f} s, 9 of 10 {np.quantile(wrong, 0.9):.2f}, at most {wrong.max():.2f} s"
        f" and {turned.max():.3f} rad; usable and within 20 % after {np.median(again):.1f} s, 9 of 10"
        f" {np.quantile(again, 0.9, method='higher'):.1f} s, never {sum(again == np.inf)} of"
        f" {len(rows)}",
        flush=True,
    )


def _run_by_hand(
    torque: str, before: float, after: float, bristles: bool, seed: int
) -> tuple[float, float, float] | None:
    """`_after_change` of one run; None where it is not usable just before the change."""
    rng = np.random.default_rng(seed)
    when, k = float(rng.uniform(4.0, 8.0)), K * (1 + float(rng.uniform(-OFF["k"], OFF["k"])))
    friction = friction_step(when, before, after)
    tyre = RigTyre(a=RIG.a, e=RIG.e, k=k, mu=before)
    if torque == "M":
        made = make_steering_recording(seed, friction, tyre=tyre, duration=HAND_LENGTH, rate=500.0)
    else:
        made = make_ground_recording(seed, friction, tyre=tyre, duration=HAND_LENGTH)
    sensing = SteeringTorque() if torque == "M" else AligningTorque()
    observer = Ekf(
        model=Model(discretised=bristles), values={"k": K}, rig=RIG, measurement_model=sensing
    )
    found = run(observer, **columns_of(made))
    late = int(np.searchsorted(made.t, when))
    return _after_change(made, found, late) if found.usable[late - 1] else None


def _after_change(made: GroundRecording, found: Estimates, late: int) -> tuple[float, float, float]:
    """Time [s] and turn [rad] usable and wrong, and time until usable and right [s], inf for never."""
    off = np.abs(found.mu - made.mu_true)[late:]
    wrong = found.usable[late:] & (off > 3 * found.mu_std[late:])
    steps = np.abs(np.diff(made.psi_true, prepend=made.psi_true[0]))[late:]
    right = np.flatnonzero(found.usable[late:] & (off < 0.2 * made.mu_true[late:]))
    again = float(made.t[late + right[0]] - made.t[late]) if right.size else np.inf
    return float(np.count_nonzero(wrong) * np.mean(np.diff(made.t))), float(steps[wrong].sum()), again


def steadily(factor: float, seconds: float, how: str) -> None:
    """A line for friction that changes by a factor within some seconds."""
    with ProcessPoolExecutor() as pool:
        seeds = range(FIRST_SEED, FIRST_SEED + STEADY_RUNS)
        found = list(pool.map(partial(_run_steadily, factor, seconds, how), seeds, chunksize=4))
    wrong, most, usable, band = np.array(found).T
    print(
        f"{how}, x {factor} in {seconds:.0f} s: {sum(wrong > 0.01)} of {len(found)} wrong, at most"
        f" {100 * wrong.max():.0f} % of a run and {np.nanmax(most):.1f} deviations; usable"
        f" {100 * usable.mean():.0f} %, median deviation {100 * np.nanmedian(band):.1f} %",
        flush=True,
    )


def _run_steadily(
    factor: float, seconds: float, how: str, seed: int
) -> tuple[float, float, float, float]:
    """Share usable and wrong, most deviations usable, share usable, median deviation there [1]."""
    rng = np.random.default_rng([seed, 5])
    mu = float(np.exp(rng.uniform(*np.log([0.03, 1.5]))))
    off = {name: (how != "exact") * rng.uniform(-by, by) for name, by in OFF.items()}
    tyre = RigTyre(a=RIG.a + off["a"], e=RIG.e + off["e"], k=K * (1 + off["k"]), mu=mu)

    def friction(t: Array) -> Array:
        return mu * factor ** (t / seconds)

    if how == "M":
        made = make_steering_recording(seed, friction, tyre=tyre, duration=seconds, rate=500.0)
    else:
        made = make_ground_recording(seed, friction, tyre=tyre, duration=seconds)
    rig = replace(RIG, noise=0.004 * float(np.ptp(made.M_z_true))) if how == "noise" else RIG
    tuning = PROFILES["changing_ground" if how == "changing_ground" else "real_tyre"]
    sensing = SteeringTorque() if how == "M" else AligningTorque()
    kind = Mhe if how == "mhe" else Ekf
    observer = kind(model=Model(), values={"k": K}, rig=rig, measurement_model=sensing, tuning=tuning)
    columns = columns_of(made)
    columns["F_N"] = columns["F_N"] * (1 + off["load"])
    found = (smooth if how == "smooth" else run)(observer, **columns)
    off_by = np.abs(found.mu_eff - made.mu_true) / found.mu_eff_std
    usable, relative = found.usable, found.mu_eff_std / found.mu_eff
    most, band = (
        (off_by[usable].max(), np.median(relative[usable])) if usable.any() else (np.nan, np.nan)
    )
    return float(np.mean(usable & (off_by > 3))), float(most), float(usable.mean()), float(band)


def false_alarms(tuning: str, seconds: int) -> None:
    """Alarms and flags on ground that stays, friction drawn from the prior."""
    observer = make(Ekf, **vars(PROFILES[tuning]))
    alarms, flagged, runs = 0, 0, round(seconds / RUN)
    for seed in range(runs):
        recording = make_ground_recording(seed, constant_friction(drawn(seed)), duration=RUN)
        status = run(observer, **columns_of(recording)).status
        alarms += int(np.count_nonzero(status & Status.RESET))
        flagged += bool(np.any(status & Status.INCONSISTENT))
    print(f"{tuning}: {alarms} alarms in {runs * RUN:.0f} s, {flagged} of {runs} runs inconsistent")


if __name__ == "__main__":
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("--steady", action="store_true")
    parser.add_argument("--bristles", type=int, default=0)
    options = parser.parse_args()
    bristles = options.bristles
    for how in STEADILY if options.steady else ():
        for change in STEADY:
            steadily(*change, how)
    if options.steady:
        raise SystemExit
    for pair in BY_HAND:
        by_hand(*pair, bristles=bristles)
    for pair in () if bristles else STEERED:
        by_hand(*pair, torque="M")
