"""How much worse do faulty sensors make the observers?

    python benchmarks/robustness.py --seeds 20

Seeded runs on the independent rig: the root mean square error of mu after the first full slide, and its
factor over that of the same runs without the fault.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from observers import Ekf, Mhe
from reference_rig import add_outliers, delay_samples
from tests.observers.monte_carlo import errors, estimated, turned_by_hand
from tests.observers.sensor_faults import (
    CLEAN_WITH_FAULTS,
    FAULTS,
    STEERED_FAULTS,
    RecordingFactory,
    steered,
    without_torque,
)

KINDS: dict[str, Any] = {"EKF": Ekf, "MHE": Mhe}
NOT_BORNE: dict[str, RecordingFactory] = {
    "outliers of angle, 0.01 rad": lambda seed: replace(
        turned_by_hand(seed), psi=add_outliers(seed, turned_by_hand(seed).psi, size=0.01)
    ),
    "outliers of load, half of it": lambda seed: replace(
        turned_by_hand(seed), F_N=add_outliers(seed, turned_by_hand(seed).F_N, size=200.0)
    ),
    "torque 10 ms late": lambda seed: replace(
        turned_by_hand(seed), M_z=delay_samples(turned_by_hand(seed).M_z, 1)
    ),
}
"""What is taken as known is not judged: such samples must come as missing."""
STEERED_NOT_BORNE: dict[str, RecordingFactory] = {
    "lost torque": without_torque,
    "outliers of torque": lambda seed: replace(steered(seed), M=add_outliers(seed, steered(seed).M)),
}
"""The same where the steering torque is measured: there it is what is taken as known."""


def late_errors(
    kind: Any, factory: RecordingFactory, seeds: Sequence[int], **settings: Any
) -> np.ndarray:
    """Root mean square error of mu after the first full slide, run by run; NaN where there is none."""
    return np.array([errors(r, estimated(kind, r, **settings)).late_rmse for r in map(factory, seeds)])


def table(
    title: str,
    clean: RecordingFactory,
    faulty: Mapping[str, RecordingFactory],
    seeds: Sequence[int],
    **settings: Any,
) -> None:
    """Factors by fault: of all runs together, and the largest of one run."""
    print(f"\n{title}")
    print(f"{'':32}" + "".join(f"{name + ': RMSE':>14}{'factor':>8}{'one run':>9}" for name in KINDS))
    base = {name: late_errors(kind, clean, seeds, **settings) for name, kind in KINDS.items()}
    for fault, factory in {"none": clean, **faulty}.items():
        row = f"{fault:32}"
        for name, kind in KINDS.items():
            errors_of_kind = late_errors(kind, factory, seeds, **settings)
            rmse, least = (np.sqrt(np.nanmean(e**2)) for e in (errors_of_kind, base[name]))
            row += f"{rmse:14.5f}{rmse / least:8.2f}{np.nanmax(errors_of_kind / base[name]):9.2f}"
        print(row, flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=20)
    seeds = range(parser.parse_args().seeds)
    for walk in (CLEAN_WITH_FAULTS["mu_walk"], 0.0, 0.02):
        settings = {**CLEAN_WITH_FAULTS, "mu_walk": walk}
        faulty = {**FAULTS, **NOT_BORNE} if walk == CLEAN_WITH_FAULTS["mu_walk"] else FAULTS
        table(f"aligning torque, gate 5, mu_walk {walk}", turned_by_hand, faulty, seeds, **settings)
    few = range(max(len(seeds) // 2, 1))
    steering = {**STEERED_FAULTS, **STEERED_NOT_BORNE}
    table("steering torque, gate 5, mu_walk 0.005", steered, steering, few, **CLEAN_WITH_FAULTS)


if __name__ == "__main__":
    main()
