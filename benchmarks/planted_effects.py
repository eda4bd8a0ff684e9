"""Plant effects with the independent rig, tell `diagnose` nothing, and count what it names.

    python benchmarks/planted_effects.py --seeds 10 --controls 20

prints a line for each run and a table: runs in which the planted effect is named first, or stands in the
first one's `indistinguishable_from`; error before and after over the noise. Minutes on two cores.
"""

import argparse
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from identification.diagnosis import diagnose
from symbolic import EFFECTS
from tests.identification.made import as_read
from tests.rig.campaign import campaign

NOISE = 0.004
"""White noise that the rig puts on the torque, over its range."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What one run said."""

    planted: str | None
    seed: int
    named: tuple[str, ...]
    ambiguous: tuple[str, ...]
    before: float
    after: float
    unexplained: bool

    @property
    def right(self) -> bool:
        """Named first or among the first one's equals; for a control, nothing named."""
        if self.planted is None:
            return not self.named
        return bool(self.named) and self.planted in (self.named[0], *self.ambiguous)


def run(name: str | None, seed: int) -> Outcome:
    """One campaign of three recordings, diagnosed."""
    planted = campaign(name, seed)
    found = diagnose([as_read(made, planted.nominal) for made in planted.recordings], jobs=1)
    return Outcome(
        planted=name,
        seed=seed,
        named=tuple(effect.name for effect in found.effects),
        ambiguous=found.effects[0].indistinguishable_from if found.effects else (),
        before=found.before.summary()["torque_nrmse"] or np.nan,
        after=found.after.summary()["torque_nrmse"] or np.nan,
        unexplained=found.unexplained.present,
    )


def main() -> None:
    """Run the campaigns and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--controls", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--effects", nargs="*", default=list(EFFECTS))
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.seeds)
    tasks: list[tuple[str | None, int]] = [(e, seed) for e in options.effects for seed in seeds]
    tasks += [(None, options.first + seed) for seed in range(options.controls)]
    outcomes = []
    with ProcessPoolExecutor(options.jobs, mp_context=get_context("spawn")) as pool:
        for outcome in pool.map(run, *zip(*tasks, strict=True)):
            outcomes.append(outcome)
            mark = "ok " if outcome.right else "OFF"
            print(
                f"{mark} planted {outcome.planted or '-':24} seed {outcome.seed:3}"
                f" named {', '.join(outcome.named) or '-'}"
                f" (or {', '.join(outcome.ambiguous) or '-'})"
                f" {outcome.before:.2%} -> {outcome.after:.2%}"
                f"{' UNEXPLAINED' if outcome.unexplained else ''}",
                flush=True,
            )
    print(f"\n{'planted':26}{'right':>8}{'median after/noise':>20}{'greatest':>10}")
    for name in [*options.effects, None]:
        mine = [o for o in outcomes if o.planted == name]
        if mine:
            right = sum(o.right for o in mine)
            ratios = [o.after / NOISE for o in mine]
            print(
                f"{name or 'nothing':26}{right:>4}/{len(mine):<3}"
                f"{np.median(ratios):>20.2f}{max(ratios):>10.2f}"
            )


if __name__ == "__main__":
    main()
