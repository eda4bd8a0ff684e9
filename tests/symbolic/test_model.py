"""What holds for the declared model as a whole, in either realisation."""

import math
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from symbolic import (
    DECLARED,
    EFFECTS,
    GEOMETRY,
    SIGNALS,
    Effect,
    InvalidInputError,
    Model,
    Parameter,
    effects_named,
    simulate,
)
from symbolic.elements_in_series import series_deflection
from tests.symbolic.oracles import GO, Path, constant, random_path, run, straight

pytestmark = pytest.mark.usefixtures("interpreted")
REALISATIONS = pytest.mark.parametrize(
    "model", [Model(), Model(discretised=True)], ids=["zones", "bristles"]
)


@REALISATIONS
@pytest.mark.parametrize(
    ("angle", "start", "mu", "load", "torque"),
    [(-1, 0, 1, 1, -1), (1, 0.5, 1, 1, 1), (1.37, 0, 1.37, 1, 1.37), (1.37, 0, 1, 1.37, 1.37)],
    ids=["odd", "from anywhere", "homogeneous in friction", "homogeneous in load"],
)
def test_symmetries(
    model: Model, angle: float, start: float, mu: float, load: float, torque: float
) -> None:
    """Factors on angle, friction, load and torque, and another angle of rest [rad]."""
    path = random_path(4)
    tyre = replace(path.tyre, mu=mu * path.tyre.mu)

    M_z = run(model, Path(psi=angle * path.psi + start, F_N=load * path.F_N, tyre=tyre)).M_z

    plain = run(model, path).M_z
    allowed = 1e-11 if start else 1e-12
    np.testing.assert_allclose(M_z, torque * plain, rtol=0, atol=allowed * np.ptp(plain))


@REALISATIONS
def test_step_size_does_not_matter_under_constant_load(model: Model) -> None:
    corners = [0.0, 3.0, -2.0, 1.0, 2.9]
    fine = GO * straight(*corners, steps=64)

    ends = [run(model, constant(psi)).M_z[-1] for psi in (fine, fine[::8], GO * np.array(corners))]

    np.testing.assert_allclose(ends, ends[0], rtol=1e-12)


def test_functions_name_what_they_take_and_give() -> None:
    model = Model(effects=effects_named(["friction_drift", "carcass_torsion"]))

    assert model.step.name_in() == ["memory", "signals", "theta", "geometry"]
    assert model.step.name_out() == ["memory_next", "M_z"]
    assert model.initial.name_in() == ["signals", "theta", "geometry"]
    assert model.initial.name_out() == ["memory"]
    assert (SIGNALS, GEOMETRY) == (("psi", "psi_dot", "F_N", "dt"), ("a", "e"))
    assert [parameter.name for parameter in DECLARED] == ["mu", "k"]
    assert model.coordinate_names == (
        "mu", "k", "friction_drift.gain", "friction_drift.scale", "carcass_torsion.1/k_t"
    )  # fmt: skip
    assert model.step.size1_in("memory") == model.memory_size == model.initial.size1_out("memory")


def test_equal_models_share_their_functions() -> None:
    assert Model(corners=20).step is Model(corners=20).step


def test_theta_puts_values_in_order_and_turns_over_compliances() -> None:
    model = Model(effects=effects_named(["carcass_torsion", "torque_offset"]))
    values = {"torque_offset.M_0": 0.3, "k": 2e6, "carcass_torsion.k_t": 400.0, "mu": 1.2}

    np.testing.assert_array_equal(np.asarray(model.theta(values)).ravel(), [1.2, 2e6, 1 / 400.0, 0.3])
    rigid = model.theta(values | {"carcass_torsion.k_t": math.inf})
    assert float(rigid[2]) == 0.0


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"mu": 1.0}, "parameter 'k' is missing"),
        ({"mu": 1.0, "k": 2e6, "grip": 1.0}, "unknown parameter 'grip'; the model has mu, k"),
        ({"mu": -1.0, "k": 2e6}, r"mu must lie in \[0.01, 10.0\] 1, got -1.0"),
        ({"mu": math.nan, "k": 2e6}, "mu must lie in .* got nan"),
        ({"mu": 1.0, "k": 1e12}, r"k must lie in \[1000.0, 1000000000.0\] N/m\^2"),
    ],
)
def test_theta_refuses(values: dict[str, float], message: str) -> None:
    with pytest.raises(InvalidInputError, match=message):
        Model().theta(values)


def test_parameter_refuses_a_start_outside_its_bounds() -> None:
    with pytest.raises(InvalidInputError, match=r"c: start must lie in \[0.0, 1.0\] 1, got 2.0"):
        Parameter(name="c", unit="1", neutral=0.0, start=2.0, lower=0.0, upper=1.0, scale=1.0)


def test_bristles_are_taken_only_where_needed() -> None:
    assert Model().uses_exact_patch
    assert Model(effects=effects_named(["sensor_delay", "carcass_torsion"])).uses_exact_patch
    assert not Model(discretised=True).uses_exact_patch
    assert not Model(effects=effects_named(["sensor_delay", "patch_width"])).uses_exact_patch


@pytest.mark.parametrize("other", ["friction_drift", "asymmetric_friction", "rate_friction"])
def test_order_of_effects_does_not_matter_to_the_torque(other: str) -> None:
    t = np.arange(400) * 0.01
    psi = 0.2 * np.sin(2 * t)
    rows = np.vstack([psi, 0.4 * np.cos(2 * t), 400 + 20 * np.sin(t), np.full(400, 0.01)])
    values = {"mu": 1.2, "k": 2.4e6, "sensor_delay.delay": 0.033}
    for parameter in EFFECTS[other].parameters:
        values[f"{other}.{parameter.name}"] = parameter.start
    torques = []
    for names in (("sensor_delay", other), (other, "sensor_delay")):
        model = Model(effects=effects_named(names))
        theta = np.asarray(model.theta(values)).ravel()
        torques.append(simulate(model, rows, theta, np.array([0.045, 0.009])).M_z)

    np.testing.assert_allclose(torques[0], torques[1], rtol=0, atol=1e-9)


@pytest.mark.parametrize("rate", [50, 100, 1000, 4000])
def test_delay_is_a_time_at_any_sampling_rate(rate: int) -> None:
    t = np.arange(int(2 * rate)) / rate
    delay, model = 0.06, Model(effects=effects_named(["sensor_delay"]))

    def torque(model: Model, values: dict[str, float], psi: np.ndarray) -> np.ndarray:
        rows = np.vstack([psi, np.gradient(psi, t), np.full(t.size, 400.0), np.full(t.size, 1 / rate)])
        theta = np.asarray(model.theta({"mu": 1.2, "k": 2.4e6} | values)).ravel()
        return simulate(model, rows, theta, np.array([0.045, 0.009])).M_z

    late = torque(model, {"sensor_delay.delay": delay}, 0.2 * (1 - np.cos(3 * t)))
    shifted = torque(Model(), {}, 0.2 * (1 - np.cos(3 * np.maximum(t - delay, 0))))

    assert np.max(np.abs(late - shifted)) < 2e-3 * np.ptp(shifted)


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=EFFECTS)
def test_memory_depends_on_mu_over_k_alone_with_nothing_in_series(effect: Effect) -> None:
    model = Model(effects=(effect,), bristles=8)
    values = {f"{effect.name}.{p.name}": p.start for p in effect.parameters}
    theta, geometry = model.theta({"mu": 1.2, "k": 2.4e6, **values}), ca.DM([0.045, 0.009])
    _, _, at, _ = given = [ca.MX.sym(f"in{i}", *model.step.size_in(i)) for i in range(4)]
    both = ca.vertcat(at[:2], ca.MX(at.numel() - 2, 1))
    by_both = ca.jtimes(ca.vertcat(*model.step(*given)), at, both)
    derivative, rng = ca.Function("derivative", given, [by_both]), np.random.default_rng(1)
    psi = np.cumsum(rng.uniform(-0.06, 0.06, 200))
    memory, off = model.initial([psi[0], 0, 400, 0.01], theta, geometry), 0.0
    for turned, turn in zip(psi[1:], np.diff(psi), strict=True):
        signals = ca.DM([turned, turn / 0.01, rng.uniform(350, 450), 0.01])
        scaled = [ca.vertcat(c * theta[:2], theta[2:]) for c in (1, 2, 3)]
        steps = [model.step(memory, signals, at, geometry) for at in scaled]
        # The torque of the patch is proportional to k; what the effects add to it stays.
        once, twice, thrice = (np.asarray(ca.vertcat(*step)).ravel() for step in steps)
        expected = twice - once
        by_both = np.asarray(derivative(memory, signals, theta, geometry)).ravel()
        off = max(off, *np.abs(expected[:-1]), *np.abs(thrice - twice - expected))
        off = max(off, np.abs(by_both - expected).max())
        memory = steps[0][0]

    assert (off < 1e-11) == (series_deflection(model) is None)
    assert off < 1e-11 or off > 1e-3
