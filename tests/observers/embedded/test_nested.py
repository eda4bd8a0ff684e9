"""C and Python agree on a patch full of corners: up to where the first one is dropped, and beyond."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from observers.embedded import DOUBLE, SINGLE
from observers.embedded.patches.exact_patch import DEPTH
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import (
    cases,
    needs_compiler,
    observer_named,
    python_estimates,
)
from tests.observers.embedded.ordinary_steering import decreasing, path, samples_along, samples_of_path
from tests.observers.embedded.test_patch import Patch

pytestmark = needs_compiler
Array = NDArray[np.float64]
EACH = cases(
    "ekf declared aligning; mhe declared aligning; ekf declared steering",
    "mhe declared steering; ekf declared aligning,k; mhe declared aligning,k",
)


def nested(turns: int, observer: Any) -> Array:
    """Samples (n, 5) of reversals each inside the last, then out through all of them."""
    targets = [*decreasing(turns, last=0.05), 0.35]
    return samples_of_path(path(targets, pace=2.0), observer)


@pytest.mark.parametrize("turns", [DEPTH - 4, DEPTH + 6], ids=["up to the cap", "beyond it"])
@pytest.mark.parametrize("name", EACH)
def test_nested_reversals(generated: Generate, name: str, turns: int) -> None:
    observer = observer_named(name)
    rows = nested(turns, observer)
    expected = python_estimates(observer, rows)
    estimates = generated(observer, DOUBLE).run(rows)

    np.testing.assert_allclose(estimates[:, :3], expected[:, :3], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(estimates[:, [3, 4, -1]], expected[:, [3, 4, -1]])


def test_the_paths_reach_the_cap(generated: Generate) -> None:
    observer = observer_named("ekf declared aligning")
    patch = Patch(generated(observer, DOUBLE))
    most = [
        patch.run(rows[:, 0], rows[:, 3]).corners.max()
        for rows in (nested(turns, observer) for turns in (DEPTH - 4, DEPTH + 6))
    ]

    assert most[0] > 20
    assert most[1] == DEPTH - 2


def test_single_precision_where_the_model_explains_the_torque(generated: Generate) -> None:
    observer = observer_named("ekf declared aligning")
    rows = SINGLE.round(samples_along(decreasing(), observer))
    off = np.abs(generated(observer, SINGLE).run(rows) - python_estimates(observer, rows))
    print(f"mu off by {off[:, 0].max():.1e}, later by {off[100:, 0].max():.1e}")

    assert off[100:, 0].max() < 1e-5
