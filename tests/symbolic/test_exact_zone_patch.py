"""The exact patch against 5,000 bristles, against Masing's rules, and piece by piece."""

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from symbolic import InvalidInputError, Model
from symbolic.exact_zone_patch import NEAR, ZonePatch
from tests.symbolic.oracles import (
    GEOMETRY,
    GO,
    LOAD,
    TYRE,
    Array,
    Path,
    Tyre,
    constant,
    grid_torque,
    masing_torque,
    nested_corners,
    random_path,
    run,
    signals,
    straight,
    wandering_load,
    worst,
)

pytestmark = pytest.mark.usefixtures("interpreted")
SAMPLES = 400
SLIDE = 3 / 8 * TYRE.mu * LOAD * TYRE.a
TURNS = st.integers(-6144, 6144).map(lambda number: number / 1024)
"""Turning points in units of GO, so that loops close to the bit or by far more than `NEAR`."""


def turning(*corners: float, tyre: Tyre = TYRE) -> Path:
    """Straight turns in units of GO, filled up with rest, at constant load."""
    psi = GO * straight(*corners, steps=SAMPLES // len(corners))
    return constant(np.pad(psi, (0, SAMPLES - len(psi)), mode="edge"), tyre)


def at_corners(*corners: float) -> Path:
    """One sample a corner, in units of GO, at constant load."""
    return constant(GO * np.array(corners))


def loaded(path: Path, *jumps: tuple[int, float]) -> Path:
    """The path with the load multiplied by a factor from a sample on."""
    F_N = path.F_N.copy()
    for sample, factor in jumps:
        F_N[sample:] *= factor
    return replace(path, F_N=F_N)


REVERSALS = (0.0, 3.0, -2.0, 1.0, -0.5, 2.5, 2.4)
DWELL = turning(0.0, 1.5, 1.5, 0.4, 0.4, 1.0, -3.0)
SPECIAL = {
    "no caster": turning(*REVERSALS, tyre=replace(TYRE, e=0.0)),
    "caster near the edge": turning(*REVERSALS, tyre=replace(TYRE, e=0.98 * TYRE.a)),
    "trail near the edge": turning(*REVERSALS, tyre=replace(TYRE, e=-0.98 * TYRE.a)),
    "tiny turns": turning(*(1e-7 * corner for corner in REVERSALS)),
    "tiny turns after a slide": turning(0.0, 5.0, 4.99999, 5.00001, 4.999, 5.0),
    "huge turns": turning(*(300 * corner for corner in REVERSALS)),
    "dwell": DWELL,
    "dwell under a wandering load": replace(
        DWELL, F_N=wandering_load(np.random.default_rng(5), SAMPLES)
    ),
    "load jumps at rest": loaded(DWELL, (80, 0.6), (90, 1.9), (100, 0.5), (200, 1.6), (350, 0.7)),
    "load drops by half in a nest": loaded(turning(*REVERSALS), (260, 0.5)),
    "load drops by half in a slide": loaded(turning(0.0, 8.0, -8.0), (100, 0.5), (300, 2.0)),
    "load lifted off": loaded(turning(*REVERSALS), (150, 1e-6), (250, 1e6)),
    "path that starts off zero": turning(0.7, 3.0, -2.0, 1.0),
}


@st.composite
def histories(draw: st.DrawFn) -> Path:
    """Any tyre through any turns, some nested up to twelve deep, under a load that always changes."""
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    a = draw(st.floats(0.03, 0.06))
    own = {"e": a * draw(st.floats(-0.7, 0.7)), "k": 10 ** draw(st.floats(4.5, 6.5))}
    tyre = Tyre(a=a, **own, mu=draw(st.floats(0.4, 2.0)))
    nested = st.integers(4, 12).map(lambda depth: nested_corners(rng, 6.0, depth))
    free = st.lists(TURNS, min_size=2, max_size=10).map(lambda turns: [0.0, *turns])
    corners = draw(st.one_of(free, nested))
    shares = draw(st.lists(st.floats(0.5, 1.8), min_size=len(corners), max_size=len(corners)))
    assume(np.ptp(corners) > 0.5)
    psi = tyre.slope(LOAD) * a * straight(*corners, steps=40)
    F_N = straight(*shares, steps=40) * wandering_load(rng, len(psi))
    return Path(psi=psi, F_N=F_N, tyre=tyre)


@settings(max_examples=40)
@given(path=histories())
def test_any_history_of_angle_and_load_follows_the_grid(path: Path) -> None:
    (reference,) = grid_torque(path, bristles=10_000)

    assert worst(run(Model(), path).M_z, reference) <= 1e-6, "what remains is the grid's own error, 3e-7"


def test_special_paths_follow_the_grid() -> None:
    references = grid_torque(*SPECIAL.values())

    errors = {
        name: worst(run(Model(), path).M_z, reference)
        for (name, path), reference in zip(SPECIAL.items(), references, strict=True)
    }

    assert {name: error for name, error in errors.items() if not error <= 1e-6} == {}


@given(corners=st.lists(TURNS, min_size=1, max_size=8))
@example(corners=[2.0, 0.5, 1.5, 1.0, 1.5, 0.5, 2.0, 2.5])
def test_masing_and_madelung_hold_to_rounding_under_constant_load(corners: list[float]) -> None:
    path = at_corners(*straight(0.0, *corners, steps=16))

    np.testing.assert_allclose(run(Model(), path).M_z, masing_torque(path), rtol=0, atol=1e-11 * SLIDE)


@pytest.mark.parametrize("short", [1e-3, 1e-6, 1e-7, 1e-9, 1e-12])
def test_loop_that_nearly_closes_costs_less_than_narrow_segments_may(short: float) -> None:
    path = at_corners(0.0, -2.0, -1.0, -2.0 + short, 0.0, -2.0 - short)

    np.testing.assert_allclose(run(Model(), path).M_z, masing_torque(path), rtol=0, atol=NEAR * SLIDE)


def test_closed_loop_leaves_no_corner() -> None:
    """Corners that cancel would not show in M_z, but fill the memory."""
    plain = GO * np.array([0.0, 1.0, 2.0, 3.0])
    looped = GO * np.array([0.0, 1.0, 2.0, 0.5, 1.5, 1.0, 1.5, 0.5, 2.0, 3.0])

    memories = [final_memory(Model(), psi, LOAD) for psi in (plain, looped)]

    np.testing.assert_allclose(memories[1], memories[0], rtol=1e-12, atol=0)


def final_memory(
    model: Model, psi: Array, F_N: Array | float, mu: float = 1.3, k: float = 2.4e6
) -> Array:
    """The memory after the last sample."""
    theta = ca.DM([mu, k])
    samples = signals(psi, F_N)
    memory = model.initial(samples[:, 0], theta, GEOMETRY)
    for sample in samples.T:
        memory, _ = model.step(memory, sample, theta, GEOMETRY)
    return np.asarray(memory).ravel()


def test_memory_does_not_depend_on_friction_or_stiffness() -> None:
    path = random_path(3, samples=300)

    memories = [
        final_memory(Model(), path.psi, path.F_N, mu=mu, k=k)
        for mu, k in ((1.3, 2.4e6), (0.05, 2.4e6), (1.7, 3.1e4))
    ]

    assert memories[0].tobytes() == memories[1].tobytes() == memories[2].tobytes()


def test_memory_is_one_corner_a_turning_point() -> None:
    psi = GO * straight(0.0, 3.0, -2.0, 1.0, -0.5, 0.2, steps=5)
    xi, r = np.split(final_memory(Model(), psi, LOAD)[1:], 2)
    used = np.count_nonzero(np.diff(xi, prepend=0.0) > 0)

    # Where the reversal from psi_i met the limit: xi = 2 level / |psi_j - psi_i|, the virgin turn once.
    level = 3 * LOAD / (4 * TYRE.a**3)
    turns = np.abs(np.diff(GO * np.array([0.0, 3.0, -2.0, 1.0, -0.5, 0.2])))
    assert used == len(turns)
    np.testing.assert_allclose(xi[:used], level * np.array([1, 2, 2, 2, 2]) / turns, rtol=1e-12)
    np.testing.assert_allclose(np.abs(r[used - 1]), level, rtol=1e-15)


@pytest.mark.parametrize("corners", [3, 0, -1])
def test_too_few_corners_are_refused(corners: int) -> None:
    with pytest.raises(InvalidInputError, match=f"corners must be at least 4, got {corners}"):
        ZonePatch(corners=corners)
