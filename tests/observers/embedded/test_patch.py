"""The compact patch against the exact `symbolic.exact_zone_patch` and bristles, also full of corners."""

import ctypes
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import DOUBLE, SINGLE, Real
from observers.embedded.patches.exact_patch import DEPTH
from reference_rig import hand_path
from symbolic import Model, full_slide_level, simulate
from symbolic.float_array_type import Array
from tests.observers.conftest import RIG, K
from tests.observers.embedded.conftest import Generate
from tests.observers.embedded.generated_code import (
    DECLARED,
    GeneratedCode,
    cases,
    needs_compiler,
    observer_named,
    observer_of,
    python_estimates,
)
from tests.observers.embedded.ordinary_steering import decreasing, path, samples_of_path

pytestmark = needs_compiler
MU = 1.3
EXACT = Model(corners=96)
CAP = DEPTH - 2
"""With so many corners one is dropped before the next sample."""
STEERING = observer_of(Ekf, DECLARED, SteeringTorque())


@dataclass(frozen=True)
class PatchPath:
    """The patch along a path: M_z [N m], its derivatives by mu and by the angle, corners in use."""

    M_z: Array
    by_mu: Array
    by_psi: Array
    corners: Array


class Patch:
    """The patch of generated code."""

    def __init__(self, code: GeneratedCode) -> None:
        """Compile the patch of generated code."""
        sources = (str(Path(__file__).with_name("patch.c")),)
        flags = ("-O1", "-fPIC", "-shared", "-std=c99", "-Wall", "-Wextra")
        library = code.compile(*flags, sources=sources, out="p.so")
        self.real, self._library = code.real, ctypes.CDLL(str(library))

    def run(self, psi: Array, F_N: Array, mu: float = MU) -> PatchPath:
        """Along angles [rad] and loads [N], at rest at the first angle."""
        number = getattr(ctypes, f"c_{self.real.c_type}")
        level = full_slide_level(F_N, RIG.a).astype(self.real.dtype)
        angles, actual = psi.astype(self.real.dtype), np.zeros((psi.size, 4), self.real.dtype)
        patch = ctypes.create_string_buffer(self._library.patch_size())
        self._library.patch_init(patch, number(float(angles[0])))
        inputs = [ctypes.c_void_p(array.ctypes.data) for array in (angles, level)]
        seen = number(mu / K), ctypes.c_void_p(actual.ctypes.data)
        self._library.patch_run(patch, ctypes.c_int64(psi.size), *inputs, *seen)
        moment, by_scale, by_psi, corners = actual.astype(float).T
        return PatchPath(K * moment, by_scale, K * by_psi, corners)

    def number(self, name: str, x: float) -> float:
        """A function of a number by its name."""
        function = getattr(self._library, name)
        function.restype = number = getattr(ctypes, f"c_{self.real.c_type}")
        return float(function(number(x)))


@pytest.fixture(scope="session")
def patch(generated: Generate) -> Patch:
    return Patch(generated(STEERING, DOUBLE))


@pytest.fixture(scope="session")
def single_patch(generated: Generate) -> Patch:
    return Patch(generated(STEERING, SINGLE))


def exact(psi: Array, F_N: Array, mu: float = MU) -> tuple[Array, Array]:
    """M_z of the exact patch and its derivative by mu."""
    signals = np.vstack([psi, np.zeros_like(psi), F_N, np.full_like(psi, 0.01)])
    actual = simulate(EXACT, signals, np.array([mu, K]), np.array([RIG.a, RIG.e]), np.eye(2)[:, :1])
    return actual.M_z, actual.sensitivities[:, 0]


def with_equal_capacity(psi: Array, F_N: Array) -> Array:
    """M_z of the exact patch with no more corners than the compact one has."""
    signals = np.vstack([psi, np.zeros_like(psi), F_N, np.full_like(psi, 0.01)])
    return simulate(Model(corners=DEPTH), signals, np.array([MU, K]), np.array([RIG.a, RIG.e])).M_z


def steady(count: int) -> Array:
    return np.full(count, 400.0)


def wandering(seed: int, count: int = 300, size: float = 0.02) -> Array:
    """A path that turns back at random, small loops inside large ones."""
    rng = np.random.default_rng(seed)
    steps = size * rng.standard_normal(count) * rng.choice([1.0, 0.1, 0.01], count)
    held = rng.random(count) < 0.1
    return np.concatenate([[0.0], np.cumsum(np.where(held, 0.0, steps))])


def nested(turns: int) -> Array:
    """Reversals each inside the last, then out again through all of them."""
    tops = 0.3 * 0.8 ** np.arange(turns) * (-1.0) ** np.arange(turns)
    corners = np.concatenate([[0.0], tops, tops[::-1] * 1.02])
    return np.concatenate([np.linspace(a, b, 13)[1:] for a, b in pairwise(corners)])


def loads(seed: int, count: int) -> Array:
    """A load that swings, jumps, and is almost lost for a while."""
    rng = np.random.default_rng(seed)
    F_N = 400 + 150 * np.sin(0.05 * np.arange(count)) + 20 * rng.standard_normal(count)
    F_N[count // 2 :] *= 1.5
    F_N[count // 3 : count // 3 + 20] = 5.0
    return F_N


PATHS = [
    pytest.param(hand_path(3, 8.0, load=400.0, rate=100.0).psi, id="by hand"),
    pytest.param(wandering(1), id="wandering"),
    pytest.param(wandering(2, size=0.2), id="wandering far"),
    pytest.param(nested(9), id="nested"),
    pytest.param(np.repeat([0.0, 0.1, 0.1, -0.2, -0.2, 0.05], 3), id="steps and rests"),
    pytest.param(np.linspace(0, 1e-6, 50) + 0.2, id="hardly moving"),
]


@pytest.mark.parametrize("varying", [False, True], ids=["steady load", "varying load"])
@pytest.mark.parametrize("psi", PATHS)
def test_is_the_exact_patch(patch: Patch, psi: Array, varying: bool) -> None:
    F_N = loads(1, psi.size) if varying else steady(psi.size)
    actual = patch.run(psi, F_N)
    M_z, by_mu = exact(psi, F_N)

    assert actual.corners.max() < CAP, "the path overflows the patch, which is another test"
    np.testing.assert_allclose(actual.M_z, M_z, rtol=0, atol=1e-11 * max(1e-3, np.ptp(M_z)))
    np.testing.assert_allclose(actual.by_mu, by_mu, rtol=0, atol=1e-9 * max(1e-3, np.ptp(M_z)))


@pytest.mark.parametrize("varying", [False, True], ids=["steady load", "varying load"])
@pytest.mark.parametrize("seed", range(4))
def test_slope_by_the_angle(patch: Patch, seed: int, varying: bool) -> None:
    # The last turn goes on by a little in either direction; elsewhere the slope has a kink.
    psi = wandering(seed, count=40, size=0.05)
    F_N = loads(seed, psi.size) if varying else steady(psi.size)
    turn = psi[-1] - psi[-2]
    actual = patch.run(psi, F_N).by_psi[-1]
    beside = [np.append(psi[:-1], psi[-1] + h) for h in (1e-3 * turn, -1e-3 * turn)]
    ends = [patch.run(path, F_N).M_z[-1] for path in beside]

    assert turn != 0
    assert actual == pytest.approx((ends[0] - ends[1]) / (2e-3 * turn), rel=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_single_precision(single_patch: Patch, patch: Patch, seed: int) -> None:
    psi = SINGLE.round(wandering(seed, count=2000))
    F_N = SINGLE.round(loads(seed, psi.size))
    actual, better = single_patch.run(psi, F_N), patch.run(psi, F_N)

    assert np.abs(actual.M_z - better.M_z).max() < 2e-5 * np.ptp(better.M_z)


@pytest.mark.parametrize("real", [DOUBLE, SINGLE], ids=["double", "single"])
def test_loops_that_close_to_the_last_digit(patch: Patch, single_patch: Patch, real: Real) -> None:
    # An encoder gives the same angle again, and the far limit is then reached without a remainder.
    rng, parts = np.random.default_rng(1), [np.zeros(1)]
    for side in (-1.0, 1.0) * 150:
        there, back = rng.uniform(-0.5, 0.5), rng.uniform(0.03, 0.2)
        parts += [np.linspace(0.8 * side, there, 8), [there + side * back], np.full(3, there)]
    psi = SINGLE.round(np.concatenate(parts))
    actual = (patch if real is DOUBLE else single_patch).run(psi, steady(psi.size))
    expected, _ = exact(psi, steady(psi.size))

    assert np.abs(actual.M_z - expected).max() < 1e-4 * np.ptp(expected)


def overflowing(path: str) -> tuple[Array, Array]:
    """Angles and loads that need more corners than there are."""
    rng = np.random.default_rng(1)
    t = np.arange(0, {"decaying": 10, "noise": 100, "load": 20}[path], 0.01)
    if path == "decaying":
        return 0.3 * np.exp(-0.15 * t) * np.sin(15 * t), steady(t.size)
    if path == "noise":
        return 0.2 * np.minimum(t, 1) + 2e-3 * rng.standard_normal(t.size), steady(t.size)
    # A limit that rises while the wheel turns leaves a corner behind at every sample.
    wander = wandering(9, count=t.size - 1, size=1e-5)
    return 0.3 * np.sin(t) + wander, 400 * (1 + 0.3 * np.sin(2.3 * t))


@pytest.mark.parametrize(("path", "most"), [("decaying", 4e-3), ("noise", 1e-3), ("load", 1e-3)])
def test_overflow_drops_the_corner_of_least_torque(patch: Patch, path: str, most: float) -> None:
    psi, F_N = overflowing(path)
    actual, (M_z, by_mu) = patch.run(psi, F_N), exact(psi, F_N)
    off, range_ = np.abs(actual.M_z - M_z).max(), np.ptp(M_z)
    by_vectors = with_equal_capacity(psi, F_N)
    print(f"{path}: off by {off / range_:.1e} of range")

    assert actual.corners.max() >= CAP or path == "noise"
    assert off < most * range_
    np.testing.assert_allclose(actual.M_z, by_vectors, rtol=0, atol=1e-10)
    assert np.abs(actual.by_mu - by_mu).max() < 2e-2 * np.ptp(by_mu) or path == "decaying"


@pytest.mark.long
def test_swinging_to_rest_under_noise_of_the_angle(generated: Generate, patch: Patch) -> None:
    # Every swing leaves a corner, and the noise of the angle a few more.
    rng, t = np.random.default_rng(0), np.arange(0, 30, 0.01)
    psi = 0.25 * np.exp(-t / 4) * np.sin(4.4 * t) + 2e-4 * rng.standard_normal(t.size)
    psi += np.where(t > 20, 0.01 * (t - 20) * np.sin(4.4 * (t - 20)), 0.0)
    M_z, _ = exact(psi, steady(t.size))
    rows = np.column_stack([psi, np.full(t.size, np.nan), M_z, steady(t.size), np.full(t.size, 0.01)])
    observer = observer_of(Mhe, DECLARED, AligningTorque())
    estimates = generated(observer, DOUBLE).run(rows)

    assert np.abs(patch.run(psi, steady(t.size)).M_z - M_z).max() < 1e-3 * np.ptp(M_z)
    deviation = np.abs(estimates - python_estimates(observer, rows))
    assert deviation[:, 0].max() < 1e-5
    assert deviation[1:, 2].max() < 1e-3 * np.ptp(M_z)


@pytest.mark.parametrize("far", [1e3, 1e8, -1e15])
def test_no_turn_is_so_far_that_the_patch_never_comes_back(single_patch: Patch, far: float) -> None:
    swing = 0.3 * np.sin(0.05 * np.arange(400))
    path = np.concatenate([[0.0, 0.1], np.full(3, far), np.full(3, 0.5 * far), swing])
    actual = single_patch.run(path, steady(path.size))
    expected = exact(np.concatenate([[np.sign(far) * 50], swing]), steady(401))[0]

    np.testing.assert_allclose(actual.M_z[-300:], expected[-300:], atol=0.02)


def test_exp_and_log_of_single_precision(single_patch: Patch) -> None:
    for x in np.linspace(-86, 86, 3001):
        rounded = float(np.float32(x))
        assert single_patch.number("exp_of", rounded) == pytest.approx(np.exp(rounded), rel=3e-7)
    for y in np.geomspace(1e-37, 1e37, 3001):
        rounded = float(np.float32(y))
        error = abs(single_patch.number("log_of", rounded) - np.log(rounded))
        assert error < 2e-7 * max(1.0, abs(np.log(rounded)))
    exp, log = (lambda x, name=name: single_patch.number(name, x) for name in ("exp_of", "log_of"))
    assert [exp(x) for x in (-np.inf, -200.0, 0.0, 200.0, np.inf)] == [0.0, 0.0, 1.0, np.inf, np.inf]
    assert [log(x) for x in (0.0, 1.0, np.inf)] == [-np.inf, 0.0, np.inf]
    assert log(1e-42) == pytest.approx(np.log(np.float32(1e-42)), rel=1e-6)
    assert np.isnan([exp(np.nan), log(np.nan), log(-1.0)]).all()


EACH = cases(
    "ekf declared aligning; mhe declared aligning; ekf declared steering",
    "mhe declared steering; ekf declared aligning,k; mhe declared aligning,k",
)


def nested_samples(turns: int, observer: Any) -> Array:
    """Samples (n, 5) of reversals each inside the last, then out through all of them."""
    targets = [*decreasing(turns, last=0.05), 0.35]
    return samples_of_path(path(targets, pace=2.0), observer)


@pytest.mark.parametrize("turns", [DEPTH - 4, DEPTH + 6], ids=["up to the cap", "beyond it"])
@pytest.mark.parametrize("name", EACH)
def test_nested_reversals(generated: Generate, name: str, turns: int) -> None:
    observer = observer_named(name)
    rows = nested_samples(turns, observer)
    expected = python_estimates(observer, rows)
    estimates = generated(observer, DOUBLE).run(rows)

    np.testing.assert_allclose(estimates[:, :3], expected[:, :3], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(estimates[:, [3, 4, -1]], expected[:, [3, 4, -1]])


def test_the_paths_reach_the_cap(generated: Generate) -> None:
    observer = observer_named("ekf declared aligning")
    patch = Patch(generated(observer, DOUBLE))
    most = [
        patch.run(rows[:, 0], rows[:, 3]).corners.max()
        for rows in (nested_samples(turns, observer) for turns in (DEPTH - 4, DEPTH + 6))
    ]

    assert most[0] > 20
    assert most[1] == DEPTH - 2
