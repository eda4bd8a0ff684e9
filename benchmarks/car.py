"""Does friction from a car's steering hold its band? Random independent cars against the observers.

    python benchmarks/car.py --cars 20 --sensing rack --observer ekf
    python benchmarks/car.py --cars 200 --seed 10000 --sensing pinion --observer mhe

Seeds from TUNING_SEED on are for tuning, those from JUDGING_SEED on for judging; never tune on those.
Every declared value is off within its tolerance, the force's scale too; `--full-tolerance` puts each
true value at an end of what is declared.
`--column-friction` adds dry friction of column and handwheel that nobody declared.
`--calibrated` first identifies the tyres of every car on ground of known friction.
About five seconds a car on one core.
"""

import argparse
import csv
import tempfile
import tomllib
from dataclasses import dataclass, replace
from itertools import pairwise, product
from math import degrees
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.car_files import (
    COLUMNS,
    calibrated_toml,
    declared_toml,
    run_command,
    with_force_scale,
    write_recording,
)
from observers import Status
from reference_rig import CarRecording, FleetCar, draw_car
from symbolic import vehicle_from_tables
from symbolic.float_array_type import Array
from symbolic.vehicle.mean_wheel import mu_std_by_cause
from symbolic.vehicle.vehicle import STD_PER_TOLERANCE

TUNING_SEED, JUDGING_SEED = 0, 10_000
BANDS = (0.05, 0.11, 0.245, 0.54, 1.2)
"""Edges of the bands of mu, even in its logarithm."""
HALF_TURN = 180.0
"""Way of the handwheel after which the band is read [deg]."""
PRESLIDING = 0.01
"""Turn of the handwheel over which friction of the column turns over, from the middle [rad]."""
AT_ENDS = 0.85
"""Share of cars whose band shall hold friction with every declared value at an end of its tolerance."""
NEAR_LOCKS = 0.9
"""Share of the way from stop to stop that counts as lock to lock [1]."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Judged:
    """One car: arrays of shape (n,)."""

    drawn: FleetCar
    mu: float
    """Truth, mean of both wheels: what the axle can hold [1]."""
    estimate: Array
    std: Array
    usable: NDArray[np.bool_]
    status: NDArray[np.int64]
    half_turn: int
    """First sample after half a turn of the handwheel."""
    locks: int
    """First sample after both locks."""
    declared: Array
    """What declared values that no steering tells leave of mu, by value, as deviations [1]."""

    @property
    def floor(self) -> float:
        """Deviation over mu that the observer counts for those values together [1]."""
        return float(np.linalg.norm(self.declared))

    @property
    def errors_at_ends(self) -> Array:
        """Size of the error over mu with all those values at an end of their tolerances, by case [1]."""
        ends = np.array(list(product((-1, 1), repeat=self.declared.size))) / STD_PER_TOLERANCE
        return np.abs(ends @ self.declared)

    @property
    def refusal(self) -> str:
        """The commonest status of what is not usable after half a turn."""
        refused = self.status[self.half_turn :][~self.usable[self.half_turn :]]
        if not refused.size:
            return ""
        values, counts = np.unique(refused, return_counts=True)
        return str(Status(int(values[np.argmax(counts)])).name or "not informed").lower()

    @property
    def normal(self) -> Array:
        """Size of the error over the deviation [1]."""
        return np.abs(self.estimate - self.mu) / self.std

    def beyond(self, sigmas: float) -> float:
        """Share of all samples that are usable and beyond so many deviations [1]."""
        return float(np.mean(self.usable & ~(self.normal <= sigmas)))


def estimate(text: str, recording: CarRecording, sensing: str, observer: str) -> dict[str, Array]:
    """What the command line makes of the recording with this vehicle file, by column."""
    with tempfile.TemporaryDirectory() as name:
        file, log, out = (Path(name) / one for one in ("car.toml", "car.csv", "mu.csv"))
        file.write_text(text, encoding="utf-8")
        write_recording(log, recording, sensing)
        run_command("estimate", "--vehicle", file, "--observer", observer, log, "--out", out)
        with out.open(encoding="utf-8", newline="") as table:
            rows = list(csv.DictReader(table))
    wanted = ("t", "mu", "mu_std", "usable", "status")
    return {key: np.array([float(row[key] or "nan") for row in rows]) for key in wanted}


def with_column_friction(recording: CarRecording, torque: float) -> CarRecording:
    """The same with dry friction of column and handwheel [N m], part of the torque at the rim."""
    stretch, stretches = 0.0, []
    for turn in np.diff(recording.handwheel, prepend=recording.handwheel[:1]):
        stretch = float(np.clip(stretch + turn / PRESLIDING, -1, 1))
        stretches.append(stretch)
    return replace(recording, T_hand=recording.T_hand + torque * np.array(stretches))


def judge(
    seed: int, sensing: str, observer: str, *, full: bool, split: float, calibrated: bool,
    column: float,
) -> Judged:  # fmt: skip
    """Draw a car, steer it, estimate."""
    drawn = draw_car(seed, assisted=sensing != "handwheel", full_tolerance=full, split=split)
    text = declared_toml(drawn, sensing)
    if calibrated:
        text, drawn = calibrated_toml(drawn, sensing, full=full)
    driven = with_column_friction(drawn.drive(), column)
    recording = with_force_scale(driven, seed, full=full)
    got = estimate(text, recording, sensing, observer)
    # The truth at the rows' times: a reader may leave samples out.
    handwheel = np.interp(got["t"], recording.t, np.degrees(recording.handwheel))
    turned = np.maximum.accumulate(handwheel) - np.minimum.accumulate(handwheel)
    stops = degrees(2 * drawn.car.lock / drawn.car.pinion_radius)
    ends = [int(np.argmax(turned >= way)) for way in (HALF_TURN, NEAR_LOCKS * stops)]
    vehicle = vehicle_from_tables(tomllib.loads(text))
    return Judged(
        drawn=drawn,
        mu=float(np.mean(drawn.car.mu)),
        estimate=got["mu"],
        std=got["mu_std"],
        usable=got["usable"] > 0.5,
        status=got["status"].astype(int),
        half_turn=ends[0],
        locks=ends[1],
        declared=np.array([*mu_std_by_cause(vehicle, brakes=drawn.brake).values()]),
    )


def row(car: Judged) -> str:
    """One line about a car."""
    at = [int(i) for i in (car.half_turn, car.locks, -1)]
    shown = "  ".join(
        f"{car.estimate[i]:6.3f} +- {car.std[i]:5.3f}{' ' if car.usable[i] else '-'}" for i in at
    )
    usable = car.usable
    held = np.mean(car.normal[usable] <= 1.96) if usable.any() else np.nan
    how = f"{'brakes' if car.drawn.brake else 'free':7}{'motor' if car.drawn.by_rack else 'hand':6}"
    return (f"{car.drawn.seed:6}{car.mu:7.3f}  {how}{shown}  {np.mean(usable):6.2f}{held:6.2f}"
            f"{100 * car.beyond(3):7.2f}{100 * car.beyond(4):7.2f}  {car.refusal}")  # fmt: skip


def summary(cars: list[Judged]) -> None:
    """The figures over all cars."""
    print("\nmu              cars  usable samples  in the 95 % band")
    for low, high in pairwise(BANDS):
        chosen = [car for car in cars if low <= car.mu < high]
        usable = [car.normal[car.usable] for car in chosen]
        pool = np.concatenate(usable) if usable else np.empty(0)
        covered = f"{np.mean(pool <= 1.96):.3f}" if pool.size else "-"
        print(f"{low:5.3f} to {high:5.3f}{len(chosen):6}{pool.size:16}{covered:>18}")
    worst = max(cars, key=lambda car: car.beyond(3))
    bad = sum(car.beyond(3) > 0.01 for car in cars)
    print(f"\nusable and beyond 3 sigma: worst car {100 * worst.beyond(3):.2f} % of its samples (seed"
          f" {worst.drawn.seed}), more than 1 % in {bad} of {len(cars)} cars")  # fmt: skip
    far = [car.drawn.seed for car in cars if car.beyond(4) > 0]
    print(f"usable and beyond 4 sigma: {len(far)} cars {far[:12]}")
    for name, label in (("half_turn", "180 deg of handwheel"), ("locks", "lock to lock")):
        at = [(car, getattr(car, name)) for car in cars]
        shares = [car.std[i] / car.estimate[i] for car, i in at if car.usable[i]]
        median = f"{100 * np.median(shares):.1f} %" if shares else "-"
        print(f"sigma/mu after {label}: median {median} over {len(shares)} usable of {len(cars)} cars")
    floor = np.median([car.floor for car in cars])
    held = np.median([np.mean(car.errors_at_ends <= 1.96 * car.floor) for car in cars])
    least = [np.quantile(car.errors_at_ends, AT_ENDS, method="inverted_cdf") / 1.96 for car in cars]
    print(f"by declared values that no steering tells: median {floor:.1%}; of the cases with all of them"
          f" at an end it holds {held:.0%}, {np.median(least):.1%} hold {AT_ENDS:.0%}")  # fmt: skip
    last = [(car.mu, car.estimate[-1], car.std[-1]) for car in cars if car.usable[-1]]
    if last:
        mu, found, std = np.transpose(last)
        errors = (np.sqrt(np.mean(each**2)) for each in (np.log(found / mu), std / found))
        print("rms at the end: error {:.1%}, stated {:.1%}".format(*errors))
    never = [car.drawn.seed for car in cars if not car.usable.any()]
    print(f"never usable: {len(never)} cars {never[:12]}")


def main() -> None:
    """Print a line a car and the summary."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cars", type=int, default=20)
    parser.add_argument("--seed", type=int, default=TUNING_SEED, help="first of the cars' seeds")
    parser.add_argument("--sensing", choices=list(COLUMNS), default="rack")
    parser.add_argument("--observer", choices=["ekf", "mhe"], default="ekf")
    parser.add_argument("--full-tolerance", action="store_true", help="every value off by all of it")
    parser.add_argument("--split", type=float, default=1.0, help="mu right over mu left")
    parser.add_argument("--column-friction", type=float, default=0.0, help="N m, --sensing handwheel")
    parser.add_argument("--calibrated", action="store_true", help="tyres identified on known ground")
    given = parser.parse_args()
    purpose = "judging" if given.seed >= JUDGING_SEED else "tuning"
    print(f"seeds {given.seed} to {given.seed + given.cars - 1} ({purpose}), {given.sensing},"
          f" {given.observer}; '-' marks an estimate that is not usable")  # fmt: skip
    print(f"{'seed':>6}{'mu':>7}  {'':13}{'180 deg':18}{'lock to lock':18}{'end':18}usable  held"
          f"  >3s,%  >4s,%  refused as")  # fmt: skip
    cars = []
    for seed in range(given.seed, given.seed + given.cars):
        how = {"full": given.full_tolerance, "split": given.split, "calibrated": given.calibrated}
        cars.append(judge(seed, given.sensing, given.observer, **how, column=given.column_friction))
        print(row(cars[-1]), flush=True)
    summary(cars)


if __name__ == "__main__":
    main()
