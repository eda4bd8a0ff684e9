"""The filter on an emulated Cortex-M4F and M7: equal to Python, within its budget."""

from typing import Any

import numpy as np
import pytest

from observers.embedded import SINGLE
from reference_rig import Array, RigRecording, SteeringRecording
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.cortex.target import M4F, M7, TOOLS, Board, Cost, run_on, tools_installed
from tests.observers.embedded.generated_code import observer_named, python_estimates, rows_of

pytestmark = pytest.mark.skipif(not tools_installed(), reason=TOOLS)


# Instructions a step on average and at most, flash, state and stack [bytes].
PLAIN, ACQUIRING = (1450, 1_800, 9_728, 1_536), (3_650, 9_500, 30_720, 3_072)


def compared(board: Board, generated: Generate, observer: Any, samples: Array) -> tuple[Cost, Array]:
    """What the filter takes on a board, where its friction is Python's, and Python's estimates."""
    cost = run_on(board, generated(observer, SINGLE), samples)
    expected = python_estimates(observer, samples)
    off = np.abs(cost.estimates - expected)[:, 0].max()
    print(
        f"{board.name}: {cost.instructions:.0f} instructions a step, at most {cost.most}; flash"
        f" {cost.flash}, state {cost.state}, stack {cost.stack} bytes; mu off by {off:.1e}"
    )

    assert off < 5e-5
    return cost, expected


@pytest.mark.parametrize(
    ("board", "acquire", "budget"),
    [(M4F, False, PLAIN), (M4F, True, ACQUIRING), (M7, True, ACQUIRING)],
    ids=["M4F-plain", "M4F", "M7"],
)
def test_a_whole_recording(
    generated: Generate,
    recording: RigRecording,
    board: Board,
    acquire: bool,
    budget: tuple[int, int, int, int],
) -> None:
    observer = observer_named("ekf declared aligning", acquire=acquire)
    cost, expected = compared(board, generated, observer, SINGLE.round(rows_of(recording)))

    np.testing.assert_allclose(cost.estimates[:, 5:8], expected[:, 5:8], rtol=1e-4)
    np.testing.assert_allclose(cost.estimates[:, 8], expected[:, 8], rtol=0, atol=1e-4)
    np.testing.assert_array_equal(cost.estimates[:, [3, 4, -1]], expected[:, [3, 4, -1]])
    mean, most, flash, memory = budget
    assert cost.instructions < mean
    assert cost.most < most
    assert cost.flash <= flash
    assert cost.state + cost.stack < memory


@pytest.mark.long
def test_from_the_steering_torque(generated: Generate, steered: SteeringRecording) -> None:
    observer = observer_named("ekf declared steering", acquire=False)
    cost, _ = compared(M4F, generated, observer, SINGLE.round(rows_of(steered)))

    assert cost.instructions < 1700


def test_moving_horizon(generated: Generate, recording: RigRecording) -> None:
    observer = observer_named("mhe declared aligning")
    cost, _ = compared(M4F, generated, observer, SINGLE.round(rows_of(recording)[:700]))

    assert cost.most < 90_000
    assert cost.flash < 33 * 1024
    # All corners of 50 samples.
    assert cost.state < 18.25 * 1024
    assert cost.stack < 2304
