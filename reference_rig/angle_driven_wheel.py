"""A wheel on bristles that somebody steers sample by sample, as a controller in a loop does."""

import numpy as np

from reference_rig.patch import PatchState, PatchStep, RigTyre, lay_out


class SteeredWheel:
    """The rig's wheel under a constant load; it stands at 0 at first, free of torque.

    Attributes:
        psi: present angle [rad].
    """

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
