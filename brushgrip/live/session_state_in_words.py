"""State of a live session as text, and the friction that its source leaves."""

import re
from dataclasses import dataclass
from math import isfinite, nan

from brushgrip.wording.friction_in_words import with_95_band
from observers import Estimate, Status
from observers.quality.when_usable import CONTRADICTED
from symbolic import InvalidInputError


@dataclass(frozen=True, kw_only=True)
class State:
    """How a session stands; texts are empty for nothing."""

    t: float  # Of the newest sample [s].
    estimate: Estimate | None  # After it; None before any.
    usable: bool  # Whether a controller may act on it now: usable, and not old.
    status: str  # What is wrong and what mends it.
    advice: str  # What to do next.
    counts: dict[str, int]  # Samples by what became of them.
    recording: str  # File and samples.
    ended: bool  # Whether the source has come to its end.
    weaker: float = 0.0  # Share of friction that the weaker direction of a found model holds less [1].
    note: str = ""  # The same in words.


def friction_of(estimate: Estimate | None) -> tuple[float, float]:
    """Effective friction and its standard deviation; mu of an observer that states no effective one."""
    if estimate is None:
        return nan, nan
    if isfinite(estimate.mu_eff):
        return estimate.mu_eff, estimate.mu_eff_std
    return estimate.mu, estimate.mu_std


def usability_of(state: State) -> str:
    """Whether friction may be used now; of a source that has ended nothing may."""
    if state.ended:
        return "ended"
    return "usable" if state.usable else "not usable"


def remedy_without_turning(remedy: str) -> str:
    """Causes and remedies of an estimate without a remedy by turning, of which the cause stays."""
    return re.sub(": turn [^;]*", "", remedy)


def state_line(state: State) -> str:
    """A state on one line."""
    friction = ""
    if state.estimate is not None:
        value = with_95_band(*friction_of(state.estimate))
        friction = f"{state.t:.2f} s: μ {value}, {usability_of(state)}"
        friction += f"; {state.note}" * bool(state.note)
    times = 0 if state.usable else state.counts.get("begun anew", 0)
    anew = f"begun anew {'once' if times == 1 else f'{times} times'} after gaps" * bool(times)
    return "; ".join(filter(None, [friction, anew, state.status, state.advice, state.recording]))


def host_and_port(spec: str, rest: str) -> tuple[str, int]:
    """Host and port of `HOST:PORT` or `PORT`, which means this machine alone."""
    host, _, port = rest.rpartition(":")
    if not (port.isascii() and port.isdigit() and 0 < int(port[:9]) < 65536):
        raise InvalidInputError(f"{spec}: expected a port from 1 to 65535, such as udp:5005")
    return host or "127.0.0.1", int(port)


class LastUsableFriction:
    """The last usable friction of a source, unless what follows contradicts it, as for `estimate`."""

    told = "friction was never usable"
    _psi, _known, _after = nan, 0.0, 0.0

    def add_sample(self, t: float, psi: float, estimate: Estimate, *, usable: bool) -> None:
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
