"""What generated C costs on a Cortex-M4F, estimated before any of it is compiled.

Counts of `benchmarks/embedded.py` in single precision, put into a formula: what a step takes, what a
bristle takes each time that the patch is evaluated, and what a window takes for each of its samples. It
is within a fifth of every row of that table. Where CasADi writes vectors, no more than the order of
magnitude is known.
"""

from dataclasses import dataclass

from observers.embedded.compact_bristle_ekf import is_compact_bristle_filter
from observers.embedded.compact_bristle_mhe import is_compact_bristle_window
from observers.embedded.compact_bristles import CompactBristles, has_bristles
from observers.embedded.compact_ekf import is_compact
from observers.embedded.compact_mhe import is_compact_window
from observers.embedded.scalar_type import SINGLE, Real
from observers.mhe import Mhe
from observers.protocol import FunctionObserver

ERROR = 0.2
"""Share by which an estimate differs from the count at most [1]."""
VECTORS = 100_000
"""Instructions that vector code takes at least."""
STEP, CORNERS, CORNER_EFFECT = 800, 300, 500
BRISTLE, LIMIT, FURTHER = 35, 26, 10
"""For each bristle and evaluation: friction alone; with creep or a limit that varies; each effect more."""
SAMPLE_EXACT, SAMPLE_BRISTLES = 600, 335
"""For each sample of a window."""
STEERING = 1.2
SOFT_DOUBLE = 40
"""Factors of the steering torque, and of double precision, which this processor's unit lacks."""


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What a step of generated C takes.

    Attributes:
        instructions: of a Cortex-M4F, on average; a lower bound where `vectors` holds.
        vectors: CasADi writes the code, as vectors: no loop is known for this observer.
        remedy: what would change that, empty where nothing need.
    """

    instructions: int
    vectors: bool
    remedy: str = ""

    def __str__(self) -> str:
        """In a line."""
        if self.vectors:
            return f"more than {self.instructions:,} instructions of a Cortex-M4F a step: {self.remedy}"
        return f"about {self.instructions:,} instructions of a Cortex-M4F a step, within {ERROR:.0%}"


def estimated_cost(observer: FunctionObserver, real: Real = SINGLE) -> Cost:
    """What a step of an observer will take."""
    factor = 1 if real is SINGLE else SOFT_DOUBLE
    if is_compact(observer) or is_compact_window(observer):
        count = STEP + CORNERS + _window(observer, SAMPLE_EXACT)
    elif is_compact_bristle_filter(observer) or is_compact_bristle_window(observer):
        patch = _bristles(observer) if has_bristles(observer) else CORNERS + CORNER_EFFECT
        count = STEP + patch + _window(observer, SAMPLE_BRISTLES)
    else:
        return Cost(instructions=VECTORS * factor, vectors=True, remedy=_remedy(observer))
    count = count * STEERING if observer.channel == "M" else count
    return Cost(instructions=round(count * factor, -2), vectors=False)


def _bristles(observer: FunctionObserver) -> int:
    """Instructions of the patch."""
    terms = CompactBristles(observer, SINGLE).terms  # type: ignore[arg-type]
    varies = bool(terms["creep"]) or terms["limited"] or terms["grows"]
    each = BRISTLE + LIMIT * varies + FURTHER * max(len(observer.model.effects) - 2, 0)
    return int(terms["bristles"] * terms["evaluations"] * each)


def _window(observer: FunctionObserver, sample: int) -> int:
    return observer.window * sample if isinstance(observer, Mhe) else 0


def _remedy(observer: FunctionObserver) -> str:
    if type(observer).__name__ not in ("Ekf", "Mhe"):
        return "CasADi's vectors are all there is for an observer of your own"
    if getattr(observer, "iterations", 1) != 1 or "stiffness" in getattr(observer, "states", ()):
        return "one iteration and no state for the stiffness are code of loops"
    if isinstance(observer, Mhe):
        return "an EKF (--observer ekf) is a tenth of it"
    return "on bristles, Model(effects=..., discretised=True) from Python, it is a tenth of it"
