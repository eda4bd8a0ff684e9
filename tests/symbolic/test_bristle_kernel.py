"""Loops over bristles against CasADi's own recursion, which is checked against grids of bristles."""

from dataclasses import dataclass

import casadi as ca
import numpy as np
import pytest

from symbolic import Effect, Model, Parameter, compiler, parameter_name, simulate, trajectory_sensitivity
from symbolic.compilation.bristle_kernel import bristle_kernel
from symbolic.effects.library import GROUND_SCOPES, KNOWN
from tests.symbolic.oracles import Array, random_path, signals
from tests.symbolic.warmth import Warmth

needs_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler at hand")
GEOMETRY = np.array([0.045, 0.009])
LONG = pytest.mark.long
TOGETHER = [
    ("frictional_creep", "carcass_torsion", "asymmetric_friction"),
    ("sensor_delay", "viscoelastic_relaxation", "backlash", "torque_offset"),
    ("contact_length", "patch_width", "rate_friction", "friction_drift"),
    ("warmth", "stribeck"),
]
ALONE = [pytest.param((name,), marks=LONG) for name in KNOWN if name not in GROUND_SCOPES]


def model_of(*names: str) -> Model:
    """A few bristles, also where the exact patch would do."""
    effects = tuple((KNOWN | {"warmth": Warmth()})[name] for name in names)
    return Model(effects=effects, bristles=10, discretised=True)


def theta_of(model: Model) -> Array:
    values = {parameter_name(e, p): p.start or 0.3 for e, p in model.parameters if e is not None}
    return np.asarray(model.theta({"mu": 1.1, "k": 3e6, **values})).ravel()


def recording() -> Array:
    """A path that turns back and rests, under a load that wanders."""
    path = random_path(3, samples=130)
    psi = path.psi.copy()
    psi[60:75] = psi[60]
    return signals(psi, path.F_N)


def both(
    monkeypatch: pytest.MonkeyPatch, model: Model, directions: Array | None
) -> list[tuple[Array, Array]]:
    """Torque and derivatives by the loops, and by CasADi without them."""
    results = []
    for kernel in (bristle_kernel, lambda _: None):
        with monkeypatch.context() as patch:
            patch.setattr(trajectory_sensitivity, "bristle_kernel", kernel)
            patch.setattr(trajectory_sensitivity, "compiled", lambda function, **_: function)
            run = simulate(model, recording(), theta_of(model), GEOMETRY, directions)
        results.append((run.M_z, run.sensitivities))
        trajectory_sensitivity._compiled_sample_block.cache_clear()
    return results


@needs_compiler
@pytest.mark.parametrize("names", [*TOGETHER, *ALONE])
def test_torque_and_derivatives_are_those_of_casadi(
    names: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    model = model_of(*names)
    loops, casadi = both(monkeypatch, model, np.eye(len(model.parameters) + 3))

    assert bristle_kernel(model) is not None
    np.testing.assert_allclose(loops[0], casadi[0], rtol=1e-9, atol=1e-10)
    size = np.abs(casadi[1]).max(axis=0)
    # A step of Newton from a sliding speed in single precision has a slope as wrong as that.
    near = 1e-6 if model.patch().traits.creep is not None else 1e-9
    np.testing.assert_allclose(loops[1], casadi[1], rtol=1e-6, atol=near * (1 + size.max()))
    assert size[:2].min() > 0


@needs_compiler
def test_any_number_of_directions_takes_one_library(monkeypatch: pytest.MonkeyPatch) -> None:
    model = model_of("rate_friction")
    (_, every), _ = both(monkeypatch, model, np.eye(3))
    (torque, mixed), _ = both(monkeypatch, model, np.array([[1.0], [2e5], [0.0]]))
    (alone, none), _ = both(monkeypatch, model, None)

    np.testing.assert_allclose(mixed[:, 0], every @ [1.0, 2e5, 0.0], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(torque, alone)
    assert none.shape == (torque.size, 0)


@dataclass(frozen=True, kw_only=True)
class Tabulated(Effect):
    """A torque out of a table, which has no form in scalars."""

    name: str = "tabulated"
    summary: str = "a torque out of a table"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="c", unit="N m", neutral=0.0, start=0.1, lower=-1.0, upper=1.0, scale=0.1),
    )

    def torque(self, signals, values):  # type: ignore[no-untyped-def]
        table = ca.interpolant("table", "linear", [[-1.0, 0.0, 1.0]], [1.0, 0.0, 1.0])
        return values["c"] * table(signals.psi)


def test_an_effect_without_scalars_is_casadis(monkeypatch: pytest.MonkeyPatch) -> None:
    model = Model(effects=(Tabulated(),), bristles=10, discretised=True)
    loops, casadi = both(monkeypatch, model, np.eye(3))

    assert bristle_kernel(model) is None
    np.testing.assert_array_equal(loops[0], casadi[0])
    assert np.abs(loops[1][:, 2]).max() > 0


def test_the_exact_patch_is_casadis() -> None:
    assert bristle_kernel(Model()) is None
