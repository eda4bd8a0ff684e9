"""Turn until a new ground is known, and alarms where the ground stays, on the independent rig."""

import numpy as np
from numpy.typing import NDArray

from observers import PROFILES, Ekf, Estimates, Status, run
from reference_rig import constant_friction, make_ground_recording
from tests.observers.conftest import make
from tests.observers.factories import columns_of
from tests.observers.monte_carlo import drawn
from tests.observers.surface_changes import HIGH, LOW, PLACES, Crossing, crossing

Array = NDArray[np.float64]
CLOSE = 0.1
"""Share of mu within which an estimate counts as right [1]."""
STICK = 0.1
"""Turn after a reversal that does not count, as the patch sticks [rad]."""
RATES = (0.1, 0.2, 0.4, 0.8)
"""Yaw rates [rad/s]."""
RUN = 10.0
"""Length of a recording on ground that stays [s]."""


def turn_since_reversal(psi: Array) -> Array:
    """Turn since the last reversal at every sample [rad]."""
    steps = np.diff(psi, prepend=psi[0])
    turns, since, side = np.zeros(psi.size), 0.0, 0.0
    for i, step in enumerate(steps):
        if step != 0 and np.sign(step) != side:
            since, side = 0.0, np.sign(step)
        since += abs(step)
        turns[i] = since
    return turns


def counted_turn(case: Crossing, estimates: Estimates) -> float:
    """Turn after the change, not counting stick, until mu is close for good [rad]; inf for never."""
    recording = case.made
    steps = np.abs(np.diff(recording.psi_true, prepend=recording.psi_true[0]))
    counts = (turn_since_reversal(recording.psi_true) > STICK) & (recording.t >= case.when)
    turned = np.cumsum(steps * counts)
    late = recording.t >= case.when
    off = np.flatnonzero(late & (np.abs(estimates.mu / case.after - 1) > CLOSE))
    if off.size == 0:
        return 0.0
    return float(turned[off[-1] + 1]) if off[-1] + 1 < turned.size else float("inf")


def changes(tuning: str) -> None:
    """A line for each change and rate."""
    observer = make(Ekf, **{name: getattr(PROFILES[tuning], name) for name in _fields()})
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


def false_alarms(tuning: str, seconds: int) -> None:
    """Alarms and flags on ground that stays, friction drawn from the prior."""
    observer = make(Ekf, **{name: getattr(PROFILES[tuning], name) for name in _fields()})
    alarms, flagged, runs = 0, 0, round(seconds / RUN)
    for seed in range(runs):
        recording = make_ground_recording(seed, constant_friction(drawn(seed)), duration=RUN)
        status = run(observer, **columns_of(recording)).status
        alarms += int(np.count_nonzero(status & Status.RESET))
        flagged += bool(np.any(status & Status.INCONSISTENT))
    print(f"{tuning}: {alarms} alarms in {runs * RUN:.0f} s, {flagged} of {runs} runs inconsistent")


def _fields() -> tuple[str, ...]:
    return tuple(vars(PROFILES["real_tyre"]))
