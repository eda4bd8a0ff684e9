"""How far must a parked car's wheels turn until friction is known? As `least_steering`, on random cars.

    python benchmarks/least_steering_car.py --cars 8 --seed 20000

The car is the independent one, its motor steers, its bus shows way and force of the rack; every declared
value is off within its tolerance, as in `car`. Travel is that of the wheels.
"""

import argparse
import tomllib
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.car_files import vehicle_toml
from benchmarks.least_steering import GROUNDS, Reached, in_every_way, report
from observers import Ekf, Probe, Sample, SteeringLimits, plan
from observers.interfaces.car_observer import RackSampler, car_observer
from reference_rig import FleetCar, SteeredCar, draw_car
from symbolic import vehicle_from_tables
from symbolic.vehicle.mean_wheel import equivalent_contact_angle
from symbolic.vehicle.steering import mean_wheel_angle

LIMITS = SteeringLimits(angle=0.4, rate=0.25, time=10.0)
DT = 0.02
"""Time between samples [s]."""


class CarWheel:
    """The mean front wheel of a car as its bus shows it, steered sample by sample."""

    def __init__(self, drawn: FleetCar) -> None:
        """Park it."""
        self.vehicle = vehicle_from_tables(
            tomllib.loads(vehicle_toml(drawn.declared, brake=drawn.brake))
        )
        self.drawn, self.brake = drawn, drawn.brake
        self.car, self.rng = SteeredCar(drawn.car, brake=drawn.brake), np.random.default_rng(drawn.seed)
        self.ways = np.linspace(-self.vehicle.rack_travel, self.vehicle.rack_travel, 4001)
        self.angles = equivalent_contact_angle(
            self.vehicle, mean_wheel_angle(self.vehicle, self.ways), brakes=self.brake
        )
        self.sample_of, self.t = RackSampler(self.vehicle, brakes=self.brake), 0.0

    @property
    def psi(self) -> float:
        """Present angle [rad]."""
        return float(np.interp(self.car.rack, self.ways, self.angles))

    def follow(self, command: float) -> Sample:
        """The sample after a step toward the command."""
        bus, self.t = self.drawn.bus, self.t + DT
        force = self.car.turn(float(np.interp(command, self.angles, self.ways)), DT)
        force += bus.force_zero + bus.force_noise * self.rng.standard_normal()
        force = bus.force_step * round(force / bus.force_step)
        way = bus.rack_step * round(self.car.rack / bus.rack_step)
        return self.sample_of(self.t, way, force)


def parked(drawn: FleetCar, mu: float) -> CarWheel:
    """The wheel of a car on a friction."""
    return CarWheel(replace(drawn, car=replace(drawn.car, mu=(mu, mu))))


def run(seed: int, target: float) -> tuple[float, dict[str, Reached]]:
    """One car, steered in every way; its friction is drawn from the bands in turn."""
    drawn = draw_car(seed)
    low, high = [*GROUNDS.values()][seed % len(GROUNDS)]
    mu = float(np.exp(np.random.default_rng([seed, 1]).uniform(*np.log([low, high]))))
    vehicle = CarWheel(drawn).vehicle
    observer: Any = car_observer(Ekf, vehicle, brakes=drawn.brake)
    probe, load = Probe(observer, target, LIMITS, dt=DT), vehicle.wheel_load
    known = plan(observer, target, LIMITS, load, mus=(mu,), dt=DT, coarse=True)
    plans = (probe.prepare(load), probe, known)
    return mu, in_every_way(observer, lambda: parked(drawn, mu), mu, target, *plans, pulse=0.6)


def main() -> None:
    """Print a line a car, and the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cars", type=int, default=8)
    parser.add_argument("--seed", type=int, default=20_000, help="of the first car")
    parser.add_argument("--target", type=float, default=0.15)
    given = parser.parse_args()
    outcomes = []
    for seed in range(given.seed, given.seed + given.cars):
        mu, reached = run(seed, given.target)
        outcomes.append((mu, reached))
        cells = (
            f"{name} {one.travel:.3f} ({one.error:+.0%})" if one.travel > 0 else f"{name} never"
            for name, one in reached.items()
        )
        print(f"{seed} mu {mu:.3f}: {'  '.join(cells)}", flush=True)
    report(outcomes)


if __name__ == "__main__":
    main()
