"""References for the patch that share nothing with it: a fine grid of bristles, closed forms, paths."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import copysign
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbolic import Model, TorqueAndSensitivities, simulate

Array = NDArray[np.float64]
PERIOD = 0.01
"""Time between samples [s]."""


@dataclass(frozen=True, kw_only=True)
class Tyre:
    """Half-length a [m], caster e [m], lateral stiffness k [N/m^2], friction mu [1]."""

    a: float = 0.045
    e: float = 0.009
    k: float = 2.4e6
    mu: float = 1.3

    def slope(self, F_N: float) -> float:
        """The c = 3 F_N mu / (4 a^3 k): turn over half-length, at which sliding spreads [rad/m]."""
        return 3 * F_N * self.mu / (4 * self.a**3 * self.k)


@dataclass(frozen=True, kw_only=True, eq=False)
class Path:
    """Angle [rad] and load [N] of one recording, shape (n,) each, and the tyre under it."""

    psi: Array
    F_N: Array
    tyre: Tyre


TYRE, LOAD = Tyre(), 400.0
"""Those of a test to which no others matter; load in [N]."""
GEOMETRY = np.array([TYRE.a, TYRE.e])
GO = TYRE.slope(LOAD) * TYRE.a
"""Turn at which sliding has spread over half of the patch [rad]."""


def constant(psi: Array, tyre: Tyre = TYRE, F_N: float = LOAD) -> Path:
    """These angles under a constant load."""
    return Path(psi=psi, F_N=np.full(len(psi), F_N), tyre=tyre)


def signals(psi: Array, F_N: Array | float) -> Array:
    """The rows psi, psi_dot, F_N, dt that a model reads."""
    rate = np.gradient(psi, PERIOD) if len(psi) > 1 else np.zeros_like(psi)
    return np.vstack([psi, rate, np.broadcast_to(F_N, psi.shape), np.full_like(psi, PERIOD)])


def run(
    model: Model, path: Path, *, directions: Array | None = None, **effect_values: float
) -> TorqueAndSensitivities:
    """Simulate; effect values by coordinate with a double underscore: effect__parameter."""
    values = {name.replace("__", "."): value for name, value in effect_values.items()}
    theta, geometry = theta_of(model, values, path.tyre), np.array([path.tyre.a, path.tyre.e])
    return simulate(model, signals(path.psi, path.F_N), theta, geometry, directions)


def theta_of(model: Model, values: Mapping[str, float], tyre: Any = TYRE) -> Array:
    """The parameter vector of a tyre with k and mu, and values by `effect.parameter`."""
    return np.asarray(model.theta({"mu": tyre.mu, "k": tyre.k} | dict(values))).ravel()


def flat(planted: Mapping[str, Mapping[str, float]]) -> dict[str, float]:
    """Values of effects by `effect.parameter`."""
    return {f"{name}.{p}": value for name, values in planted.items() for p, value in values.items()}


def grid_torque(*paths: Path, bristles: int = 5000) -> Array:
    """M_z of a uniform grid of elastoplastic stops (midpoint rule), paths side by side, (paths, n)."""
    names = ("a", "e", "k", "mu")
    a, e, k, mu = (np.array([[getattr(path.tyre, name)] for path in paths]) for name in names)
    x = a * ((2 * np.arange(bristles) + 1) / bristles - 1)
    parabola = 3 * mu / (4 * a**3 * k) * (a**2 - x**2)
    share = k * (x - e) * (2 * a / bristles)
    psi = np.stack([path.psi for path in paths])
    turn = np.diff(psi, axis=1, prepend=psi[:, :1])
    F_N = np.stack([np.broadcast_to(path.F_N, path.psi.shape) for path in paths])
    q, M_z = np.zeros_like(x), np.empty_like(psi)
    for i in range(psi.shape[1]):
        q -= (x - e) * turn[:, i : i + 1]
        limit = parabola * F_N[:, i : i + 1]
        np.clip(q, -limit, limit, out=q)
        M_z[:, i] = np.einsum("pb,pb->p", q, share)
    return M_z


def virgin_torque(psi: float, F_N: float, tyre: Tyre, number: Callable[[float], Any] = float) -> float:
    """M_v of a patch turned once from rest: the closed form with its two zone boundaries.

    Decimal as arithmetic takes rounding out of the comparison.
    """
    if psi == 0:
        return 0.0
    a, e, k, mu, load = (number(value) for value in (tyre.a, tyre.e, tyre.k, tyre.mu, F_N))
    turn, half = number(abs(psi)), number(0.5)
    c = 3 * load * mu / (4 * a**3 * k)
    s = turn / c
    x_L = 2 * (s * e + a**2) / (s + ((s + 2 * e) ** 2 + 4 * (a**2 - e**2)) ** half)
    x_R = 2 * (s * e - a**2) / (s + ((s - 2 * e) ** 2 + 4 * (a**2 - e**2)) ** half)

    def P(x: Any) -> Any:
        return c * (a**2 * x**2 / 2 - x**4 / 4 - e * (a**2 * x - x**3 / 3))

    stick = turn * ((x_L - e) ** 3 - (x_R - e) ** 3) / 3
    return copysign(float(k * (stick + P(a) - P(x_L) - P(x_R) + P(-a))), -psi)


def masing_torque(path: Path, *, most: int | None = None, drop: str = "inner") -> Array:
    """M_z under constant load from the stack of turning points alone: Masing's and Madelung's rules.

    Beyond so many turning points at most the innermost or the outermost loop is dropped.
    """
    load = float(path.F_N[0])
    stack, here, side = [float(path.psi[0])], float(path.psi[0]), 0.0
    torques = []
    for psi in path.psi:
        way = np.sign(psi - here)
        if way and way == -side:
            stack.append(here)
        side = way or side
        # A loop that closes is wiped out; the virgin curve is left at either sign of its first turn.
        while len(stack) > 2 and (psi - stack[-2]) * side >= 0:
            del stack[-2:]
        if len(stack) == 2 and abs(psi - stack[0]) >= abs(stack[1] - stack[0]):
            del stack[1:]
        while most is not None and len(stack) > most:
            del stack[slice(-2, None) if drop == "inner" else slice(1, 3)]
        here = float(psi)
        points = [*stack, here]
        torque = virgin_torque(points[1] - points[0], load, path.tyre)
        for begin, end in pairwise(points[1:]):
            torque += 2 * virgin_torque((end - begin) / 2, load, path.tyre)
        torques.append(torque)
    return np.array(torques)


def straight(*corners: float, steps: int = 40) -> Array:
    """Angles along straight turns from corner to corner, the first one at rest."""
    legs = [np.linspace(begin, end, steps + 1)[1:] for begin, end in pairwise(corners)]
    return np.concatenate([np.array([corners[0]]), *legs])


def nested_corners(rng: np.random.Generator, reach: float, depth: int) -> list[float]:
    """Turning points nested `depth` deep, then a turn out beyond them all, and once more inside."""
    low, high = -reach * rng.uniform(0.4, 1.0), reach * rng.uniform(0.4, 1.0)
    corners = [0.0]
    for i in range(depth):
        width = (high - low) * rng.uniform(0.04, 0.3)
        low, high = (low, high - width) if i % 2 == 0 else (low + width, high)
        corners.append(high if i % 2 == 0 else low)
    side = rng.choice([-1.0, 1.0])
    return [*corners, 1.2 * side * reach, 0.3 * side * reach, 0.8 * side * reach]


def wandering_load(rng: np.random.Generator, n: int) -> Array:
    """Load between 340 N and 460 N, slow and fast waves together."""
    at = np.linspace(0, 1, n)
    waves = sum(
        rng.uniform(0.3, 1) / f**0.5 * np.sin(2 * np.pi * (f * at + rng.random()))
        for f in rng.uniform(0.5, 12, 6)
    )
    return 400 * (1 + 0.15 * waves / np.max(np.abs(waves)))


def random_path(seed: int, *, depth: int = 12, samples: int = 600) -> Path:
    """A random tyre on a random path of up to `depth` nested reversals under a wandering load."""
    rng = np.random.default_rng(seed)
    a = rng.uniform(0.03, 0.06)
    tyre = Tyre(a=a, e=a * rng.uniform(-0.7, 0.7), k=10 ** rng.uniform(4.5, 6.5), mu=rng.uniform(0.4, 2))
    reach = tyre.slope(400.0) * a * 10 ** rng.uniform(-0.3, 1.2)
    corners = nested_corners(rng, reach, int(rng.integers(depth // 3, depth + 1)))
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(corners)) ** 0.5)])
    psi = np.interp(np.linspace(0, way[-1], samples), way, corners)
    return Path(psi=psi, F_N=wandering_load(rng, samples), tyre=tyre)


def worst(M_z: Array, reference: Array) -> float:
    """Largest error in shares of the reference's range."""
    return float(np.max(np.abs(M_z - reference)) / np.ptp(reference))
