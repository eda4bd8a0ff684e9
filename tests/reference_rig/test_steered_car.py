import numpy as np
import pytest

from reference_rig import CAR_STEP, Car, SteeredCar, simulate_car


def test_a_car_steered_by_samples_moves_as_along_a_path() -> None:
    ways = 1e-4 * np.arange(41)
    motion = simulate_car(Car(), ways, by_rack=True, every=1, grid=(6, 4))
    car = SteeredCar(Car(), brake=True, grid=(6, 4))
    forces = [car.turn(way, 20 * CAR_STEP) for way in (ways[20], ways[40])]

    # The path has one step more, at rest.
    assert car.rack == pytest.approx(motion.rack[-1], rel=1e-3)
    assert forces[1] == pytest.approx(motion.F_rack[-10:].mean(), rel=1e-3)
