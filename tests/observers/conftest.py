from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import pytest

import observers.ekf
import observers.mhe
from observers import Ekf, Mhe, Tuning
from symbolic import Model, Rig
from tests.rig.record import RigRecording, make_recording
from tests.rig.steering import SteeringRecording, Wheel, make_steering_recording

RIG = Rig(a=0.045, e=0.009, J_A=Wheel().J_A, b_t=Wheel().b_t)
K = 2.4e6
OWN = ("model", "values", "rig", "sensing", "iterations", "window")
"""Keywords that are the observer's; all others are those of `Tuning`."""


@pytest.fixture(scope="session")
def recording() -> RigRecording:
    return make_recording(21, mu=1.4, k=K, bristles=1000)


@pytest.fixture(scope="session")
def steered() -> SteeringRecording:
    return make_steering_recording(5, duration=4.0, rate=500.0)


@pytest.fixture(scope="module")
def interpreted() -> Iterator[None]:
    """Observers without machine code: a few samples of each take less time than its compiler does."""
    with pytest.MonkeyPatch.context() as patch:
        without_machine_code(patch)
        yield


def without_machine_code(patch: pytest.MonkeyPatch) -> None:
    """Has every observer interpreted, and forgets that when the patch ends."""
    for module in (observers.ekf, observers.mhe):
        patch.setattr(module, "compiled", lambda function: function)
        for name in ("_compiled_step", "_compiled_stretch"):
            patch.setattr(module, name, cache(getattr(module, name).__wrapped__))


def make(kind: Callable[..., Any], **settings: Any) -> Any:
    """An observer on the rig's usual tyre; keywords are its own, or those of `Tuning`."""
    own = {name: settings.pop(name) for name in OWN if name in settings}
    usual = {"model": Model(), "values": {"k": K}, "rig": RIG, "tuning": Tuning(**settings)}
    return kind(**{**usual, **own})


@pytest.fixture
def ekf() -> Callable[..., Ekf]:
    """A filter on the rig's usual tyre; see `make`."""
    return lambda **settings: make(Ekf, **settings)


@pytest.fixture
def mhe() -> Callable[..., Mhe]:
    """An estimator on the rig's usual tyre; see `make`."""
    return lambda **settings: make(Mhe, **settings)
