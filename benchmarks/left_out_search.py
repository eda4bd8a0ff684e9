"""The whole search repeated without each recording in turn, which then judges what came out.

    python benchmarks/left_out_search.py [DATA]

Neither the effects nor the shared parameters have seen the recording on which the error is taken; only
its own mu is fitted to it (torque zero and starting twist too, where such effects were found). Prints a
line for each recording as it is done, and the mean. A search a recording: a quarter of an hour and more
on two cores for the measured ones.
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from examples.published import measured_folder
from identification import Recording, diagnose, read_recording
from identification.fits.fitting import Values, fit, torque_range
from identification.selecting.scoring import rmse_of
from identification.selecting.trials import freeze, model_of

TOLERANCE = 1e-4


def judged(effects: tuple[str, ...], others: list[Recording], left: Recording, start: Values) -> float:
    """Error over range on the recording that was left out [1]."""
    fitted = fit(model_of(effects), others, start, tolerance=TOLERANCE)
    return rmse_of(freeze(fitted, [left]).residuals[left.name]) / torque_range(left)


def main() -> None:
    """Leave out, search, judge."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else measured_folder()
    recordings = [read_recording(path) for path in sorted(folder.glob("*.mat"))]
    if len(recordings) < 3:
        sys.exit(f"{folder} holds {len(recordings)} recordings; three are needed")
    errors = []
    for left in recordings:
        others = [r for r in recordings if r is not left]
        found = diagnose(others)
        effects = tuple(effect.name for effect in found.model.effects)
        declared = Values(shared={"k": left.tyre.k}, own={r.name: {"mu": 1.0} for r in others})
        errors.append([judged((), others, left, declared), judged(effects, others, left, found.values)])
        before, after = errors[-1]
        print(f"{left.name:14} {before:.2%} -> {after:.2%}  {', '.join(effects)}", flush=True)
    before, after = np.mean(errors, axis=0)
    print(f"{'mean':14} {before:.2%} -> {after:.2%}, ratio {after / before:.3f}")


if __name__ == "__main__":
    main()
