"""Cars drawn at random, and what their owners believe about them.

Sources of the ranges stand in docs/evidence/car_magnitudes.md, with those that are assumed.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import radians

import numpy as np

from reference_rig.car import Car
from reference_rig.car_driver import handwheel_path
from reference_rig.car_gear import Assistance, GearFriction, Joint
from reference_rig.car_geometry import SIDES, Kingpin, Linkage, ackermann_share
from reference_rig.car_motion import CarMotion, simulate_car
from reference_rig.car_patch import CarTyre
from reference_rig.car_recording import CarBus, CarRecording, record_car

GEOMETRY = (
    "wheelbase", "track", "lever", "lever_loss", "rack_travel", "pinion_radius", "ackermann",
    "inclination", "caster", "scrub_radius", "trail", "wheel_radius", "torsion_bar", "motor_ratio",
)  # fmt: skip
TOLERANCES: Mapping[str, float] = {
    "axle_load": 0.10,
    "half_length": 0.15,
    "half_width": 0.05,
    "k": 0.20,
    "gear_friction": 0.50,
    "gear_load_share": 0.50,
    "moved_mass": 0.10,
} | dict.fromkeys(GEOMETRY, 0.03)
"""By how much a declared value may be off, as a share of it."""
MIN_MU, MAX_MU = 0.05, 1.2
ACKERMANN_AT = 0.6
"""Share of the rack's way at which the Ackermann share is taken."""


@dataclass(frozen=True, kw_only=True)
class FleetCar:
    """A car, what is declared of it, and how it is steered and seen."""

    seed: int
    car: Car
    # Names of TOLERANCES -> values; SI units, `motor_ratio` with the efficiency in it.
    declared: Mapping[str, float]
    true: Mapping[str, float]  # The same names -> what they are.
    bus: CarBus
    brake: bool
    by_rack: bool  # Whether the motor steers by itself.

    def drive(self) -> CarRecording:
        """Steer it, and record that."""
        car = self.car
        path = handwheel_path(self.seed, car.lock / car.pinion_radius, by_hand=not self.by_rack)
        if self.by_rack:
            path = path * car.pinion_radius
        motion: CarMotion = simulate_car(car, path, brake=self.brake, by_rack=self.by_rack)
        name = f"car_{self.seed}"
        return record_car(self.seed, car, motion, bus=self.bus, brake=self.brake, name=name)


def draw_car(
    seed: int, *, assisted: bool = True, full_tolerance: bool = False, split: float = 1.0,
    brake: bool | None = None,
) -> FleetCar:  # fmt: skip
    """A car by its seed.

    Args:
        seed: of the generator; the true car does not depend on the other arguments but as they say.
        assisted: with a motor; without one the car is light and its gear is slow.
        full_tolerance: every true value at an end of what is declared and its tolerance.
        split: friction under the right wheel over that under the left one [1].
        brake: None to draw it: on in two of three cars.
    """
    rng = np.random.default_rng([seed, 23])
    uniform = rng.uniform
    heavy = uniform()
    # Front axle of a small car up to a van [N]: 460 to 1200 kg.
    axle_load = 4500 * (2.6 if assisted else 1.45) ** heavy
    tyre = _tyre(rng, 0.5 * axle_load, heavy if assisted else 0.4 * heavy)
    linkage = Linkage(
        track=uniform(1.30, 1.42) + 0.12 * heavy, arm=uniform(0.11, 0.145),
        arm_angle=uniform(0.08, 0.24), rack_length=uniform(0.58, 0.70), rack_behind=uniform(0.11, 0.15),
    )  # fmt: skip
    kingpin = Kingpin(
        inclination=radians(uniform(9, 15)), caster=radians(uniform(3, 8)),
        scrub_radius=uniform(-0.015, 0.025), trail=uniform(0.008, 0.030), radius=0.28 + 0.06 * heavy,
    )  # fmt: skip
    mu = float(np.exp(uniform(np.log(MIN_MU), np.log(MAX_MU))))
    motor = Assistance(
        ratio=uniform(16, 24), efficiency=uniform(0.85, 0.95), ripple=uniform(0.005, 0.02),
        cogging=uniform(0.003, 0.012), gain=uniform(10, 15),
    )  # fmt: skip
    car = Car(
        linkage=linkage, kingpin=kingpin, tyre=tyre,
        friction=GearFriction(
            level=uniform(100, 250), by_load=uniform(0.01, 0.03), asymmetry=uniform(-0.1, 0.1),
            stiffness=uniform(3e6, 8e6), damping=uniform(300, 1200),
        ),
        rod=Joint(stiffness=uniform(2.5e6, 6e6), play=uniform(0.0, 0.2e-3)),
        assistance=motor if assisted else None, axle_load=axle_load, left_share=uniform(0.48, 0.52),
        mu=(mu, mu * split), wheelbase=uniform(2.35, 2.6) + 0.4 * heavy,
        pinion_radius=uniform(0.0066, 0.0090) if assisted else uniform(0.0055, 0.0065),
        torsion_bar=uniform(86, 143), column=uniform(800, 2500), wheel_inertia=0.7 + 0.8 * heavy,
        warp_stiffness=uniform(1.5e4, 4e4), yaw_stiffness=uniform(1.5e5, 4e5),
        yaw_inertia=3000 + 3500 * heavy,
    )  # fmt: skip
    true = _known(car)
    errors = rng.uniform(-1, 1, len(true))
    shares = [TOLERANCES[name] * error for name, error in zip(true, errors, strict=True)]
    if full_tolerance:
        # A tolerance is a share of what is declared.
        shares = [1 / (1 - TOLERANCES[n] * np.sign(s)) - 1 for n, s in zip(true, shares, strict=True)]
    declared = {n: true[n] * (1 + share) for n, share in zip(true, shares, strict=True)}
    bus = CarBus(
        period=rng.choice([0.01, 0.02]), handwheel_zero=radians(uniform(-1.5, 1.5)),
        torque_step=uniform(0.1, 0.25), torque_zero=uniform(-0.1, 0.1),
        motor_gain=uniform(0.98, 1.02), force_zero=uniform(-30, 30),
    )  # fmt: skip
    braked, by_rack = bool(uniform() < 2 / 3), bool(uniform() < 0.25) and assisted
    return FleetCar(
        seed=seed, car=car, declared=declared, true=true, bus=bus, by_rack=by_rack,
        brake=braked if brake is None else brake,
    )  # fmt: skip


def _tyre(rng: np.random.Generator, load: float, heavy: float) -> CarTyre:
    """A tyre for a load [N]."""
    nominal_width = 0.165 + 0.07 * heavy + rng.uniform(-0.01, 0.02)
    width = nominal_width * rng.uniform(0.75, 0.85)
    pressure = 1e5 * (2.1 + 0.7 * heavy + rng.uniform(-0.1, 0.3))
    # A print is rounded: it is longer than a rectangle of its area.
    half_length = rng.uniform(1.2, 1.4) * (1 - rng.uniform(0.05, 0.15)) * load / pressure / (2 * width)
    half_width = 0.5 * width
    # Torsional stiffness on the spot grows with the load, metre per radian.
    torsion = load * rng.uniform(0.55, 0.9)
    return CarTyre(
        half_length=half_length,
        half_width=half_width,
        k=3 * torsion / (2 * half_length * (half_length**2 + half_width**2)),
        length_exponent=rng.uniform(2.0, 3.0),
        width_exponent=rng.uniform(6.0, 12.0),
    )


def _known(car: Car) -> dict[str, float]:
    """True values of what is declared."""
    motor, kingpin = car.assistance, car.kingpin
    lever, at_lock = (_mean_lever(car.linkage, rack) for rack in (0.0, 0.97 * car.lock))
    return {
        "axle_load": car.axle_load,
        "half_length": car.tyre.half_length,
        "half_width": car.tyre.half_width,
        "k": car.tyre.k,
        "gear_friction": car.friction.level,
        "gear_load_share": car.friction.by_load,
        "moved_mass": car.moved_mass,
        "wheelbase": car.wheelbase,
        "track": car.linkage.track + 2 * kingpin.scrub_radius,
        "lever": lever,
        "lever_loss": 1 - at_lock / lever,
        "rack_travel": car.lock,
        "pinion_radius": car.pinion_radius,
        "ackermann": ackermann_share(car.linkage, car.wheelbase, ACKERMANN_AT * car.lock),
        "inclination": kingpin.inclination,
        "caster": kingpin.caster,
        "scrub_radius": kingpin.scrub_radius,
        "trail": kingpin.trail,
        "wheel_radius": kingpin.radius,
        "torsion_bar": car.torsion_bar,
        "motor_ratio": motor.ratio * motor.efficiency if motor else 0.0,
    }


def _mean_lever(linkage: Linkage, rack: float) -> float:
    """Way of the rack for one radian of the wheels' mean angle [m/rad]."""
    small = 1e-4
    turned = [linkage.steer(side, rack + small) - linkage.steer(side, rack - small) for side in SIDES]
    return 4 * small / sum(turned)
