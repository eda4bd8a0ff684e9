"""Plant effects with the independent rig, tell `diagnose` nothing, and count what it names.

    python benchmarks/planted_effects.py --seeds 10 --controls 100 --kinds alone pairs outside

`alone`: every effect of the library by itself; `weak`: so weak that it moves the torque by 1 to 3 % of
its range, where naming nothing is right too; `pairs`: rate friction together with every other one;
`triples`: these two and asymmetric friction; `outside`: effects that no library knows, which have to be
reported as unexplained, and a relaxing torque that friction does not bound may also be matched to the
noise. It prints a line for
each run and a table: runs in which everything planted is named, or stands in `indistinguishable_from` of
what is named (outright: exactly what was planted is named); error after over the noise. A run that is
wrong says what the information criterion makes of what was planted against what was named; above zero
the recordings do not ask for it. `--out F.json` keeps the outcomes. With `--off M` every half-length
differs from the declared one by up to so much, which is then declared as its tolerance; with
`--grounds 2` the recordings stand on two grounds of different friction in turn. An hour and more on two
cores for all.
"""

import argparse
import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from identification import Diagnosis, Recording, diagnose
from identification.selection.criteria import delta_bic
from identification.selection.trial_runner import values_for
from identification.selection.trials import TrialTask, run_trial
from reference_rig import UNMODELLED_EFFECTS, make_campaign
from rig_recordings import as_read
from symbolic import EFFECTS, effects_named

NOISE = 0.004
"""White noise that the rig puts on the torque, over its range."""
PARTNER, THIRD = "rate_friction", "asymmetric_friction"
WEAKEST, STRONGEST = 0.02, 0.06
"""Rate friction of a pair is drawn from here."""
ASYMMETRY = (1.08, 1.25)
"""Ratio of friction by direction in a triple."""
WEAK = (0.01, 0.03)
"""Change of the torque by a weak effect, rms over range [1]."""
MATCHED = 1.1
"""Error after over the noise up to which recordings count as matched [1]."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """What is planted, and the seed of everything."""

    planted: tuple[str, ...]
    seed: int
    off: float = 0.0
    grounds: int = 0
    weak: bool = False

    @property
    def outside(self) -> bool:
        """Whether no library knows what is planted."""
        return any(name in UNMODELLED_EFFECTS for name in self.planted)


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What one run came to."""

    planted: tuple[str, ...]
    seed: int
    named: tuple[str, ...]
    ambiguous: tuple[str, ...]
    before: float
    after: float
    unexplained: bool
    seconds: float
    right: bool
    objection: float | None = None
    """Delta BIC of what was planted against what was named, where that is wrong."""


def run(task: Task) -> Outcome:
    """One campaign of three recordings, two for each ground of several, diagnosed."""
    rng = np.random.default_rng([task.seed, 6])
    also = {PARTNER: {"c": rng.uniform(WEAKEST, STRONGEST)}} if len(task.planted) > 1 else {}
    if len(task.planted) > 2:
        also[THIRD] = {"ratio": rng.uniform(*ASYMMETRY)}
    rig = make_campaign(
        task.planted[-1] if task.planted else None,
        task.seed,
        max(3, 2 * task.grounds),
        also=also,
        off=task.off,
        grounds=[f"ground {number}" for number in range(task.grounds)],
        shares=WEAK if task.weak else None,
    )
    began = time.perf_counter()
    recordings = [as_read(recording, rig.nominal, task.off) for recording in rig.recordings]
    diagnosis = diagnose(recordings, jobs=1)
    named = tuple(effect.name for effect in diagnosis.effects)
    ambiguous = tuple({rival for e in diagnosis.effects for rival in e.indistinguishable_from})
    after = diagnosis.after.summary()["torque_nrmse"] or np.nan
    if task.outside:
        matched = "free_branch" in task.planted and after < MATCHED * NOISE
        right = diagnosis.unexplained.present or matched
    elif task.planted:
        right = {*task.planted} <= {*named, *ambiguous} or (task.weak and not named)
    else:
        right = not named
    return Outcome(
        planted=(*task.planted, "weak") if task.weak else task.planted,
        seed=task.seed,
        named=named,
        ambiguous=ambiguous,
        before=diagnosis.before.summary()["torque_nrmse"] or np.nan,
        after=after,
        unexplained=diagnosis.unexplained.present,
        seconds=time.perf_counter() - began,
        right=right,
        objection=None if right or task.outside else _objection(task.planted, diagnosis, recordings),
    )


def _objection(planted: tuple[str, ...], diagnosis: Diagnosis, recordings: list[Recording]) -> float:
    """Delta BIC of what was planted against what was named."""
    effects = effects_named(effect.name for effect in diagnosis.effects)
    named = run_trial(TrialTask(effects, recordings, start=diagnosis.values))
    true = effects_named(planted)
    starts = (None, values_for(named, true))
    fits = [run_trial(TrialTask(true, recordings, start=start)).fitted for start in starts]
    return min(delta_bic(fit, named.fitted, recordings) for fit in fits)


def tasks_of(options: argparse.Namespace) -> list[Task]:
    """Every run that was asked for."""
    planted: list[tuple[str, ...]] = []
    if "alone" in options.kinds:
        planted += [(name,) for name in options.effects]
    if "pairs" in options.kinds:
        planted += [(PARTNER, name) for name in options.effects if name != PARTNER]
    if "triples" in options.kinds:
        rest = [name for name in options.effects if name not in (PARTNER, THIRD)]
        planted += [(PARTNER, THIRD, name) for name in rest]
    if "outside" in options.kinds:
        planted += [(name,) for name in options.outside]
    seeds = range(options.first, options.first + options.seeds)
    given = {"off": options.off, "grounds": options.grounds}
    tasks = [Task(planted=names, seed=seed, **given) for names in planted for seed in seeds]
    if "weak" in options.kinds:
        alone = [(name,) for name in options.effects]
        tasks += [Task(planted=n, seed=s, weak=True, **given) for n in alone for s in seeds]
    controls = range(options.first, options.first + options.controls)
    return tasks + [Task(planted=(), seed=seed, **given) for seed in controls]


def main() -> None:
    """Run the campaigns and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--controls", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--effects", nargs="*", default=list(EFFECTS))
    kinds = ("alone", "weak", "pairs", "triples", "outside")
    parser.add_argument("--kinds", nargs="*", choices=kinds, default=["alone"])
    parser.add_argument("--outside", nargs="*", default=list(UNMODELLED_EFFECTS))
    parser.add_argument("--off", type=float, default=0.0, help="error of half-lengths [m]")
    parser.add_argument("--grounds", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path)
    options = parser.parse_args()
    outcomes: list[Outcome] = []
    with ProcessPoolExecutor(options.jobs, mp_context=get_context("spawn")) as pool:
        for outcome in pool.map(run, tasks_of(options)):
            outcomes.append(outcome)
            print(_line(outcome), flush=True)
            if options.out:
                options.out.write_text(json.dumps([asdict(o) for o in outcomes], indent=1))
    _table(outcomes)


def _line(outcome: Outcome) -> str:
    objection = "" if outcome.objection is None else f", planted: {outcome.objection:+.1f} BIC"
    return (
        f"{'ok ' if outcome.right else 'OFF'} planted {' + '.join(outcome.planted) or '-':40}"
        f" seed {outcome.seed:3} named {', '.join(outcome.named) or '-'}"
        f" (or {', '.join(outcome.ambiguous) or '-'}) {outcome.before:.2%} -> {outcome.after:.2%}"
        f" {outcome.seconds:.0f} s{' UNEXPLAINED' if outcome.unexplained else ''}{objection}"
    )


def _table(outcomes: list[Outcome]) -> None:
    print(
        f"\n{'planted':42}{'right':>9}{'outright':>10}{'median after/noise':>20}{'greatest':>10}"
        f"{'unexplained':>13}"
    )
    for names in dict.fromkeys(outcome.planted for outcome in outcomes):
        mine = [o for o in outcomes if o.planted == names]
        ratios = [o.after / NOISE for o in mine]
        right = f"{sum(o.right for o in mine)}/{len(mine)}"
        unexplained = f"{sum(o.unexplained for o in mine)}/{len(mine)}"
        outright = f"{sum({*names} - {'weak'} == {*o.named} for o in mine)}/{len(mine)}"
        print(
            f"{' + '.join(names) or 'nothing':42}{right:>9}{outright:>10}"
            f"{np.median(ratios):>20.2f}{max(ratios):>10.2f}{unexplained:>13}"
        )


if __name__ == "__main__":
    main()
