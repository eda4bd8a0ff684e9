"""What are the observers' standard deviations worth? Seeded runs on the rig, nothing undeclared.

    python benchmarks/calibration.py --seeds 200 --blocks 3

Friction is drawn from the observer's own prior. Coverage: informed samples whose 95 % interval of ln mu
holds the truth. NEES: mean square of the errors over their standard deviations, 1 where these are right;
the mean of so many independent chi-squares lies in the band printed in 95 of 100 cases. RMSE of mu is
that after the first full slide. Runs with a sample beyond four standard deviations are counted before
it: as many samples make that likely in some runs of a hundred, however right the observer. Three minutes
on one core.
"""

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from itertools import product
from typing import Any

from scipy.stats import chi2

from observers import Ekf, Mhe
from reference_rig import FOURTEEN_BIT_STEP
from symbolic import Model
from tests.observers.monte_carlo import (
    Figures,
    Recording,
    errors,
    estimated,
    figures,
    steered_by_hand,
    turned_by_hand,
)

RecordingFactory = Callable[[int], Recording]
WALK = 0.01
"""Random walk of mu as a share of itself [1/sqrt(s)]."""
STEPS = (0.5, 1.0)
"""Angle noise believed over the encoder's step [1]."""


def campaign(kind: Any, make: RecordingFactory, seeds: Sequence[int], **settings: Any) -> Figures:
    """The figures of an observer's runs."""
    return figures([errors(r, estimated(kind, r, **settings)) for r in map(make, seeds)])


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


def constant_friction(seeds: int, blocks: int) -> None:
    """Aligning torque measured, friction that stays."""
    heading("friction stays, aligning torque", seeds)
    for block in range(blocks):
        own = range(block * seeds, (block + 1) * seeds)
        for kind in (Ekf, Mhe):
            name = f"{kind.__name__.upper()}, seeds {own[0]} to {own[-1]}"
            line(name, campaign(kind, turned_by_hand, own))


def walking_friction(seeds: int) -> None:
    """Aligning torque measured, friction that walks as the tuning has it."""
    heading(f"friction walks by {WALK:.1%} a square-rooted second, aligning torque, EKF", seeds)
    for name, model in (("exact patch", Model()), ("bristles", Model(discretised=True))):
        factory = partial(turned_by_hand, walk=WALK)
        line(name, campaign(Ekf, factory, range(seeds), model=model, mu_walk=WALK))


def steering_torque(seeds: int) -> None:
    """Steering torque measured at 1 kHz, friction that stays: what the steps of the encoder do."""
    heading("friction stays, steering torque and 14-bit angle, EKF", seeds)
    for walk, share in product((0.0, 1e-3), STEPS):
        noise = {"psi_noise": share * FOURTEEN_BIT_STEP}
        result = campaign(Ekf, steered_by_hand, range(seeds), mu_walk=walk, **noise)
        line(f"walk {walk:.1%}, psi_noise {share} steps", result)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--blocks", type=int, default=3)
    options = parser.parse_args()
    constant_friction(options.seeds, options.blocks)
    walking_friction(max(options.seeds // 3, 2))
    steering_torque(max(options.seeds // 5, 2))


if __name__ == "__main__":
    main()
