from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest

from observers import Ekf, Mhe, Tuning
from reference_rig import RigRecording, SteeringRecording, Wheel, make_recording, make_steering_recording
from symbolic import Model, Rig, Tolerances

RIG = Rig(a=0.045, e=0.009, J_A=Wheel().J_A, b_t=Wheel().b_t)
K = 2.4e6
STIFFNESS_STD = 0.2
"""Standard deviation of k over its nominal value where it is a state [1]."""
EXACT_RIG = replace(RIG, tolerances=Tolerances(a=0.0, e=0.0, load=0.0, k=0.0), dry_friction=0.0)
"""The same without doubt about any value."""
OWN = ("model", "values", "rig", "measurement_model", "iterations", "window", "acquire")
"""Keywords that are the observer's; all others are those of `Tuning`."""


@pytest.fixture(scope="session")
def recording() -> RigRecording:
    return make_recording(21, mu=1.4, k=K, bristles=1000)


@pytest.fixture(scope="session")
def steered() -> SteeringRecording:
    return make_steering_recording(5, duration=4.0, rate=500.0)


def make(kind: Callable[..., Any], **settings: Any) -> Any:
    """An estimator alone on the rig's usual tyre; keywords are its own, or those of `Tuning`.

    All that the rig declares is exact, and friction is not acquired unless `acquire` asks for it.
    """
    own = {name: settings.pop(name) for name in OWN if name in settings}
    usual = {
        "model": Model(),
        "values": {"k": K},
        "rig": EXACT_RIG,
        "acquire": False,
        "tuning": Tuning(**{"mu_floor": 0.0, "stiffness_std": STIFFNESS_STD, **settings}),
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
