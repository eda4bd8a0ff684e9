"""What generated C costs on a Cortex-M4F, estimated before any of it is compiled.

Counts of `benchmarks/embedded.py`, put into a formula: what a step takes, what a corner of the exact
patch or a bristle takes, what a window takes for each of its samples, and what supervision adds. The
mean is that of ordinary steering, whose patch has `CORNERS` corners; the greatest is that of a patch
full of corners, or whose bristles all slide, while friction is acquired. Both are within a fifth of
what is counted, the greatest not below. Where CasADi writes vectors, no more than the order of magnitude
is known.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from observers.embedded.compact_codegen import compact_patch
from observers.embedded.patches.exact_patch import DEPTH
from observers.embedded.patches.patch_code import PatchCode
from observers.embedded.scalar_expansion import Tunable
from observers.embedded.scalar_type import SINGLE, Real
from observers.estimators.mhe import Mhe
from observers.protocol import FunctionObserver

ERROR = 0.2
"""Largest difference between estimate and count, as a share of the count [1]."""
MARGIN = 1.05
"""Factor on the estimated maximum, so that no measured count exceeds it [1]."""
CORNERS, MAX_CORNERS = 7, DEPTH - 2
"""Corners of the patch in ordinary steering, and at most."""
VECTORS = 100_000
"""Instructions that vector code takes at least, in single precision."""
SOFT_DOUBLE = 40
"""Factor of double precision on these, which this processor's unit lacks."""


COUNTS: Mapping[str, tuple[Any, Any]] = {
    "step": (1_020, 28_000),  # An EKF without its patch.
    "corner": (82, 5_700),  # Each corner of the exact patch.
    "drop": (1_200, 52_000),  # Where there are too many, that one is dropped.
    "bristle": ((31, 40), (1_500, 2_400)),  # Each bristle.
    "compliant": ((17, 20), (900, 1_500)),  # More for each bristle behind a compliance.
    "limit": ((45, 45), (3_000, 3_000)),  # More for a limit that varies.
    "branch": ((23, 25), (1_000, 1_000)),  # More for a Maxwell branch.
    "stiffness_bristle": (15, 650),  # More where k is a state.
    "stiffness_sample": (140, 5_300),  # The same for each sample of a window.
    "creep": ((35, 56), (4_000, 6_600)),  # More for creep.
    "creep_compliant": ((46, 89), (22_300, 43_100)),  # The same behind a compliance: it is searched for.
    "sample": (354, 14_700),  # Each sample of a window on the exact patch.
    "sample_corner": (62, 5_400),  # Each corner of it.
    "sample_bristles": (316, 13_500),  # Each sample of a window on bristles.
    "tracking": (1_150, 38_000),  # More with supervision.
    "stiffness": (170, 6_000),  # More of a filter whose k is a state.
    # The same at most, and at most with a tuning at run time.
    "acquiring": ((8_350, 8_900), (592_000, 647_000)),
    "tunable": (300, 10_000),  # More for a tuning at run time.
    "tunable_sample": (220, 8_000),  # The same for each sample of a window.
}
"""Instructions of the parts of a step, in single and in double precision; pairs are in the mean, and at
most."""
Counts = Mapping[str, Any]
NOT_COUNTED = ("limited", "grows", "relaxation")
"""Traits of bristles that were not counted in double precision."""
STEERING, STEERING_SAMPLE, STEERING_CORNER = 1.44, 3.25, 1.29
"""Factors of the steering torque on a step, on a sample of a window, and on a corner of it."""
GEAR, GEAR_ACQUIRING = 600, 1_600
"""Instructions for the friction of a car's gear: of a step, and more while friction is acquired."""
RIG_CORNER = 1.48
"""Factor on a corner of a rig that is taken at run time."""


@dataclass(frozen=True, kw_only=True)
class InstructionsPerStep:
    """What a step of generated C takes."""

    # Of a Cortex-M4F in ordinary steering, on average; at least, where `vectors` holds; None where none
    # of its kind was counted.
    instructions: int | None
    at_most: int | None = None  # In any step; None where that is not known.
    # For each corner of the patch, `corners` in ordinary steering and `most_corners` at most, which is
    # in the numbers above; 0 on bristles.
    corner: int = 0
    corners: int = CORNERS
    most_corners: int = MAX_CORNERS
    acquiring: int = 0  # For the longest step while friction is acquired, which is in `at_most`.
    # Share by which a count differs at most [1]; None where that is not known.
    error: float | None = None
    vectors: bool = False  # CasADi writes the code, as vectors: no loop is known for this observer.
    remedy: str = ""  # What would change that, empty where nothing need.

    def __str__(self) -> str:
        """In a line."""
        if self.instructions is None:
            return "instructions of such a step were not counted; benchmarks/embedded.py counts them"
        count = f"{self.instructions:,} instructions of a Cortex-M4F a step"
        if self.vectors:
            return f"more than {count}: {self.remedy}"
        most = f", at most {self.at_most:,}" if self.at_most else ""
        count = f"about {count} in ordinary steering{most}"
        if self.error is not None:
            count += f", within {self.error:.0%}"
        if self.corner:
            count += f"; {self.corner:,} for each corner of the patch, from {self.corners} to"
            count += f" {self.most_corners}"
        return count


def estimated_instructions(
    observer: FunctionObserver, real: Real = SINGLE, tunable: Tunable = ""
) -> InstructionsPerStep:
    """What a step of an observer will take; `tunable` as for `generate`."""
    factor = 1 if real is SINGLE else SOFT_DOUBLE
    patch = compact_patch(observer, SINGLE)
    if patch is None:
        return InstructionsPerStep(
            instructions=VECTORS * factor, vectors=True, remedy=_advice_for_loop_code(observer)
        )
    if tunable == "all" and not patch.takes_rig:
        remedy = "take the tuning alone at run time (--tunable tuning), a tenth of that or less"
        return InstructionsPerStep(instructions=VECTORS * factor, vectors=True, remedy=remedy)
    effects = patch.observer.model.effects
    counts = {part: each[real is not SINGLE] for part, each in COUNTS.items()}
    on_bristles = bool(patch.terms["bristles"])
    if isinstance(observer, Mhe) and effects and not on_bristles:
        return InstructionsPerStep(instructions=None)
    step, corner = _step_and_corner_instructions(patch, counts, tunable)
    corner *= not on_bristles
    acquiring = counts["acquiring"][bool(tunable)] + GEAR_ACQUIRING * ("gear" in patch.observer.states)
    acquiring *= patch.observer.acquire
    mean = step + counts["tracking"] * patch.observer.acquire + CORNERS * corner
    # From the steering torque no corner is dropped in the longest step.
    drops = bool(corner) and "psi" not in patch.observer.states
    most = step + acquiring + MAX_CORNERS * corner + counts["drop"] * drops
    if on_bristles:
        mean += _bristle_instructions(patch, counts, 0)
        most += _bristle_instructions(patch, counts, 1)
    counted = real is SINGLE or not any(patch.terms.get(name) for name in NOT_COUNTED)
    return InstructionsPerStep(
        instructions=int(round(mean, -2)), at_most=int(round(MARGIN * most, -2)),
        corner=round(corner), acquiring=acquiring, error=ERROR if counted else None,
    )  # fmt: skip


def _step_and_corner_instructions(
    patch: PatchCode, counts: Counts, tunable: Tunable
) -> tuple[float, float]:
    """Instructions of a step without patch and supervision, and of each corner of the patch."""
    states, window = patch.observer.states, getattr(patch.observer, "window", 0)
    steered = "psi" in states
    sample = float(counts["sample_bristles"] if patch.terms["bristles"] else counts["sample"])
    sample = sample * (STEERING_SAMPLE if steered else 1.0) + counts["tunable_sample"] * bool(tunable)
    step = counts["step"] * (STEERING if steered else 1.0) + counts["tunable"] * bool(tunable)
    step += GEAR * ("gear" in states) + counts["stiffness"] * ("stiffness" in states)
    sample += counts["stiffness_sample"] * ("stiffness" in states)
    corner = counts["corner"] + window * counts["sample_corner"] * (STEERING_CORNER if steered else 1.0)
    return step + window * sample, corner * (RIG_CORNER if tunable == "all" else 1.0)


def _bristle_instructions(patch: PatchCode, counts: Counts, column: int) -> float:
    """Instructions of the bristles, in the mean or at most."""
    terms = patch.terms
    each = counts["bristle"][column] + counts["compliant"][column] * bool(terms["compliant"])
    each += counts["limit"][column] * bool(terms["limited"] or terms["grows"])
    each += counts["branch"][column] * bool(terms["relaxation"])
    each += counts["stiffness_bristle"] * bool(terms["by_k"])
    creep = counts["creep_compliant"] if terms["compliant"] else counts["creep"]
    return float(terms["bristles"] * (each + creep[column] * bool(terms["creep"])))


def _advice_for_loop_code(observer: FunctionObserver) -> str:
    """What to change, so that loops are written."""
    if type(observer).__name__ not in ("Ekf", "Mhe"):
        return "an observer of your own has CasADi's vectors alone"
    if getattr(observer, "iterations", 1) != 1:
        return "one iteration is written as loops"
    if getattr(observer, "window", 2) < 2:
        return "an MHE of two samples and more is written as loops"
    return "effects that the library has are written as loops"
