"""Turn until a new ground is known, and alarms where the ground stays, on the independent rig."""

import numpy as np

from observers import PROFILES, Ekf, Status, run
from reference_rig import constant_friction, make_ground_recording
from tests.observers.conftest import make
from tests.observers.factories import columns_of
from tests.observers.monte_carlo import drawn
from tests.observers.surface_changes import HIGH, LOW, PLACES, counted_turn, crossing

RATES = (0.1, 0.2, 0.4, 0.8)
"""Yaw rates [rad/s]."""
RUN = 10.0
"""Length of a recording on ground that stays [s]."""


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
