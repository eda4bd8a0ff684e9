"""Ten million samples of the filter in single precision, its state checked after each.

    python benchmarks/single_precision.py [SAMPLES]

The C that casadi makes of the filter, every number a float, runs on random but valid samples: the wheel
is turned, held and jolted between -1 and 1 rad, the load is 50 to 5000 N, the time between samples
0.1 ms to 1 s, the torque that of the tyre or noise, and every channel fails in one sample of twenty and
has outliers. The samples are shared out among filters whose tunings go to extremes. `harsh` are as many
again in which a channel also fails for hundreds of samples on end and its outliers reach 1e35.

The covariance is P = U D U' with ones on the diagonal of U: positive definite where all of D is greater
than 0. Exits with 1 where a state was not, or held a number that is not finite.
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.timing import seconds
from symbolic import compiler
from tests.observers.float32 import CASES, HARSH, NO_COMPILER, PLAIN, Outcome, Single, Trial, build

SAMPLES = 10_000_000
SEED = 2026
TRIALS = {"plain": PLAIN, "harsh": HARSH}
COLUMNS = (
    "µs",
    "missing",
    "held",
    "rejected",
    "resets",
    "on a bound",
    "least D",
    "largest D",
    "outcome",
)


def tried(filtered: Single, steps: int, trial: Trial) -> tuple[Outcome, float]:
    """What became of so many samples, and the time of each [s], samples made and states checked."""
    outcomes: list[Outcome] = []
    took = seconds(lambda: outcomes.append(filtered.drive(steps, SEED, trial)))
    return outcomes[0], took / outcomes[0].report.steps


def row(label: str, outcome: Outcome, took: float) -> str:
    """A line of the table: counts in percent of the samples, resets as they are."""
    report = outcome.report
    share = {name: 100 * getattr(report, name) / report.steps for name in (
        "missing", "held", "rejected", "bound",
    )}  # fmt: skip
    verdict = outcome.fault if outcome.fault == "sound" else f"{outcome.fault} at {report.steps}"
    return (
        f"| {label} | {1e6 * took:.1f} | {share['missing']:.0f} % | {share['held']:.0f} %"
        f" | {share['rejected']:.0f} % | {report.resets} | {share['bound']:.0f} %"
        f" | {report.least_D:.0e} | {report.greatest_D:.0e} | {verdict} |"
    )


def main() -> int:
    """Print the tables; 1 where a state was not sound."""
    if compiler() is None:
        print(f"skipped: {NO_COMPILER}")
        return 0
    samples = int(float(sys.argv[1])) if len(sys.argv) > 1 else SAMPLES
    each, done, faults = -(-samples // len(CASES)), dict.fromkeys(TRIALS, 0), dict.fromkeys(TRIALS, 0)
    print(f"| filter | trial | {' | '.join(COLUMNS)} |\n|---|---|{'---:|' * (len(COLUMNS) - 1)}---|")
    for case, case_settings in CASES.items():
        with tempfile.TemporaryDirectory() as folder:
            filtered = build(case_settings.observer, Path(folder))
            for name, trial in TRIALS.items():
                outcome, took = tried(filtered, each, trial)
                print(row(f"{case} | {name}", outcome, took), flush=True)
                done[name] += outcome.report.steps
                faults[name] += outcome.fault != "sound"
    for name in TRIALS:
        print(f"\n{name}: {done[name]} samples, {faults[name]} of {len(CASES)} filters at fault")
    return int(any(faults.values()))


if __name__ == "__main__":
    sys.exit(main())
