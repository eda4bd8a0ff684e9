"""The least deviation of a car's friction that any estimate can have, where it is known by hand."""

from dataclasses import replace

import pytest

from benchmarks.car_bound import VAGUE, least_deviations
from symbolic import Vehicle
from tests.simulated_car import steering

UPRIGHT = Vehicle(
    front_axle_load=8000.0, tyre_width=0.2, pressure=2.4e5, wheelbase=2.6, track=1.5, half_length=0.055,
    stiffness=9e6, inclination=0.0, caster=0.0,
)  # fmt: skip


def least(vehicle: Vehicle, **tolerances: float) -> float:
    _, rack = steering(seconds=4.0)
    return least_deviations(vehicle, 0.5, rack, tolerances, [rack.size], noise=0.1)[0]


def test_the_load_goes_straight_into_friction() -> None:
    # Without jacking and growth the force depends on mu F_N alone.
    load = 0.1 / 3**0.5

    assert least(UPRIGHT, front_axle_load=0.1) == pytest.approx((load**-2 + VAGUE**-2) ** -0.5, rel=0.02)


def test_what_lifts_the_body_weighs_it() -> None:
    leaning = replace(UPRIGHT, inclination=0.2)

    assert least(leaning, front_axle_load=0.1) < 0.2 * least(UPRIGHT, front_axle_load=0.1)
