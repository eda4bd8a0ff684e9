"""Magnitudes of the independent car beside published ones: moments, rack force, torque at the handwheel.

    python benchmarks/car_magnitudes.py

Half a minute on one core.
"""

from dataclasses import replace
from math import pi, radians, sin, sqrt

import numpy as np

from reference_rig import CAR_STEP, Car, CarPatches, CarTyre, Kingpin, Linkage, simulate_car

MU = 0.9
SMALL = Car(
    axle_load=5900.0, assistance=None, mu=(MU, MU), wheelbase=2.45, pinion_radius=0.0068,
    linkage=Linkage(track=1.32, arm=0.13, rack_length=0.60),
    kingpin=Kingpin(inclination=radians(12), caster=radians(3), scrub_radius=-0.005, radius=0.28),
    tyre=CarTyre(half_length=0.057, half_width=0.070, k=8e6),
)  # fmt: skip
LARGE = Car(
    axle_load=11800.0, assistance=None, mu=(MU, MU), wheelbase=2.95, pinion_radius=0.0080,
    linkage=Linkage(track=1.52, arm=0.14, rack_length=0.70),
    kingpin=Kingpin(inclination=radians(12), caster=radians(6), scrub_radius=0.010, radius=0.35),
    tyre=CarTyre(half_length=0.070, half_width=0.094, k=8e6),
)  # fmt: skip
CARS = {"small car": (SMALL, 2.2e5), "SUV or van": (LARGE, 2.7e5)}
"""With the pressure of the tyres [Pa]."""
VAN_LOAD, VAN_RADIUS, VAN_OFFSET = 1200 * 9.81, 0.125, 0.025
"""A worked example: load of a wheel [N], radius of its round patch and lateral offset [m]."""


def sliding_moment(tyre: CarTyre, load: float, mu: float, offset: float = 0.0) -> float:
    """Moment of a wheel that turns on the spot about a point beside its middle [N m], all sliding."""
    patches, step, moment = CarPatches(replace(tyre, k=1e9)), 1e-3, 0.0
    for _ in range(400):
        shift = 1j * step * 1j * offset
        force, _, moment, _ = patches.move((step, step), (shift, shift), (mu * load, mu * load))
        moment += (-1j * offset * force).imag
    return -moment


def limit_moments() -> None:
    """One wheel on the spot beside two formulas."""
    print(f"\nOne wheel turned on the spot, mu {MU}, N m")
    print(f"{'':14}{'ours':>8}{'2/3 mu W R':>13}{'mu/3 sqrt(W^3/p)':>19}{'M/(mu W), mm':>15}")
    for name, (car, pressure) in CARS.items():
        load, tyre = 0.5 * car.axle_load, car.tyre
        ours = sliding_moment(tyre, load, MU)
        radius = sqrt(4 * tyre.half_length * tyre.half_width / pi)
        round_patch = 2 / 3 * MU * load * radius
        gough = MU / 3 * sqrt(load**3 / pressure)
        print(f"{name:14}{ours:8.0f}{round_patch:13.0f}{gough:19.0f}{1e3 * ours / MU / load:15.1f}")


def van() -> None:
    """Scrub and jacking of a worked example for a van."""
    side = 0.5 * sqrt(pi) * VAN_RADIUS
    even = CarTyre(half_length=side, half_width=side, length_exponent=60.0, width_exponent=60.0)
    scrub = sliding_moment(even, VAN_LOAD, 1.0, VAN_OFFSET)
    print(
        f"\nVan, round patch of 250 mm, offset 25 mm: moment over mu W {1e3 * scrub / VAN_LOAD:.1f} mm"
    )
    kingpin = Kingpin(
        inclination=radians(12), caster=0.0, scrub_radius=VAN_OFFSET, trail=0.0, radius=0.35
    )
    for angle in (28, 45):
        at = radians(angle)
        rises = [kingpin.stand(1.0, at + change)[0] for change in (-1e-3, 1e-3)]
        lean = kingpin.inclination
        formula = VAN_LOAD * VAN_OFFSET * sin(lean) * np.cos(lean) * sin(at)
        ours = VAN_LOAD * (rises[1] - rises[0]) / 2e-3
        print(
            f"  jacking at {angle} deg: ours {ours:.0f} N m, from the offset on the ground {formula:.0f}"
        )


def lock_to_lock(car: Car) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rack over its way to the stop [1], force on it [N] and friction in it [N], towards the left."""
    end, slow = 0.95 * car.lock / car.pinion_radius, 3.0
    path = np.concatenate(
        [np.linspace(0, -end, round(end / slow / CAR_STEP)),
         np.linspace(-end, end, round(2 * end / slow / CAR_STEP))]
    )  # fmt: skip
    motion = simulate_car(car, path)
    late = slice(len(motion.t) // 3, None)
    return motion.rack[late] / car.lock, motion.F_rack[late], motion.F_friction[late]


def whole_car() -> None:
    """Rack force and torque at the handwheel, and what they are made of."""
    print(f"\nWhole car, brakes on, mu {MU}, turned from the right stop to the left one")
    print(f"{'':14}{'at':>12}{'rack, N':>9}{'handwheel, N m':>16}{'ground':>8}{'gear':>6}{'lift':>6}")
    for name, (car, _) in CARS.items():
        way, force, friction = lock_to_lock(car)
        icy_way, icy_force, icy_friction = lock_to_lock(replace(car, mu=(1e-4, 1e-4)))
        for place, label in ((0.3, "30 % of way"), (0.9, "90 % of way")):
            total = float(np.interp(place, way, force))
            gear = float(np.interp(place, way, friction))
            lift = float(np.interp(place, icy_way, icy_force - icy_friction))
            torque = total * car.pinion_radius
            shares = [100 * part / total for part in (total - gear - lift, gear, lift)]
            print(f"{name:14}{label:>12}{total:9.0f}{torque:16.1f}"
                  f"{shares[0]:7.0f}%{shares[1]:5.0f}%{shares[2]:5.0f}%")  # fmt: skip


if __name__ == "__main__":
    limit_moments()
    van()
    whole_car()
