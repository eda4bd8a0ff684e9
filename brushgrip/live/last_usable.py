"""The friction that a source which has ended leaves."""

from math import isfinite, nan

from brushgrip.live.session_state import friction_of
from brushgrip.wording.friction import CONTRADICTED, with_95_band
from observers import Estimate, Status


class LastUsable:
    """The last usable friction of a source, unless what follows contradicts it, as for `estimate`."""

    told = "friction was never usable"
    _psi, _known, _after = nan, 0.0, 0.0

    def see(self, t: float, psi: float, estimate: Estimate, *, usable: bool) -> None:
        """One more sample: its time [s], its angle [rad], NaN where missing, and what it tells."""
        turn = abs(psi - self._psi) if isfinite(psi - self._psi) else 0.0
        self._psi = psi if isfinite(psi) else self._psi
        if usable:
            friction = with_95_band(*friction_of(estimate))
            self.told = f"friction was {friction} at {t:.4g} s, last usable"
            self._known, self._after = self._known + turn, 0.0
        elif Status.RESET in estimate.status:
            self.told = f"friction is not known since a new ground was noticed at {t:.4g} s"
            self._known = self._after = 0.0
        elif estimate.status & (Status.INCONSISTENT | Status.MISSING) == Status.INCONSISTENT:
            self._after += turn
        if self.told.endswith("last usable") and self._after > CONTRADICTED * self._known:
            self.told = "friction is not known: what was usable does not explain what follows"
