"""A wheel on bristles, and a car, steered sample by sample, as a controller in a loop does."""

import numpy as np

from reference_rig.car import Car
from reference_rig.car_motion import CAR_STEP, CHANNELS, advance_car, start_car
from reference_rig.car_patch import COLUMNS, ROWS
from reference_rig.patch import PatchState, PatchStep, RigTyre, lay_out

AVERAGING_TIME = 5e-3
"""Time over which the force that is shown is averaged [s]."""


class SteeredWheel:
    """The rig's wheel under a constant load, at its angle `psi` [rad]: at first 0, free of torque."""

    def __init__(self, tyre: RigTyre, *, load: float = 400.0, bristles: int = 400) -> None:
        """Lay out the bristles; load [N]."""
        self._grid = lay_out(tyre, (), bristles)
        self._limit = self._grid.limit_of(1.0) * load
        still = np.zeros_like(self._grid.lever)
        self._state, self.psi = PatchState(spring=still, branch=still, psi=0.0), 0.0

    def turn(self, psi: float, dt: float = 0.01) -> float:
        """M_z after a turn to an angle [rad] in a time [s], [N m]."""
        self.psi = psi
        self._state, M_z, _ = PatchStep(self._grid, self._state, self._limit, dt).take(psi)
        return M_z


class SteeredCar:
    """A car at standstill whose motor follows a command, at the rack's way `rack` [m]: at first 0."""

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
            row = advance_car(self._car, self._state, self._way, rate, self._brake, True, CAR_STEP)
            forces.append(row[place])
        self.rack = self._state.rack
        last = forces[-round(AVERAGING_TIME / CAR_STEP) :]
        return sum(last) / len(last)
