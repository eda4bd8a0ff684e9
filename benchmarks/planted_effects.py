"""Plant effects with the independent rig, tell `diagnose` nothing, and count what it names.

    python benchmarks/planted_effects.py --seeds 10 --controls 100 --kinds alone pairs outside

`alone`: every effect of the library by itself; `pairs`: rate friction together with every other one;
`other_pairs`: two other effects, drawn by the seed; `outside`: effects that no library knows, which
have to be reported as unexplained, and a relaxing torque that friction does not bound may also be
matched to the noise; `laws`: a mechanism that the library knows by another formula, where its family has
to be named; `law_pairs`: such a law of friction over speed beside another effect.

It prints a line for each run and a table: runs in which everything planted is named, or stands in
`indistinguishable_from` of what is named (outright: exactly what was planted is named); runs in which
exactly the planted families are said to be missing, by strong or ambiguous effects; families that are
not, and effects too many, over all runs; error after over the noise. A run that is wrong says what the
information criterion makes of what was planted against what was named; above zero the recordings do not
ask for it. `--out F.json` keeps the outcomes. With `--off M` every half-length differs from the declared
one by up to so much, which is declared as its tolerance where it is more than the usual one; with
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

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from identification import Diagnosis, FoundEffect, Recording, diagnose
from identification.selection.criteria import delta_bic
from identification.selection.trial import TrialTask, run_trial
from identification.selection.trial_runner import start_values
from reference_rig import (
    MECHANISMS,
    OTHER_LAWS,
    UNMODELLED_EFFECTS,
    make_campaign,
    plant_effect,
)
from rig_recordings import as_read
from symbolic import CANDIDATES, EFFECTS, USUAL, effects_named

NOISE = 0.004
"""White noise that the rig puts on the torque, over its range."""
PARTNER = "rate_friction"
WEAKEST, STRONGEST = 0.02, 0.06
"""Rate friction of a pair is drawn from here."""
LAW_PARTNERS = (
    "carcass_torsion", "pressure_power", "torque_offset", "smooth_asymmetry", "torque_lag",
    "contact_damping",
)  # fmt: skip
MATCHED = 1.1
"""Error over the noise up to which recordings count as matched: nothing need be named then [1]."""


@dataclass(frozen=True, kw_only=True)
class Task:
    """What is planted, and the seed of everything."""

    planted: tuple[str, ...]
    seed: int
    off: float = 0.0
    grounds: int = 0

    @property
    def outside(self) -> bool:
        """Whether no library knows what is planted."""
        return any(name in UNMODELLED_EFFECTS for name in self.planted)

    @property
    def other_law(self) -> bool:
        """Whether the library knows what is planted by another formula."""
        return any(name in OTHER_LAWS for name in self.planted)


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
    missing: tuple[str, ...] = ()
    """Planted families that are not named."""
    too_many: int = 0
    """Effects named beyond one for each planted one of the same family."""
    objection: float | None = None
    """Delta BIC of what was planted against what was named, where that is wrong."""


def run(task: Task) -> Outcome:
    """One campaign of three recordings, two for each ground of several, diagnosed."""
    rng = np.random.default_rng([task.seed, 6])
    also = {PARTNER: {"c": rng.uniform(WEAKEST, STRONGEST)}} if len(task.planted) > 1 else {}
    if also and task.planted[0] != PARTNER:
        first = task.planted[0]
        also = {first: plant_effect(first, task.seed).effects[first]}
    rig = make_campaign(
        task.planted[-1] if task.planted else None,
        task.seed,
        max(3, 2 * task.grounds),
        also=also,
        off=task.off,
        grounds=[f"ground {number}" for number in range(task.grounds)],
    )
    began = time.perf_counter()
    tolerance = task.off if task.off > USUAL["a"] else None
    recordings = [as_read(recording, rig.nominal, tolerance) for recording in rig.recordings]
    diagnosis = diagnose(recordings, jobs=1)
    named = tuple(effect.name for effect in diagnosis.effects)
    ambiguous = tuple({rival for e in diagnosis.effects for rival in e.indistinguishable_from})
    after = diagnosis.after.summary()["torque_nrmse"] or np.nan
    before = diagnosis.before.summary()["torque_nrmse"] or np.nan
    families = [_family(name) for name in task.planted if not task.outside]
    invisible = not said_of(diagnosis) and before < MATCHED * NOISE
    missing, too_many = families_of(diagnosis, [] if invisible else families)
    if task.outside:
        matched = "free_branch" in task.planted and after < MATCHED * NOISE
        right = diagnosis.unexplained.present or matched
    elif task.other_law:
        right = not missing
    elif task.planted:
        right = {*task.planted} <= {*named, *ambiguous}
    else:
        right = not named
    return Outcome(
        planted=task.planted,
        seed=task.seed,
        named=named,
        ambiguous=ambiguous,
        before=before,
        after=after,
        unexplained=diagnosis.unexplained.present,
        seconds=time.perf_counter() - began,
        right=right,
        missing=missing,
        too_many=too_many,
        objection=None
        if right or task.outside or task.other_law
        else _objection(task.planted, diagnosis, recordings),
    )


def said_of(diagnosis: Diagnosis) -> list[FoundEffect]:
    """The effects that are said to be missing."""
    return [effect for effect in diagnosis.effects if effect.grade in ("strong", "ambiguous")]


def families_of(diagnosis: Diagnosis, planted: list[str]) -> tuple[tuple[str, ...], int]:
    """Planted families of which nothing is named, nor a rival, and how many effects are too many."""
    missing, too_many = list(planted), 0
    for effect in sorted(said_of(diagnosis), key=lambda effect: effect.family not in planted):
        names = [effect.family, *(_family(rival) for rival in effect.indistinguishable_from)]
        matched = next((name for name in names if name in missing), None)
        if matched is None:
            too_many += 1
        else:
            missing.remove(matched)
    return tuple(f for f in missing if missing.count(f) == planted.count(f)), too_many


def _family(name: str) -> str:
    return MECHANISMS.get(name) or CANDIDATES[name].family


def _objection(planted: tuple[str, ...], diagnosis: Diagnosis, recordings: list[Recording]) -> float:
    """Delta BIC of what was planted against what was named."""
    effects = effects_named(effect.name for effect in diagnosis.effects)
    named = run_trial(TrialTask(effects, recordings, start=diagnosis.values))
    true = effects_named(planted)
    starts = (None, start_values(named, true))
    fits = [run_trial(TrialTask(true, recordings, start=start)).fitted for start in starts]
    return min(delta_bic(fit, named.fitted, recordings) for fit in fits)


def tasks_of(options: argparse.Namespace) -> list[Task]:
    """Every run that was asked for."""
    planted: list[tuple[str, ...]] = []
    if "alone" in options.kinds:
        planted += [(name,) for name in options.effects]
    if "pairs" in options.kinds:
        planted += [(PARTNER, name) for name in options.effects if name != PARTNER]
    if "laws" in options.kinds:
        planted += [(name,) for name in OTHER_LAWS]
    if "law_pairs" in options.kinds:
        speed = [name for name, family in MECHANISMS.items() if family == "friction over speed"]
        planted += [(law, name) for law in speed for name in LAW_PARTNERS]
    if "outside" in options.kinds:
        planted += [(name,) for name in options.outside]
    seeds = range(options.first, options.first + options.seeds)
    given = {"off": options.off, "grounds": options.grounds}
    tasks = [Task(planted=names, seed=seed, **given) for names in planted for seed in seeds]
    if "other_pairs" in options.kinds:
        others = [name for name in options.effects if name != PARTNER]
        drawn = [np.random.default_rng(seed).choice(others, 2, replace=False) for seed in seeds]
        tasks += [
            Task(planted=tuple(pair.tolist()), seed=seed, **given)
            for seed, pair in zip(seeds, drawn, strict=True)
        ]
    controls = range(options.first, options.first + options.controls)
    return tasks + [Task(planted=(), seed=seed, **given) for seed in controls]


def main() -> None:
    """Run the campaigns and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--controls", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--effects", nargs="*", default=list(EFFECTS))
    kinds = ("alone", "pairs", "other_pairs", "laws", "law_pairs", "outside")
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
        f"{f' {outcome.too_many} too many' if outcome.too_many else ''}"
        f"{f' missing {outcome.missing}' if outcome.missing else ''}"
    )


def _table(outcomes: list[Outcome]) -> None:
    print(
        f"\n{'planted':42}{'right':>9}{'outright':>10}{'families':>10}{'missing':>9}{'too many':>9}"
        f"{'median after/noise':>20}{'greatest':>10}"
        f"{'unexplained':>13}"
    )
    groups = [
        [o for o in outcomes if o.planted == names]
        for names in dict.fromkeys(o.planted for o in outcomes)
    ]
    for mine in [*groups, outcomes]:
        names = mine[0].planted if mine is not outcomes else ("all",)
        ratios = [o.after / NOISE for o in mine]
        right = f"{sum(o.right for o in mine)}/{len(mine)}"
        unexplained = f"{sum(o.unexplained for o in mine)}/{len(mine)}"
        outright = f"{sum({*names} == {*o.named} for o in mine)}/{len(mine)}"
        exactly = f"{sum(not o.missing and not o.too_many for o in mine)}/{len(mine)}"
        missing, many = sum(len(o.missing) for o in mine), sum(o.too_many for o in mine)
        print(
            f"{' + '.join(names) or 'nothing':42}{right:>9}{outright:>10}"
            f"{exactly:>10}{missing:>9}{many:>9}"
            f"{np.median(ratios):>20.2f}{max(ratios):>10.2f}{unexplained:>13}"
        )


if __name__ == "__main__":
    main()
