"""The properties that methods declare are true on a path with more than five zones."""

from itertools import pairwise

import numpy as np
import pytest

from brushgrip.comparison.methods import Method, ObserverMethod, default_methods
from identification import Recording
from observers import Sample, zone_history
from reference_rig import RigDrive, RigTyre, simulate_bristles
from symbolic import Rig, Tyre

pytestmark = pytest.mark.usefixtures("interpreted")
MU = 1.2
RATE = 100.0
NESTED_FROM = 7
"""Zones from which [Györök 2022] has no formula."""


@pytest.fixture(scope="module")
def nested() -> Recording:
    """Turns within turns, without noise, from the reference rig."""
    corners = [0.0, 0.4, -0.16, 0.3, -0.1, 0.2]
    legs = [np.linspace(a, b, 150)[1:] for a, b in pairwise(corners)]
    psi = np.concatenate([[0.0], *legs])
    t = np.arange(psi.size) / RATE
    rate, load = np.gradient(psi, t), np.full(t.size, 400.0)
    drive = RigDrive(t=t, psi=psi, psi_dot=rate, F_N=load, psi_virgin=0.0)
    tyre = RigTyre(mu=MU)
    return Recording(
        name="nested",
        t=t,
        psi=psi,
        psi_dot=rate,
        M_z=simulate_bristles(drive, tyre, bristles=4000).M_z,
        F_N=load,
        rig=Rig(a=tyre.a, e=tyre.e),
        tyre=Tyre(k=tyre.k),
    )


def named(name: str) -> Method:
    (method,) = [method for method in default_methods() if method.name == name]
    return method


@pytest.mark.parametrize("name", [method.name for method in default_methods()])
def test_beyond_five_zones(nested: Recording, name: str) -> None:
    method = named(name)
    beyond = zone_history(nested.psi).true_zones >= NESTED_FROM
    error = np.abs(method.estimate(nested)[beyond] / MU - 1)
    print(f"{name}: off by up to {error.max():.2%} in {beyond.mean():.0%} of the samples")

    assert beyond.mean() > 0.3
    assert (error.max() < 0.01) == method.works_beyond_five_zones
    assert error.max() < 0.01 or error.max() > 0.1


@pytest.mark.parametrize(
    "method", [m for m in default_methods() if isinstance(m, ObserverMethod)], ids=lambda m: m.name
)
def test_deviation(nested: Recording, method: ObserverMethod) -> None:
    # That of the C is held against the observer's in tests/observers/embedded.
    observer = method.factory(nested, None)
    first = Sample(psi=0.0, psi_dot=0.0, F_N=400.0, dt=0.01, M_z=0.0)

    estimate = observer.estimate(observer.step(observer.init(first), first))
    assert np.isfinite(estimate.mu_std) == method.gives_deviation
