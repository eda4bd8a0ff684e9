from collections.abc import Callable
from typing import Any

import pytest

from observers import Ekf, Mhe, Tuning
from reference_rig import RigRecording, SteeringRecording, Wheel, make_recording, make_steering_recording
from symbolic import Model, Rig

RIG = Rig(a=0.045, e=0.009, J_A=Wheel().J_A, b_t=Wheel().b_t)
K = 2.4e6
OWN = ("model", "values", "rig", "measurement_model", "iterations", "window")
"""Keywords that are the observer's; all others are those of `Tuning`."""


@pytest.fixture(scope="session")
def recording() -> RigRecording:
    return make_recording(21, mu=1.4, k=K, bristles=1000)


@pytest.fixture(scope="session")
def steered() -> SteeringRecording:
    return make_steering_recording(5, duration=4.0, rate=500.0)


def make(kind: Callable[..., Any], **settings: Any) -> Any:
    """An observer on the rig's usual tyre, no floor; keywords are its own, or those of `Tuning`."""
    own = {name: settings.pop(name) for name in OWN if name in settings}
    usual = {
        "model": Model(),
        "values": {"k": K},
        "rig": RIG,
        "tuning": Tuning(**{"mu_floor": 0.0, **settings}),
    }
    return kind(**{**usual, **own})


@pytest.fixture
def ekf() -> Callable[..., Ekf]:
    """A filter on the rig's usual tyre; see `make`."""
    return lambda **settings: make(Ekf, **settings)


@pytest.fixture
def mhe() -> Callable[..., Mhe]:
    """An estimator on the rig's usual tyre; see `make`."""
    return lambda **settings: make(Mhe, **settings)
