"""The friction that a source which has ended leaves."""

from math import isfinite, nan

from brushgrip.live.session_state import friction_of
from brushgrip.wording.friction import CONTRADICTED, with_95_band
from observers import Estimate, Status


class LastUsable:
    """The last usable friction of a source, unless what follows contradicts it, as for `estimate`."""

    def __init__(self) -> None:
        """Begin: nothing was usable yet."""
        self._told, self._up_to, self._psi = "friction was never usable", nan, nan
        self._known = self._after = 0.0

    def see(self, t: float, psi: float, estimate: Estimate, *, usable: bool) -> None:
        """One more sample: its time [s], its angle [rad], NaN where missing, and what it tells."""
        turn = abs(psi - self._psi) if isfinite(psi - self._psi) else 0.0
        self._psi = psi if isfinite(psi) else self._psi
        if Status.RESET in estimate.status:
            self._told = f"friction is not known since a new ground was noticed at {t:.4g} s"
            self._up_to, self._known, self._after = nan, 0.0, 0.0
        elif usable:
            friction = with_95_band(*friction_of(estimate))
            self._told, self._up_to = f"friction was {friction} at {t:.4g} s, last usable", t
            self._known, self._after = self._known + turn, 0.0
        elif Status.INCONSISTENT in estimate.status and Status.MISSING not in estimate.status:
            self._after += turn

    def __str__(self) -> str:
        """In words."""
        if self._after <= CONTRADICTED * self._known or not isfinite(self._up_to):
            return self._told
        up_to = f"what was usable up to {self._up_to:.4g} s"
        return f"friction is not known: {up_to} does not explain the torque that follows"
