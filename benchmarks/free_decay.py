"""How well free vibrations tell k and b_t: errors and coverage over many campaigns on the reference rig.

    python benchmarks/free_decay.py [--seeds 100]

Every campaign is seven contact lengths with five impacts each, 1 kHz, a 14-bit encoder, k = 2.438e6 and
b_t = 1.04 in SI units, steel under the tyre, the load that makes the contact length. Other methods stand
beside this one in `examples/free_decay.py`.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "examples"))

from identification import identify_free_decay
from reference_rig import THESIS_DAMPING as B_T
from reference_rig import THESIS_TYRE as TYRE
from reference_rig import make_impacts
from rig_recordings import as_decay

TRUE = {"k": TYRE.k, "b_t": B_T}


def main() -> None:
    """Print the errors of k and b_t, their deviations and how often their intervals hold the truth."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=100)
    count = parser.parse_args().seeds
    results = [identify_free_decay([as_decay(r) for r in make_impacts(seed)]) for seed in range(count)]
    for name, true in TRUE.items():
        found = [getattr(result, name) for result in results]
        errors = 100 * np.array([each.value / true - 1 for each in found])
        spread = 100 * np.mean([each.std / true for each in found])
        held = sum(each.interval[0] <= true <= each.interval[1] for each in found)
        print(
            f"{name}: off by {errors.mean():+.4f} % in the mean, {np.abs(errors).max():.4f} % at most,"
            f" standard deviation {spread:.4f} %; the 95 % interval holds the truth in {held} of {count}"
        )
    agreed = sum(result.contacts_agree is not False for result in results)
    print(f"contacts agree on k, as they do: {agreed} of {count}")


if __name__ == "__main__":
    main()
