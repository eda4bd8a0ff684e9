"""Effective friction: against long steady turns of the model itself and of the reference rig."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import quad

from reference_rig import RigTyre, build_effects, free_path, simulate_bristles
from symbolic import EFFECTS, Effect, Expression, Model, Parameter, Signals, Values, simulate
from symbolic.patch_moment_by_zones import full_slide_arm, full_slide_torque
from tests.symbolic.oracles import Array, flat, theta_of
from tests.symbolic.test_effects import EACH, VALUES

pytestmark = pytest.mark.usefixtures("interpreted")

TYRE = RigTyre()
GEOMETRY = np.array([TYRE.a, TYRE.e])
F_N, RATE, TURN, STEP = 480.0, 0.1, 4.0, 0.2
T = np.arange(0.0, TURN / RATE + STEP, STEP)
"""A turn in which all bristles but those within half a millimetre of the kingpin slide."""
Planted = Mapping[str, Mapping[str, float]]
BEARING = 0.7
EVERYTHING: Planted = {
    "rate_friction": {"c": 0.04}, "friction_drift": {"gain": 0.3, "scale": 0.6},
    "asymmetric_friction": {"ratio": 1.2}, "patch_width": {"half_width": 0.03},
    "contact_damping": {"c": 2.0}, "torque_offset": {"M_0": 0.8}, "steering_return": {"stiffness": 3.0},
    "load_dependent_friction": {"n": 0.4}, "carcass_torsion": {"k_t": 150.0},
}  # fmt: skip


def declared_arm(e: float) -> float:
    """Torque of the declared patch in full slide over load, mu = 1 [m], by quadrature."""

    def moment(x: float) -> float:
        return 0.75 / TYRE.a**3 * (TYRE.a**2 - x**2) * abs(x - e)

    return float(quad(moment, -TYRE.a, e)[0] + quad(moment, e, TYRE.a)[0])


def turned_to_the_same_angle(torque: Callable[[Array], Array]) -> float:
    """Half the difference of the torques at the ends of a turn forth and a turn back [N m]."""
    forth = np.minimum(RATE * T, TURN)
    return 0.5 * float(torque(2 * TURN - forth)[-1] - torque(forth)[-1])


def signals(psi: Array) -> Array:
    return np.vstack([psi, np.gradient(psi, T), np.full(T.size, F_N), np.full(T.size, STEP)])


def model_of(planted: Planted) -> Model:
    return Model(effects=tuple(EFFECTS[name] for name in planted))


@pytest.mark.parametrize("ratio", [0.85, 1.2])
def test_the_weaker_direction_is_as_far_below_the_mean_as_the_glossary_says(ratio: float) -> None:
    planted: Planted = {"asymmetric_friction": {"ratio": ratio}}
    tyre, effects = TYRE, build_effects(planted)
    weaker = min(
        abs(float(simulate_bristles(free_path(T, psi, load=F_N, rate=1 / STEP), tyre, effects).M_z[-1]))
        for psi in (np.minimum(RATE * T, TURN), -np.minimum(RATE * T, TURN))
    )
    _, M_slide = full_slide(planted)

    assert weaker == pytest.approx(M_slide * (1 - abs(1 - ratio) / (1 + ratio)), rel=2e-3)


def memory_after(model: Model, theta: Array, columns: Array) -> ca.DM:
    memory = model.initial(columns[:, 0], theta, GEOMETRY)
    for column in columns.T:
        memory, _ = model.advance(memory, column, theta, GEOMETRY)
    return memory


def full_slide(planted: Planted, mu: float = TYRE.mu) -> tuple[float, float]:
    """mu_eff and M_slide after the turn, so that what effects count up is the same."""
    model = model_of(planted)
    at = theta_of(model, flat(planted), RigTyre(mu=mu))
    turned = signals(np.minimum(RATE * T, TURN))
    # Two samples do for what has no memory of its own.
    turned = turned if any(effect.memory for effect in model.effects) else turned[:, :2]
    mu_eff, M_slide = model.full_slide(memory_after(model, at, turned), F_N, at, GEOMETRY, RATE)
    return float(mu_eff), float(M_slide)


def on_the_rig(planted: Planted, mu: float = TYRE.mu) -> float:
    tyre, effects = RigTyre(mu=mu), build_effects(planted)

    def torque(psi: Array) -> Array:
        return simulate_bristles(free_path(T, psi, load=F_N, rate=1 / STEP), tyre, effects).M_z

    return turned_to_the_same_angle(torque)


@pytest.mark.parametrize("e", [0.0, 0.009, -0.02, 0.044])
def test_the_declared_model_has_its_mu(e: float) -> None:
    model = Model()
    memory = np.zeros(model.memory_size)
    mu_eff, M_slide = model.full_slide(memory, F_N, [1.3, TYRE.k], [TYRE.a, e], RATE)

    assert float(mu_eff) == 1.3
    assert float(M_slide) == pytest.approx(1.3 * F_N * declared_arm(e), rel=1e-12)
    assert full_slide_arm(TYRE.a, 0.0) == pytest.approx(full_slide_torque(1.0, TYRE.a), rel=1e-14)


@EACH
def test_a_steady_turn_has_this_torque(effect: Effect) -> None:
    """Of the model itself, and of the rig; what the bearing takes is not the ground's."""
    planted = {effect.name: VALUES[effect.name]}
    model = model_of(planted)
    at = theta_of(model, flat(planted), TYRE)
    of_bearing = BEARING if effect.name == "bearing_friction" else 0.0

    mu_eff, M_slide = full_slide(planted)

    own = turned_to_the_same_angle(lambda psi: simulate(model, signals(psi), at, GEOMETRY).M_z)
    turned = on_the_rig(planted) - of_bearing
    assert M_slide == pytest.approx(own - of_bearing, rel=1e-3)
    assert M_slide == pytest.approx(turned, rel=1.5e-3)
    assert mu_eff == pytest.approx(turned / (F_N * declared_arm(TYRE.e)), rel=1.5e-3)


def test_many_effects_at_once_on_the_rig() -> None:
    mu_eff, M_slide = full_slide(EVERYTHING)

    turned = on_the_rig(EVERYTHING)
    assert M_slide == pytest.approx(turned, rel=2e-3)
    assert mu_eff > 1.2 * TYRE.mu


def test_drift_counts_as_far_as_it_has_come() -> None:
    planted: Planted = {"friction_drift": {"gain": 0.3, "scale": 0.6}}
    model = model_of(planted)
    at = theta_of(model, flat(planted), TYRE)
    for travel in (0.0, 0.5, 30.0):
        turned = signals(travel / TURN * np.minimum(RATE * T, TURN))
        mu_eff, _ = model.full_slide(memory_after(model, at, turned), F_N, at, GEOMETRY, RATE)
        assert float(mu_eff) == pytest.approx(TYRE.mu * (1 + 0.3 * (1 - np.exp(-travel / 0.6))))


def test_it_follows_the_rate_at_which_friction_is_asked_for() -> None:
    planted: Planted = {"contact_damping": {"c": 2.0}}
    model = model_of(planted)
    memory, at = np.zeros(model.memory_size), theta_of(model, flat(planted), TYRE)
    slow, fast = (float(model.full_slide(memory, F_N, at, GEOMETRY, rate)[1]) for rate in (0.1, 0.3))

    assert fast - slow == pytest.approx(2.0 * 0.2, rel=1e-9)


@dataclass(frozen=True, kw_only=True)
class Lopsided(Effect):
    """A torque of the ground with a part that does not depend on the direction."""

    name: str = "lopsided"
    summary: str = "pulls to one side"
    parameters: tuple[Parameter, ...] = ()
    torque_by_ground: bool = True

    def torque(self, signals: Signals, values: Values) -> Expression:
        del values
        return 0.9 - 2.0 * signals.psi_dot


def test_what_pulls_to_one_side_cancels() -> None:
    plain, pulled = (
        model.full_slide(np.zeros(model.memory_size), F_N, [TYRE.mu, TYRE.k], GEOMETRY, RATE)[1]
        for model in (Model(), Model(effects=(Lopsided(),)))
    )
    assert float(pulled) == pytest.approx(float(plain) + 2.0 * RATE, rel=1e-12)
