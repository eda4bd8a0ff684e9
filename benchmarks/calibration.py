"""What are the observers' standard deviations worth? Seeded runs on the rig, nothing undeclared.

    python benchmarks/calibration.py --seeds 200 --blocks 3 [--exact]

Friction is drawn from the observer's own prior. Coverage: informed samples whose 95 % interval of ln mu
holds the truth. NEES: mean square of the errors over their standard deviations, 1 where these are right;
the mean of so many independent chi-squares lies in the band printed in 95 of 100 cases. RMSE of mu is
that after the first full slide. Runs with a sample beyond four standard deviations are counted before
it: as many samples make that likely in some runs of a hundred, however right the observer. --exact says
how many Bayes' rule on a grid has, which linearises nothing; it takes half a second a run. Without it,
three minutes on one core.
"""

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chi2

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from observers import Ekf, Mhe
from reference_rig import FOURTEEN_BIT_STEP, SteeringRecording
from symbolic import Model
from tests.observers.grid_posterior import posterior
from tests.observers.monte_carlo import (
    Errors,
    Figures,
    Recording,
    errors,
    estimated,
    figures,
    steered_by_hand,
    turned_by_hand,
)

RecordingFactory = Callable[[int], Recording]
EXACT, BRISTLES = Model(), Model(discretised=True)
WALKS = (0.001, 0.005, 0.01, 0.02)
"""Random walks of mu as a share of itself [1/sqrt(s)]."""
STEPS = (0.29, 0.5, 1.0, 2.0)
"""Angle noise believed over the encoder's step; 0.29 is that of an even spread, 1/sqrt(12)."""
WHITE = 1e-5
"""Angle noise that stands for none [rad]."""


def campaign(kind: Any, make: RecordingFactory, seeds: Sequence[int], **settings: Any) -> Figures:
    """The figures of an observer's runs."""
    return figures([errors(r, estimated(kind, r, **settings)) for r in map(make, seeds)])


def by_bayes(seed: int) -> tuple[Errors, Errors]:
    """Errors of the filter and of the exact posterior, both up to the first full slide."""
    recording = turned_by_hand(seed)
    estimates = estimated(Ekf, recording)
    whole = errors(recording, estimates)
    count = max(min(whole.slid, recording.t.size), 2)
    exact = posterior(recording, count)
    normal = (exact.mean - np.log(recording.mu_true[:count])) / exact.std
    part = replace(whole, normal=whole.normal[:count], informed=whole.informed[:count])
    return part, replace(part, normal=normal)


def load_known(recording: SteeringRecording) -> SteeringRecording:
    """The same without noise of the load."""
    return replace(recording, F_N=recording.F_N_true)


def white_angle(seed: int, recording: SteeringRecording, noise: float) -> SteeringRecording:
    """The same with white noise [rad] in place of the encoder's steps."""
    rng = np.random.default_rng([seed, 97])
    return replace(recording, psi=recording.psi_true + noise * rng.standard_normal(recording.t.size))


def heading(title: str, runs: int) -> None:
    """Title and names of the columns."""
    low, high = chi2.ppf([0.025, 0.975], runs) / runs
    print(f"\n{title}; {runs} runs, NEES of independent runs {low:.2f} to {high:.2f}")
    columns = f"{'coverage':>10}{'NEES':>7}{'RMSE':>9}{'worst run':>11}{'beyond 4':>10}{'farthest':>10}"
    print(f"{'':52}{columns}", flush=True)


def line(label: str, result: Figures) -> None:
    """One line of a table."""
    print(
        f"{label:52}{result.coverage:10.3f}{result.nees:7.2f}{result.rmse:9.4f}{result.worst:11.4f}"
        f"{result.beyond:10d}{result.farthest:10.1f}",
        flush=True,
    )


def constant_friction(seeds: int, blocks: int, exact: bool) -> None:
    """Aligning torque measured, friction that stays."""
    heading("friction stays, aligning torque", seeds)
    for block in range(blocks):
        own = range(block * seeds, (block + 1) * seeds)
        for kind in (Ekf, Mhe):
            name = f"{kind.__name__.upper()}, seeds {own[0]} to {own[-1]}"
            line(name, campaign(kind, turned_by_hand, own))
        if exact:
            filtered, grid = zip(*map(by_bayes, own), strict=True)
            line("  before full slide: EKF", figures(filtered))
            line("  before full slide: exact posterior", figures(grid))


def walking_friction(seeds: int) -> None:
    """Aligning torque measured, friction that walks as the tuning has it."""
    heading("friction walks, aligning torque, EKF", seeds)
    for walk in WALKS:
        for name, model in (("exact patch", EXACT), ("bristles", BRISTLES)):
            result = campaign(
                Ekf,
                lambda seed, w=walk: turned_by_hand(seed, w),
                range(seeds),
                model=model,
                mu_walk=walk,
            )
            line(f"{walk:.1%} a square-rooted second, {name}", result)


def steering_torque(seeds: int) -> None:
    """Steering torque measured at 1 kHz, friction that stays: what the steps of the encoder do."""
    heading("friction stays, steering torque and 14-bit angle, EKF", seeds)
    for walk in (0.0, 1e-3):
        believed = f"walk {walk:.1%}"
        ideal = campaign(
            Ekf, lambda seed: white_angle(seed, load_known(steered_by_hand(seed)), WHITE), range(seeds),
            mu_walk=walk, psi_noise=WHITE,
        )  # fmt: skip
        line(f"{believed}, angle and load known", ideal)
        for share in STEPS:
            settings = {"mu_walk": walk, "psi_noise": share * FOURTEEN_BIT_STEP}
            for name, view in (("", lambda r: r), (", load known", load_known)):
                result = campaign(
                    Ekf, lambda seed, s=view: s(steered_by_hand(seed)), range(seeds), **settings
                )
                line(f"{believed}, psi_noise {share} steps{name}", result)
    white = STEPS[0] * FOURTEEN_BIT_STEP
    for share in (STEPS[0], 1.0):
        result = campaign(
            Ekf, lambda seed: white_angle(seed, steered_by_hand(seed), white), range(seeds),
            psi_noise=share * FOURTEEN_BIT_STEP,
        )  # fmt: skip
        line(f"walk 0.1%, psi_noise {share} steps, true noise white", result)
    result = campaign(Mhe, steered_by_hand, range(seeds), mu_walk=1e-3, window=20)
    line("walk 0.1%, psi_noise 1.0 steps, MHE", result)
    result = campaign(Ekf, lambda seed: steered_by_hand(seed, walk=1e-3), range(seeds), mu_walk=1e-3)
    line("walk 0.1%, psi_noise 1.0 steps, mu does walk", result)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--blocks", type=int, default=3)
    parser.add_argument(
        "--exact", action="store_true", help="hold the filter against Bayes' rule on a grid"
    )
    options = parser.parse_args()
    constant_friction(options.seeds, options.blocks, options.exact)
    walking_friction(max(options.seeds // 3, 2))
    steering_torque(max(options.seeds // 5, 2))


if __name__ == "__main__":
    main()
