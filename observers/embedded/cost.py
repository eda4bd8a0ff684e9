"""What generated C costs on a Cortex-M4F, estimated before any of it is compiled.

Counts of `benchmarks/embedded.py` in single precision, put into a formula: what a step takes, what a
bristle takes each time that the patch is evaluated, what a window takes for each of its samples, and
what supervision adds. It is within a fifth of what is counted in single precision while friction is
tracked. Where CasADi writes vectors, no more than the order of magnitude is known.
"""

from dataclasses import dataclass

from observers.embedded.compact import compact_patch
from observers.embedded.constants import Tunable
from observers.embedded.patches.interface import PatchCode
from observers.embedded.scalar_type import SINGLE, Real
from observers.estimators.mhe import Mhe
from observers.protocol import FunctionObserver

ERROR = 0.2
"""Share by which an estimate in single precision differs from the count at most [1]."""
VECTORS = 100_000
"""Instructions that vector code takes at least."""
STEP, CORNERS, CORNER_EFFECT = 800, 300, 500
BRISTLE, LIMIT, FURTHER = 33, 21, 6
"""For each bristle and evaluation: friction alone; a limit that varies; each effect beyond two."""
SAMPLE_EXACT, SAMPLE_BRISTLES = 550, 325
"""For each sample of a window."""
TUNABLE_STEP, TUNABLE_SAMPLE = 220, 260
"""What these take more where the tuning is taken at run time."""
TRACKING, ACQUIRING = 650, 13_200
"""What supervision takes more while the estimator tracks, and at most while friction is acquired."""
STEERING = 1.15
SOFT_DOUBLE = 40
"""Factors of the steering torque, and of double precision, which this processor's unit lacks."""


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What a step of generated C takes.

    Attributes:
        instructions: of a Cortex-M4F, on average; at least, where `vectors` holds; None where none of
            its kind was counted.
        acquiring: what the longest step takes more while friction is acquired.
        error: share by which the count differs at most [1]; None where that is not known.
        vectors: CasADi writes the code, as vectors: no loop is known for this observer.
        remedy: what would change that, empty where nothing need.
    """

    instructions: int | None
    acquiring: int = 0
    error: float | None = None
    vectors: bool = False
    remedy: str = ""

    def __str__(self) -> str:
        """In a line."""
        if self.instructions is None:
            return "instructions of such a step were not counted; benchmarks/embedded.py counts them"
        count = f"{self.instructions:,} instructions of a Cortex-M4F a step"
        more = f"; up to {self.acquiring:,} more while friction is acquired" if self.acquiring else ""
        if self.vectors:
            return f"more than {count}: {self.remedy}{more}"
        if self.error is None:
            return f"of the order of {count}{more}"
        return f"about {count}, within {self.error:.0%}{more}"


def estimated_cost(observer: FunctionObserver, real: Real = SINGLE, tunable: Tunable = "") -> Cost:
    """What a step of an observer will take; `tunable` as for `generate`."""
    single = real is SINGLE
    factor = 1 if single else SOFT_DOUBLE
    patch = compact_patch(observer, SINGLE)
    if patch is None:
        return Cost(instructions=VECTORS * factor, vectors=True, remedy=_remedy(observer))
    if tunable == "all" and not patch.takes_rig:
        remedy = "take the tuning alone at run time (--tunable tuning), a tenth of that or less"
        return Cost(instructions=VECTORS * factor, vectors=True, remedy=remedy)
    steered, effects = "psi" in patch.observer.states, patch.observer.model.effects
    window = 0
    if isinstance(observer, Mhe):
        if steered or (effects and not patch.terms["bristles"]):
            return Cost(instructions=None)
        each = SAMPLE_BRISTLES if patch.terms["bristles"] else SAMPLE_EXACT
        window = observer.window * (each + TUNABLE_SAMPLE * bool(tunable))
    of_patch = CORNERS + CORNER_EFFECT * bool(effects)
    if patch.terms["bristles"]:
        of_patch = _bristles(patch)
    step = STEP + TUNABLE_STEP * bool(tunable) + TRACKING * patch.observer.acquire
    count = (step + of_patch + window) * (STEERING if steered else 1) * factor
    known = single and (patch.terms["bristles"] or not effects)
    return Cost(
        instructions=int(round(count, -2)),
        acquiring=ACQUIRING * factor * patch.observer.acquire,
        error=ERROR if known else None,
    )


def _bristles(patch: PatchCode) -> int:
    """Instructions of the patch."""
    terms = patch.terms
    varies = bool(terms["creep"]) or terms["limited"] or terms["grows"]
    each = BRISTLE + LIMIT * varies + FURTHER * max(len(patch.observer.model.effects) - 2, 0)
    return int(terms["bristles"] * (2 if terms["compliant"] else 1) * each)


def _remedy(observer: FunctionObserver) -> str:
    """What to change, so that loops are written."""
    if type(observer).__name__ not in ("Ekf", "Mhe"):
        return "an observer of your own has CasADi's vectors alone"
    if getattr(observer, "iterations", 1) != 1:
        return "one iteration is written as loops"
    if getattr(observer, "window", 2) < 2:
        return "an MHE of two samples and more is written as loops"
    if "stiffness" in getattr(observer, "states", ()):
        return "a stiffness that is known is written as loops"
    return "effects that the library has are written as loops"
