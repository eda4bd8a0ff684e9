"""Inputs of the networks of [Györök 2022]."""

from dataclasses import replace

import numpy as np
import pytest

from brushgrip.comparison.methods import ANALYTIC, all_inputs, angle_and_torque_inputs
from identification import Recording
from observers import RootObserver, run
from reference_rig import RigTyre, make_recording
from tests.identification.factories import as_read


@pytest.fixture(scope="module")
def recording() -> Recording:
    return as_read(make_recording(3, duration=8.0, bristles=400), RigTyre())


def part(recording: Recording, samples: int) -> Recording:
    names = ("t", "psi", "psi_dot", "M_z", "F_N")
    return replace(recording, **{name: getattr(recording, name)[:samples] for name in names})


def test_inputs_of_the_neural_network_are_angle_last_reversal_and_torque(recording: Recording) -> None:
    psi, psi_max, M = angle_and_torque_inputs(recording).T
    reversal = int(np.flatnonzero(psi_max)[0])

    np.testing.assert_array_equal(psi, recording.psi - recording.psi[0])
    np.testing.assert_array_equal(M, -recording.M_z)
    # Known once the angle has come back from it, and not before.
    assert abs(psi_max[reversal]) == np.abs(psi[: reversal + 1]).max()
    assert (psi_max[:reversal] == 0).all()


def test_inputs_of_the_correcting_network_hold_the_analytic_estimate(recording: Recording) -> None:
    rows = all_inputs(recording)
    mu = run(
        RootObserver(rig=recording.rig, k=recording.tyre.k),
        *(recording.t, recording.psi, recording.F_N, recording.M_z),
    ).mu

    np.testing.assert_array_equal(rows[:, :3], angle_and_torque_inputs(recording))
    np.testing.assert_array_equal(rows[:, ANALYTIC], mu)
    assert rows.shape == (recording.t.size, ANALYTIC + 1)
    assert set(rows[1:, 5]) <= {-1.0, 0.0, 1.0}
    assert set(rows[:, 6]) == {0.0, 1.0}


@pytest.mark.parametrize("inputs", [angle_and_torque_inputs, all_inputs])
def test_inputs_are_causal_and_finite_through_missing_torques(recording: Recording, inputs) -> None:
    M_z = recording.M_z.copy()
    M_z[[0, 7, 300, 301]] = np.nan
    gaps = replace(recording, M_z=M_z)
    rows = inputs(gaps)

    assert np.isfinite(rows).all()
    assert rows[0, 2] == 0
    assert rows[301, 2] == rows[299, 2]
    np.testing.assert_array_equal(inputs(part(gaps, 500)), rows[:500])
