"""A car whose rack somebody steers sample by sample, as a controller in a loop does."""

from reference_rig.car import Car
from reference_rig.car_motion import CAR_STEP, CHANNELS, advance_car, start_car
from reference_rig.car_patch import COLUMNS, ROWS

AVERAGING_TIME = 5e-3
"""Time over which the force that is shown is averaged [s]."""


class SteeredCar:
    """A car at standstill whose motor follows the rack's command; it begins at 0, at rest.

    Attributes:
        rack: way of the rack [m].
    """

    def __init__(self, car: Car, *, brake: bool, grid: tuple[int, int] = (COLUMNS, ROWS)) -> None:
        """Everything at rest."""
        self._car, self._brake = car, brake
        self._state, self._way, self.rack = start_car(car, 0.0, grid), 0.0, 0.0

    def turn(self, rack: float, dt: float) -> float:
        """Mean force on the rack [N] at the end of an even command to a way [m] in a time [s]."""
        steps, forces = round(dt / CAR_STEP), []
        rate, place = (rack - self._way) / dt, CHANNELS.index("F_rack")
        for _ in range(steps):
            self._way += rate * CAR_STEP
            row = advance_car(
                self._car, self._state, self._way, rate, self._brake, True, CAR_STEP, self._car.mu
            )
            forces.append(row[place])
        self.rack = self._state.rack
        last = forces[-round(AVERAGING_TIME / CAR_STEP) :]
        return sum(last) / len(last)
