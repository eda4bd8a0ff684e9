"""What is mu_eff +- sigma worth where the model is wrong, and how soon is a new ground known?

    python benchmarks/friction_bands.py --model measured_output/model.json --runs 200

Measured recordings (where `BRUSHGRIP_DATA` has them): share of the informed samples whose 95 % band
holds the recording's own mu_eff at the end, and that of the model found fitted to the whole recording
offline, median sigma over mu, time until mu_eff stays within 10 %
of its end, pairs on one ground, with the declared model and with --model, tuned by its `model_error`.

Independent rig: effects that nobody declares, the declared model and the usual tuning: runs that are
flagged INCONSISTENT or whose band holds the true mu_eff in 90 % of the informed samples. The same with
the model that was found, k and effect known, tuned by its error on another recording. Then every
profile: the turn until a new ground is known, and alarms on ground that stays. A quarter of an hour.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.bands_on_rig import found_models, undeclared_effects
from benchmarks.ground_changes import changes, false_alarms
from brushgrip.estimation.friction_by_both_models import offline_mu_eff_at_end
from brushgrip.estimation.observe_recording import model_observer, run_arguments
from brushgrip.inputs.command_inputs import gather_inputs
from identification import FoundModel, Recording, read_model
from observers import PROFILES, AligningTorque, Ekf, Estimates, Mhe, Status, run

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from published import ground_named

NAMES = ("fem1", "fem3", "fem4_ident", "fem5", "piros1", "piros2_ident", "piros4", "piros7")
PAIRS = (("fem3", "fem4_ident"), ("piros1", "piros2_ident"))
"""Recordings on one ground whose loads are within 15 %."""
CLOSE = 0.1
"""Share of mu_eff within which it counts as settled [1]."""
COLUMNS = ("covered", "offline", "sigma/mu", "settled s", "mu_eff", "sigma", "flagged", "alarms")


def figures(recording: Recording, estimates: Estimates, reference: float) -> list[float]:
    """The figures of one recording in the order of `COLUMNS`; reference: mu_eff fitted offline [1]."""
    mu, std, informed = estimates.mu_eff, estimates.mu_eff_std, estimates.informed
    off = np.flatnonzero(~(np.abs(mu / mu[-1] - 1) <= CLOSE))
    settled = recording.t[off[-1] + 1] - recording.t[0] if off.size else 0.0
    return [
        float(np.mean(np.abs(mu - mu[-1])[informed] < 1.96 * std[informed])),
        float(np.mean(np.abs(mu - reference)[informed] < 1.96 * std[informed])),
        float(np.median((std / mu)[informed])),
        float(settled),
        float(mu[-1]),
        float(std[-1]),
        float(np.mean(estimates.status & Status.INCONSISTENT != 0)),
        float(np.count_nonzero(estimates.status & Status.RESET)),
    ]


def measured(
    kind: type[Ekf] | type[Mhe], tuning: str, found: FoundModel | None, offline: FoundModel,
    *, acquire: bool = True, known: bool = False,
) -> None:  # fmt: skip
    """Bands on the published recordings; offline is the model found, with its fit of each recording."""
    model = "declared model" if found is None else "model found"
    variant = "" if acquire else ", without acquisition"
    variant += ", k known" if known else ""
    print(f"\n{kind.__name__.upper()}, {tuning}, {model}{variant}")
    print(f"{'':16}" + "".join(f"{name:>11}" for name in COLUMNS))
    table, loads = {}, {}
    aligning = AligningTorque() if known else None
    for read in gather_inputs(NAMES).recordings(causal=True):
        recording = replace(read, ground=ground_named(read.name))
        observer = model_observer(kind, recording, found, tuning=PROFILES[tuning], aligning=aligning)
        observer = replace(observer, acquire=acquire)
        loads[recording.name] = float(np.median(recording.F_N))
        table[recording.name] = figures(
            recording,
            run(observer, **run_arguments(recording)),
            offline_mu_eff_at_end(offline, recording),
        )
        print(f"{recording.name:16}" + "".join(f"{v:11.3f}" for v in table[recording.name]), flush=True)
    mean = np.mean(list(table.values()), axis=0)
    print(f"{'mean':16}" + "".join(f"{v:11.3f}" for v in mean))
    at, of = COLUMNS.index("mu_eff"), COLUMNS.index("sigma")
    for one, other in PAIRS:
        a, b = table[one], table[other]
        print(f"{one} and {other}: {abs(a[at] - b[at]) / np.hypot(a[of], b[of]):.2f} joint deviations")
    for ground in ("steel", "emery"):
        on = [name for name in table if ground_named(name) == ground]
        mu, load = np.array([table[name][at] for name in on]), [loads[name] for name in on]
        (slope, _), off, *_ = np.polyfit(np.log(load), np.log(mu), 1, full=True)
        spread = np.sqrt(off[0] / (len(on) - 2))
        print(
            f"{ground}: coefficient of variation {mu.std(ddof=1) / mu.mean():.3f}, slope of log friction"
            f" over log load {slope:.2f}, spread about it {spread:.3f}"
        )


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--model", type=Path, help="model.json of the measured recordings")
    parser.add_argument("--runs", type=int, default=200, help="of the rig, with undeclared effects")
    parser.add_argument("--found", type=int, default=40, help="of the rig, with the model found")
    parser.add_argument("--seconds", type=int, default=1000, help="on ground that stays")
    options = parser.parse_args()
    if options.model is not None:
        model = read_model(options.model)
        for kind in (Ekf, Mhe):
            for found in (None, model):
                measured(kind, "real_tyre", found, model)
        measured(Ekf, "changing_ground", model, model)
        measured(Ekf, "real_tyre", model, model, acquire=False)
        for kind in (Ekf, Mhe):
            measured(kind, "real_tyre", model, model, known=True)
    undeclared_effects(options.runs)
    found_models(options.found)
    for tuning in PROFILES:
        changes(tuning)
        false_alarms(tuning, options.seconds)


if __name__ == "__main__":
    main()
