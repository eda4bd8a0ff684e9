"""How much worse do faulty sensors make the observers?

    python benchmarks/robustness.py --seeds 20

Seeded runs on the independent rig: the root mean square error of mu after the first full slide, and its
factor over that of the same runs without the fault.
"""

import argparse
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from observers import Ekf, Mhe
from tests.observers.monte_carlo import errors, estimated, turned_by_hand
from tests.observers.sensor_faults import (
    CLEAN_WITH_FAULTS,
    FAULTS,
    STEERED_FAULTS,
    RecordingFactory,
    steered,
)

KINDS: dict[str, Any] = {"EKF": Ekf, "MHE": Mhe}


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
        table(f"aligning torque, gate 5, mu_walk {walk}", turned_by_hand, FAULTS, seeds, **settings)
    few = range(max(len(seeds) // 2, 1))
    title = "steering torque, gate 5, mu_walk 0.005"
    table(title, steered, STEERED_FAULTS, few, **CLEAN_WITH_FAULTS)


if __name__ == "__main__":
    main()
