"""Friction for others: CAN frames with their database, or JSON in datagrams."""

import json
import socket
import struct
import time
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from math import ceil, isfinite

from brushgrip.live.session_state_in_words import State, friction_of, host_and_port
from symbolic import InvalidInputError

INTERVAL = 0.01
"""Least time between messages [s]."""
IDENTIFIER = 0x6B0
SCALE, UNKNOWN = 1e-4, 0xFFFF
"""Of friction in a frame [1], and what stands there for none."""
LESS_SCALE = 0.01
"""Of the share that the weaker direction holds less [1]."""
DATABASE = f"""VERSION ""
NS_ :
BS_:
BU_: brushgrip
BO_ {IDENTIFIER} Friction: 8 brushgrip
 SG_ mu_eff : 0|16@1+ ({SCALE},0) [0|6.5534] "1" Vector__XXX
 SG_ mu_eff_std : 16|16@1+ ({SCALE},0) [0|6.5534] "1" Vector__XXX
 SG_ usable : 32|1@1+ (1,0) [0|1] "" Vector__XXX
 SG_ weaker : 33|7@1+ ({LESS_SCALE},0) [0|1] "" Vector__XXX
 SG_ counter : 40|8@1+ (1,0) [0|255] "" Vector__XXX
 SG_ status : 48|16@1+ (1,0) [0|65535] "" Vector__XXX
CM_ SG_ {IDENTIFIER} mu_eff "Effective friction; outside the range where it is not known.";
CM_ SG_ {IDENTIFIER} weaker "Share of mu_eff that the weaker direction of turning holds less.";
CM_ SG_ {IDENTIFIER} usable "Act on friction while this is 1 and the counter advances.";
"""
"""The DBC file of the frames."""


def can_frame(state: State, counter: int) -> bytes:
    """The eight bytes of a state; friction that the frame cannot hold is unknown, and not usable."""
    numbers = [value / SCALE if isfinite(value) else UNKNOWN for value in friction_of(state.estimate)]
    mu, std = (round(number) if 0 <= number < UNKNOWN - 1 else UNKNOWN for number in numbers)
    usable = state.usable and UNKNOWN not in (mu, std)
    status = 0 if state.estimate is None else int(state.estimate.status)
    less = ceil(state.weaker / LESS_SCALE)
    return struct.pack("<HHBBH", mu, std, usable + 2 * less, counter % 256, status)


def json_datagram(state: State) -> bytes:
    """A state as a JSON object; null for what is not known."""
    mu, std = (value if isfinite(value) else None for value in friction_of(state.estimate))
    t = state.t if isfinite(state.t) else None
    told = {"t": t, "mu_eff": mu, "mu_eff_std": std, "usable": state.usable, "status": state.status}
    told["weaker"] = state.weaker
    return json.dumps(told).encode()


class FrictionSender:
    """Sends states, at most one every `INTERVAL`; what cannot be sent is left out."""

    def __init__(self, destination: str) -> None:
        """Join a bus, `can:INTERFACE:CHANNEL`, or aim at a port, `udp:PORT` or `udp:HOST:PORT`."""
        kind, _, rest = destination.partition(":")
        self._send: Callable[[State], None]
        self.close: Callable[[], None]
        try:
            self._send = {"udp": self._datagram_sender, "can": self._can_frame_sender}[kind](
                destination, rest
            )
        except InvalidInputError:
            raise
        except Exception as error:  # Every interface has errors of its own.
            raise InvalidInputError(
                f"--send {destination}: allowed: udp:HOST:PORT, can:INTERFACE:CHANNEL; {error}"
            ) from None
        self._counter, self._last = 0, 0.0

    def __call__(self, state: State) -> None:
        """Send a state, at once where it must no longer be used."""
        now = time.monotonic()
        if now < self._last + INTERVAL and not state.ended:
            return
        self._last, self._counter = now, self._counter + 1
        self._send(state)

    def _datagram_sender(self, destination: str, rest: str) -> Callable[[State], None]:
        address, sender = (
            host_and_port(destination, rest),
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM),
        )
        sender.setblocking(False)

        def send(state: State) -> None:
            with suppress(OSError):
                sender.sendto(json_datagram(state), address)

        self.close = sender.close
        return send

    def _can_frame_sender(self, _: str, rest: str) -> Callable[[State], None]:
        can = import_module("can")
        interface, _, channel = rest.partition(":")
        bus = can.Bus(interface=interface, channel=channel)

        def send(state: State) -> None:
            data = can_frame(state, self._counter)
            message = can.Message(arbitration_id=IDENTIFIER, data=data, is_extended_id=False)
            with suppress(can.CanError, OSError):
                bus.send(message, timeout=0)

        self.close = bus.shutdown
        return send
