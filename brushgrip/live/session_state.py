"""State of a live session, and the state as text."""

from dataclasses import dataclass
from math import isfinite

from brushgrip.wording.friction import with_95_band
from observers import Estimate
from symbolic import InvalidInputError


@dataclass(frozen=True, kw_only=True)
class State:
    """How a session stands.

    Attributes:
        t: time of the newest sample [s].
        estimate: after it; None before any.
        usable: whether a controller may act on it now: usable, and not old.
        age: since its sample came [s].
        status: what is wrong and what mends it; empty for nothing.
        advice: what to do next; empty for nothing.
        counts: samples by what became of them.
        recording: file and samples; empty where none is written.
        ended: whether the source has come to its end.
        weaker: share of friction that the weaker direction of a found model holds less [1].
        note: the same in words; empty for nothing.
    """

    t: float
    estimate: Estimate | None
    usable: bool
    age: float
    status: str
    advice: str
    counts: dict[str, int]
    recording: str
    ended: bool
    weaker: float = 0.0
    note: str = ""


def friction_of(estimate: Estimate | None) -> tuple[float, float]:
    """Effective friction and its standard deviation; mu of an observer that states no effective one."""
    if estimate is None:
        return float("nan"), float("nan")
    if isfinite(estimate.mu_eff):
        return estimate.mu_eff, estimate.mu_eff_std
    return estimate.mu, estimate.mu_std


def usability_of(state: State) -> str:
    """Whether friction may be used now; of a source that has ended nothing may."""
    if state.ended:
        return "ended"
    return "usable" if state.usable else "not usable"


def line_of(state: State) -> str:
    """A state on one line."""
    friction = ""
    if state.estimate is not None:
        value = with_95_band(*friction_of(state.estimate))
        friction = f"{state.t:.2f} s: μ {value}, {usability_of(state)}" + f"; {state.note}" * bool(
            state.note
        )
    return "; ".join(filter(None, [friction, state.status, state.advice, state.recording]))


def address_of(spec: str, rest: str) -> tuple[str, int]:
    """Host and port of `HOST:PORT` or `PORT`, which means this machine alone."""
    host, _, port = rest.rpartition(":")
    if not (port.isascii() and port.isdigit() and 0 < int(port[:9]) < 65536):
        raise InvalidInputError(f"{spec}: expected a port from 1 to 65535, such as udp:5005")
    return host or "127.0.0.1", int(port)
