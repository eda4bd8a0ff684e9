"""The filter on an emulated Cortex-M4F and M7: it says what Python says, within its budget."""

import numpy as np
import pytest

from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import SINGLE
from reference_rig import RigRecording, SteeringRecording
from tests.observers.embedded.building import DECLARED, observer_of, said_by
from tests.observers.embedded.conftest import Build
from tests.observers.embedded.cortex.target import M4F, M7, NEEDED, Board, Cost, at_hand, run_on
from tests.observers.factories import columns_of, samples_of

pytestmark = pytest.mark.skipif(not at_hand(), reason=NEEDED)


@pytest.mark.parametrize("board", [M4F, M7], ids=["M4F", "M7"])
def test_a_whole_recording(built: Build, recording: RigRecording, board: Board) -> None:
    observer = observer_of(Ekf, DECLARED, AligningTorque())
    rows = [(s.psi, s.psi_dot, s.M_z, s.F_N, s.dt) for s in samples_of(columns_of(recording))]
    samples = SINGLE.round(np.array(rows))
    cost = run_on(board, built(observer, SINGLE), samples)
    expected = said_by(observer, samples, turns=False)
    off = np.abs(cost.said - expected)[:, 0]
    print(told(board.name, cost, off.max()))

    assert off.max() < 5e-6
    np.testing.assert_array_equal(cost.said[:, 3:], expected[:, 3:])
    assert cost.instructions < 1000
    assert cost.flash <= 6144
    assert cost.state + cost.stack < 1024


def test_from_the_steering_torque(built: Build, steered: SteeringRecording) -> None:
    observer = observer_of(Ekf, DECLARED, SteeringTorque())
    rows = [(s.psi, s.psi_dot, s.M, s.F_N, s.dt) for s in samples_of(columns_of(steered))]
    samples = SINGLE.round(np.array(rows))
    cost = run_on(M4F, built(observer, SINGLE), samples)
    off = np.abs(cost.said - said_by(observer, samples, turns=True))[:, 0]
    print(told("steering", cost, off.max()))

    assert off.max() < 5e-6
    assert cost.instructions < 1500


def test_moving_horizon(built: Build, recording: RigRecording) -> None:
    observer = observer_of(Mhe, DECLARED, AligningTorque())
    rows = [(s.psi, s.psi_dot, s.M_z, s.F_N, s.dt) for s in samples_of(columns_of(recording))]
    samples = SINGLE.round(np.array(rows[:700]))
    cost = run_on(M4F, built(observer, SINGLE), samples)
    off = np.abs(cost.said - said_by(observer, samples, turns=False))[:, 0]
    print(told("moving horizon", cost, off.max()))

    assert off.max() < 5e-6
    assert cost.most < 90_000
    assert cost.flash < 24 * 1024
    assert cost.state < 8 * 1024
    assert cost.stack < 1024


def told(name: str, cost: Cost, off: float) -> str:
    return (
        f"{name}: {cost.instructions:.0f} instructions a step, at most {cost.most}; flash {cost.flash},"
        f" state {cost.state}, stack {cost.stack} bytes; mu off by {off:.1e}"
    )
