"""Find the missing effect
=======================

Find what the brush model lacks: two recordings to learn from, two that judge.
"""

from pathlib import Path

from identification import Recording, diagnose, read_recording, read_rig

RECORDINGS = Path(__file__).resolve().parent / "recordings"


def read(*names: str) -> list[Recording]:
    """Embedded recordings by name."""
    rig = read_rig(RECORDINGS / "rig.toml")
    return [read_recording(RECORDINGS / f"{name}.csv", rig) for name in names]


def main() -> None:
    """Diagnose and print the effects and the error on the held-out recordings."""
    diagnosis = diagnose(read("train_a", "train_b"), read("holdout_c", "holdout_d"), jobs=1)
    for effect in diagnosis.effects:
        for name, estimate in effect.parameters.items():
            spread = "" if estimate.std is None else f" ± {estimate.std:.2g}"
            print(f"{effect.name}: {name} = {estimate.value:.4g}{spread} {estimate.unit}")
    for stage, errors in (("before", diagnosis.before), ("after", diagnosis.after)):
        share = errors.summary()["holdout_torque_nrmse"]
        print(f"held-out torque error {stage}: {share:.2%} of range")


if __name__ == "__main__":
    main()
