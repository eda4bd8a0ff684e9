"""Methods are what they declare on a path of more than five zones; inputs of the networks are causal."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from brushgrip.comparison.methods import (
    ANALYTIC,
    Method,
    ObserverMethod,
    default_methods,
    neural_network_inputs,
    root_mu_correction_inputs,
)
from identification import Recording
from observers import RootObserver, Sample, run, zone_history
from reference_rig import RigDrive, RigTyre, make_recording, simulate_bristles
from symbolic import Rig
from tests.identification.factories import as_read, with_torque
from tests.identification.factories import recording as recording_along

pytestmark = pytest.mark.usefixtures("interpreted")
MU = 1.2
NESTED_FROM = 7
"""Zones from which [Györök 2022] has no formula."""


@pytest.fixture(scope="module")
def nested() -> Recording:
    """Turns within turns, without noise, from the reference rig."""
    corners = [0.0, 0.4, -0.16, 0.3, -0.1, 0.2]
    legs = [np.linspace(a, b, 150)[1:] for a, b in pairwise(corners)]
    psi = np.concatenate([[0.0], *legs])
    tyre = RigTyre(mu=MU)
    made = recording_along("nested", psi=psi, load=400.0, rig=Rig(a=tyre.a, e=tyre.e), k=tyre.k)
    drive = RigDrive(t=made.t, psi=psi, psi_dot=made.psi_dot, F_N=made.F_N, psi_virgin=0.0)
    return with_torque(made, simulate_bristles(drive, tyre, bristles=4000).M_z)


def named(name: str) -> Method:
    (method,) = [method for method in default_methods() if method.name == name]
    return method


@pytest.mark.parametrize("name", [method.name for method in default_methods()])
def test_beyond_five_zones(nested: Recording, name: str) -> None:
    method = named(name)
    beyond = zone_history(nested.psi).true_zones >= NESTED_FROM
    error = np.abs(method.estimate_mu_eff(nested)[beyond] / MU - 1)
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


@pytest.fixture(scope="module")
def recording() -> Recording:
    return as_read(make_recording(3, duration=8.0, bristles=400), RigTyre())


def part(recording: Recording, samples: int) -> Recording:
    names = ("t", "psi", "psi_dot", "M_z", "F_N")
    return replace(recording, **{name: getattr(recording, name)[:samples] for name in names})


def test_inputs_of_the_neural_network_are_angle_last_reversal_and_torque(recording: Recording) -> None:
    psi, psi_max, M = neural_network_inputs(recording).T
    reversal = int(np.flatnonzero(psi_max)[0])

    np.testing.assert_array_equal(psi, recording.psi - recording.psi[0])
    np.testing.assert_array_equal(M, -recording.M_z)
    # Known once the angle has come back from it, and not before.
    assert abs(psi_max[reversal]) == np.abs(psi[: reversal + 1]).max()
    assert (psi_max[:reversal] == 0).all()


def test_inputs_of_the_correcting_network_hold_the_analytic_estimate(recording: Recording) -> None:
    rows = root_mu_correction_inputs(recording)
    observer = RootObserver(rig=recording.rig, k=recording.tyre.k)
    mu = run(observer, recording.t, recording.psi, recording.F_N, recording.M_z).mu

    np.testing.assert_array_equal(rows[:, :3], neural_network_inputs(recording))
    np.testing.assert_array_equal(rows[:, ANALYTIC], mu)
    assert rows.shape == (recording.t.size, ANALYTIC + 1)
    assert set(rows[1:, 5]) <= {-1.0, 0.0, 1.0}
    assert set(rows[:, 6]) == {0.0, 1.0}


@pytest.mark.parametrize("inputs", [neural_network_inputs, root_mu_correction_inputs])
def test_inputs_are_causal_and_finite_through_missing_torques(
    recording: Recording, inputs: Callable[[Recording], np.ndarray]
) -> None:
    M_z = recording.M_z.copy()
    M_z[[0, 7, 300, 301]] = np.nan
    gaps = replace(recording, M_z=M_z)
    rows = inputs(gaps)

    assert np.isfinite(rows).all()
    assert rows[0, 2] == 0
    assert rows[301, 2] == rows[299, 2]
    np.testing.assert_array_equal(inputs(part(gaps, 500)), rows[:500])
