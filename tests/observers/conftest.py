from collections.abc import Callable

import pytest

from observers import Ekf, Mhe, Tuning
from symbolic import Model, Rig
from tests.rig.record import RigRecording, make_recording

RIG = Rig(a=0.045, e=0.009)
K = 2.4e6


@pytest.fixture(scope="session")
def recording() -> RigRecording:
    return make_recording(21, mu=1.4, k=K, bristles=1000)


@pytest.fixture
def ekf() -> Callable[..., Ekf]:
    """A filter on the rig's usual tyre; keywords are those of `Tuning`."""
    return lambda **tuning: Ekf(model=Model(), values={"k": K}, rig=RIG, tuning=Tuning(**tuning))


@pytest.fixture
def mhe() -> Callable[..., Mhe]:
    """An estimator on the rig's usual tyre; keywords are those of `Mhe`, or of `Tuning`."""
    own = ("window", "iterations", "huber")

    def make(**settings: float | None) -> Mhe:
        chosen = {name: settings.pop(name) for name in own if name in settings}
        return Mhe(model=Model(), values={"k": K}, rig=RIG, tuning=Tuning(**settings), **chosen)

    return make
