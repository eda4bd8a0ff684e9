"""Iwan's elements: against many stops added up in NumPy, Masing's rule, and Segalman's closed form."""

from itertools import pairwise
from math import gamma

import numpy as np
import pytest

from symbolic import CANDIDATES, EFFECTS, InvalidInputError, Model, effects_in, effects_named
from symbolic.effects import iwan
from symbolic.effects.library import KNOWN
from tests.symbolic.oracles import LOAD, Array, Tyre, constant, run, straight, worst

pytestmark = pytest.mark.usefixtures("interpreted")
TYRE = Tyre(e=0.0)
STIFFNESS = 2 / 3 * TYRE.k * TYRE.a**3
LIMIT = 3 / 8 * TYRE.mu * LOAD * TYRE.a
GO = LIMIT / STIFFNESS
"""Total stiffness [N m/rad] and limit [N m], and the turn at which one such stop slips [rad]."""
SHAPES = pytest.mark.parametrize(
    "shape",
    [(1, 1, 2), (1, 0, 2), (0.4, 0.5, 2), (2.5, 0.2, 6), (0.05, 0.02, 3), (1.5, 1.5, 2), (5, -0.5, 15)],
)
Shape = tuple[float, float, float]


def torque(psi: Array, shape: Shape, bristles: int = 80) -> Array:
    """M_z of the model against the turn, positive as the turn."""
    path = constant(psi, TYRE)
    model = Model(effects=effects_named(["stops"]), bristles=bristles)
    early, late, plateau = shape
    values = {"stops__early": early, "stops__late": late, "stops__plateau": plateau}
    return -run(model, path, **values).M_z


def slip_turns(early: float, late: float, plateau: float, count: int = 20_000) -> Array:
    """The turn at which each of many stops of equal stiffness slips, with the total limit."""
    u = ((np.arange(count) + 0.5) / count) ** (1 / 3)
    turns = (1 - u**plateau) ** early * u**-late
    # Their mean is an Euler integral, so that the rare large ones need not be among the many.
    p = (3 - late) / plateau
    mean = 3 / plateau * gamma(p) * gamma(early + 1) / gamma(p + early + 1)
    return np.asarray(GO * turns / mean)


def sum_of_stops(psi: Array, limits: Array) -> Array:
    """Torque of springs of equal stiffness, each behind a slider, added up."""
    stretch, total = np.zeros_like(limits), [0.0]
    for before, now in pairwise(psi):
        stretch = np.minimum(limits, np.maximum(-limits, stretch + (now - before)))
        total.append(STIFFNESS * float(np.mean(stretch)))
    return np.array(total)


def loss_of_cycle(amplitude: float, shape: Shape, bristles: int) -> float:
    """Work of one closed cycle between -amplitude and amplitude [J]."""
    psi = amplitude * straight(0.0, 1.0, -1.0, 1.0, steps=400)
    M = torque(psi, shape, bristles)[400:]
    return float(np.trapezoid(M, psi[400:]))


@SHAPES
def test_bristles_are_many_stops_added_up(shape: Shape) -> None:
    psi = GO * straight(0.0, 1.3, 0.2, 0.9, -2.0, 0.4, -0.6, 3.0, -3.0, steps=25)

    assert worst(torque(psi, shape), sum_of_stops(psi, slip_turns(*shape))) <= 4e-3


def test_the_parabola_is_one_of_them() -> None:
    psi = GO * straight(0.0, 1.3, 0.2, 0.9, -2.0, steps=25)
    declared = run(Model(discretised=True), constant(psi, TYRE))

    np.testing.assert_allclose(torque(psi, (1, 1, 2)), -declared.M_z, rtol=0, atol=1e-9 * LIMIT)


@pytest.mark.parametrize("chi", [-0.5, 0.0, 0.6])
def test_backbone_and_loss_are_segalmans(chi: float) -> None:
    """[Segalman 2005] with beta = 0; the loss of a cycle by Masing's rule, 8 int M - 4 A M(A)."""
    shape, last = (1 / (1 + chi), 0, 3), GO * (chi + 2) / (chi + 1)
    phi = np.linspace(0, 1, 60)
    expected = STIFFNESS * last * (phi - phi ** (chi + 2) / (chi + 2))

    np.testing.assert_allclose(torque(phi * last, shape, 200), expected, rtol=0, atol=1e-3 * LIMIT)
    for A in (0.3, 0.7, 1.0):
        area = A**2 / 2 - A ** (chi + 3) / (chi + 2) / (chi + 3)
        loss = STIFFNESS * last**2 * (8 * area - 4 * A * (A - A ** (chi + 2) / (chi + 2)))
        assert loss_of_cycle(A * last, shape, 200) == pytest.approx(loss, rel=3e-3)


def test_friction_of_full_slide_is_mu_whatever_the_shape() -> None:
    model, theta = Model(effects=effects_named(["stops"])), [TYRE.mu, TYRE.k, 0.3, 0.2, 5.0]
    mu_eff, _ = model.full_slide(np.zeros(model.memory_size), LOAD, theta, [TYRE.a, TYRE.e], 0.1)

    assert float(mu_eff) == pytest.approx(TYRE.mu, rel=3e-3)


@pytest.mark.parametrize(("p", "q"), [(0.55, 1.02), (1.0, 2.0), (1.5, 6.0)])
def test_beta_is_eulers(p: float, q: float) -> None:
    assert float(iwan.beta_function(p, q)) == pytest.approx(
        gamma(p) * gamma(q) / gamma(p + q), rel=1e-10
    )


def test_only_who_asks_for_stops_gets_them() -> None:
    (effect,) = effects_in(iwan)

    assert effects_named(["stops"]) == (effect,)
    assert effects_named(["stops"], [effect]) == (effect,)
    assert KNOWN["stops"] == effect
    assert "stops" not in CANDIDATES
    assert "stops" not in EFFECTS
    with pytest.raises(InvalidInputError, match="unknown effect 'stop'"):
        effects_named(["stop"])
