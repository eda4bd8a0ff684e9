"""Make the embedded recordings anew: the carcass twists, the friction grows with sliding speed.

The files declare neither. Run it from anywhere; without an argument it writes beside itself.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from reference_rig import RigRecording, RigTyre, make_recording, recording_csv, rig_toml

HERE = Path(__file__).resolve().parent / "recordings"
EFFECTS = {"carcass_torsion": {"k_t": 400.0}, "rate_friction": {"c": 0.04}}
TYRE = RigTyre(a=0.045, e=0.009, k=2.4e6)
NOMINAL = RigTyre(a=0.045, e=0.009, k=2.8e6, mu=1.1)
RUNS = {
    "train_a": {"seed": 103, "mu": 1.31, "load": 402.0},
    "train_b": {"seed": 112, "mu": 1.24, "load": 391.0},
    "holdout_c": {"seed": 111, "mu": 1.37, "load": 411.0},
    "holdout_d": {"seed": 117, "mu": 1.28, "load": 396.0},
}
TRUTH = """# What was planted

No command reads this file. The recordings come from `examples/make_recordings.py`.

- Tyre: a = {a} m, e = {e} m, k = {k:.4g} N/m²
- carcass_torsion: k_t = {k_t} N m/rad
- rate_friction: c = {c}
- Torque noise: white, standard deviation 0.4 % of the range

| recording | μ | mean F_N [N] | seed | torque range [N m] |
|---|---|---|---|---|
"""


def recordings() -> Iterator[RigRecording]:
    """The four recordings, one after the other."""
    for name, run in RUNS.items():
        tyre = replace(TYRE, mu=run["mu"])
        yield make_recording(int(run["seed"]), EFFECTS, **vars(tyre), load=run["load"], name=name)


def files() -> dict[str, str]:
    """Name and text of every file of the folder."""
    texts = {"rig.toml": rig_toml(NOMINAL)}
    truth = TRUTH.format(**vars(TYRE), **EFFECTS["carcass_torsion"], **EFFECTS["rate_friction"])
    for recording in recordings():
        run, extent = RUNS[recording.name], float(max(recording.M_z_true) - min(recording.M_z_true))
        texts[f"{recording.name}.csv"] = recording_csv(recording)
        truth += f"| {recording.name} | {run['mu']} | {run['load']} | {run['seed']} | {extent:.2f} |\n"
    return texts | {"TRUTH.md": truth}


def main(directory: Path = HERE) -> None:
    """Write the folder."""
    directory.mkdir(parents=True, exist_ok=True)
    for name, text in files().items():
        (directory / name).write_text(text, encoding="utf-8", newline="\n")
        print(f"{name}: {len(text.splitlines())} lines")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
