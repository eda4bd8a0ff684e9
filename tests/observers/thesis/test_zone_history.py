"""Direction and zones over time, by hand, against the exact patch and the author's own columns."""

from itertools import pairwise
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from identification import read_recording
from identification.thesis.published_author_estimate import (
    author_estimate_file,
    begin_of_part,
    read_author_estimate,
)
from observers import zone_history
from symbolic.exact_zone_patch import ZonePatch
from symbolic.patch_interface import PatchInputs
from tests.refusal import refused


def path(*corners: float, step: float = 0.01) -> np.ndarray:
    """Straight turns between the corners."""
    legs = [np.linspace(a, b, round(abs(b - a) / step) + 1)[1:] for a, b in pairwise(corners)]
    return np.concatenate([corners[:1], *legs])


def runs(values: np.ndarray) -> list[int]:
    """The values without repetitions."""
    return values[np.r_[True, np.diff(values) != 0]].tolist()


def test_a_growing_swing_has_three_and_five_zones_and_nested_reversals_make_more() -> None:
    made = zone_history(path(0.0, 0.1, -0.2, 0.3))

    assert runs(made.zones) == runs(made.true_zones) == [3, 5, 3, 5, 3]
    assert runs(made.direction) == [0, 1, -1, 1]
    np.testing.assert_allclose(runs(made.psi_max), [0.0, 0.1, -0.2])
    # Every corner lies within the last two; then the angle runs over them all.
    made = zone_history(path(0.0, 0.4, -0.2, 0.2, 0.0, 0.3, -0.5))
    assert runs(made.true_zones) == [3, 5, 7, 9, 11, 7, 9, 5, 3]
    assert runs(made.zones) == [3, 5, 3]


def test_angles_count_from_the_first_sample() -> None:
    psi = path(0.0, 0.1, -0.2)
    moved, there = zone_history(psi + 0.7), zone_history(psi)

    np.testing.assert_array_equal(moved.zones, there.zones)
    np.testing.assert_array_equal(moved.true_zones, there.true_zones)
    assert moved.psi_max[-20] == pytest.approx(0.8)


def test_true_zones_are_those_of_the_exact_patch() -> None:
    rng = np.random.default_rng(8)
    psi = path(0.0, *(0.3 * rng.uniform(0.2, 1, 14) * (-1) ** np.arange(14)))
    patch = ZonePatch()
    inputs = PatchInputs(speed=0.0, dt=0.01, F_N=400.0, factor=1.0, mu=1.2, k=2.4e6, a=0.045, e=0.009)
    before, turn = ca.MX.sym("memory", patch.memory_size), ca.MX.sym("turn")
    advanced = patch.advance(before, turn, patch.coefficients(inputs))
    advance = ca.Function("advance", [before, turn], [advanced])
    memory, found = patch.virgin_memory(), []
    for angle in np.diff(psi, prepend=psi[0]):
        memory = advance(memory, angle).full().ravel()
        corners = memory[: patch.corners]
        found.append(1 + 2 * len(np.unique(np.round(corners))))

    made = zone_history(psi)
    assert made.true_zones.max() == 15
    np.testing.assert_array_equal(found, made.true_zones)


@pytest.mark.parametrize("psi", [np.zeros((2, 2)), np.array([]), np.array([0.0, np.nan])])
def test_nonsense_is_refused(psi: np.ndarray) -> None:
    assert "psi" in refused(zone_history, psi)
    assert "least_turn" in refused(zone_history, np.zeros(3), least_turn=-1.0)


@pytest.mark.measured
def test_the_author_counts_the_same(measured_dir: Path) -> None:
    for file in sorted(measured_dir.glob("*.mat")):
        recording = read_recording(file)
        author = read_author_estimate(author_estimate_file(measured_dir, file.stem))
        first = begin_of_part(recording.psi, author.psi)
        same = slice(first, first + author.psi.size)
        made = zone_history(recording.psi)
        zones = (made.zones[same] == author.zones).mean()
        direction = (made.direction[same] == author.direction).mean()
        print(f"{file.stem}: zones {zones:.1%}, direction {direction:.1%} as the author's")

        assert min(zones, direction) > 0.985
