"""What must hold whatever a file holds; shares no code with what it checks."""

import math
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from identification import Decay, Recording, SignalMap
from symbolic import BrushgripError, InvalidInputError, Rig, Tyre

LONGEST_MESSAGE = 2_000


@contextmanager
def refused_in_a_line() -> Iterator[None]:
    """What is inside may refuse its input, in one line."""
    try:
        yield
    except InvalidInputError as error:
        check_message(error)


def check_message(error: BrushgripError) -> None:
    """One line of bounded length that no terminal takes for a command."""
    message = str(error)
    assert message, "a message without words"
    assert len(message) <= LONGEST_MESSAGE, f"a message of {len(message)} characters"
    odd = {character for character in message if not character.isprintable()}
    assert not odd, f"a message with {odd}"


def check_recording(recording: Recording) -> None:
    """What every user of a recording takes for granted."""
    size = len(recording.t)
    assert size >= 10
    for name in ("t", "psi", "psi_dot", "F_N"):
        values = getattr(recording, name)
        assert values.shape == (size,)
        assert values.dtype == float
        assert all(math.isfinite(value) for value in values.tolist()), name
        assert not values.flags.writeable
    assert all(one < other for one, other in zip(recording.t[:-1], recording.t[1:], strict=True))
    assert min(recording.F_N.tolist()) > 0
    for torque in (recording.M_z, recording.M):
        assert torque is None or (torque.shape == (size,) and not np.isinf(torque).any())
    check_rig(recording.rig, recording.tyre)


def check_decay(decay: Decay) -> None:
    """What every user of a free vibration takes for granted."""
    assert len(decay.t) == len(decay.psi) >= 10
    assert all(map(math.isfinite, [*decay.t.tolist(), *decay.psi.tolist()]))
    assert all(one < other for one, other in zip(decay.t[:-1], decay.t[1:], strict=True))
    assert decay.inertia > 0
    check_rig(decay.rig, decay.tyre)


def check_rig(rig: Rig, tyre: Tyre) -> None:
    """Values with which the models can compute."""
    values = [value for value in (rig.a, rig.e, rig.J_A, rig.b_t, tyre.k, tyre.mu) if value is not None]
    assert all(math.isfinite(value) for value in values)
    assert rig.a > abs(rig.e)
    assert 1e3 <= tyre.k <= 1e9
    assert tyre.mu is None or 0.01 <= tyre.mu <= 10


def check_map(signals: SignalMap) -> None:
    """What every reader of channels takes for granted."""
    assert set(signals.signals) <= {"t", "psi", "psi_dot", "M_z", "M", "F_N"}
    for column, source in signals.signals.items():
        assert source.channel.strip()
        scale = source.factor_to_si(column, "")
        assert math.isfinite(scale), column
        assert scale, column
    assert signals.dbc is None or "\0" not in str(signals.dbc)
