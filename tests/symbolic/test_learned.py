"""The learned torque against plain NumPy, its bounds, its files, and an observer that carries it."""

import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from observers import Ekf, run
from reference_rig import hand_path
from symbolic import (
    EFFECTS,
    InvalidInputError,
    LearnedTorque,
    Model,
    Rig,
    compiled,
    effects_named,
    model_from_tables,
    simulate,
)
from symbolic.effects.learned import INPUTS, WAYS, weights_needed
from symbolic.serialisation import effects_tables
from tests.symbolic.oracles import Array

pytestmark = pytest.mark.usefixtures("interpreted")

RIG = Rig(a=0.045, e=0.009)
GEOMETRY = np.array([RIG.a, RIG.e])
DRIVE = hand_path(3, 6.0, load=480.0, rate=100.0)
SIGNALS = np.vstack([DRIVE.psi, DRIVE.psi_dot, DRIVE.F_N, np.full(DRIVE.psi.size, 0.01)])
MU, K = 1.3, 2.4e6


def learned(seed: int = 1, units: int = 5, size: float = 0.7, **fields: Any) -> LearnedTorque:
    weights = size * np.random.default_rng(seed).standard_normal(weights_needed(units))
    values = {"angle": 0.2, "bound": 0.3, "units": units, "weights": tuple(weights.tolist())} | fields
    return LearnedTorque(**values)


def torque(*effects: Any, signals: Array = SIGNALS, **values: float) -> Array:
    model = Model(effects=effects, corners=6)
    theta = np.asarray(model.theta({"mu": MU, "k": K} | values)).ravel()
    return simulate(model, signals, theta, GEOMETRY).M_z


def in_numpy(effect: LearnedTorque, M_z: Array) -> Array:
    """The learned torque with a loop over the samples, written from its formula."""
    psi, psi_dot, F_N, _ = SIGNALS
    slide = 0.375 * F_N * RIG.a
    table = np.reshape(effect.weights[: effect.units * (INPUTS + 1)], (effect.units, INPUTS + 1))
    output = np.array(effect.weights[effect.units * (INPUTS + 1) :])
    stops, made = np.zeros(len(WAYS)), np.empty(psi.size)
    for i in range(psi.size):
        turn = psi[i] - psi[max(i - 1, 0)]
        stops = np.clip(stops + turn / (effect.angle * np.array(WAYS)), -1, 1)
        rate = psi_dot[i] / 0.01
        plain = [psi[i] / effect.angle, np.tanh(rate), np.arcsinh(rate) / 3, M_z[i] / (MU * slide[i])]
        units = np.tanh(table @ np.array([*plain, *stops, 1.0]))
        made[i] = slide[i] * effect.bound * np.tanh(output @ np.array([*units, 1.0]))
    return made


def test_is_no_candidate_of_the_search() -> None:
    assert "learned" not in EFFECTS
    assert not any(isinstance(effect, LearnedTorque) for effect in EFFECTS.values())


def test_without_weights_it_vanishes() -> None:
    nothing = learned(size=0.0)

    np.testing.assert_array_equal(torque(nothing), torque())


@pytest.mark.parametrize("beside", [(), ("bearing_friction",)], ids=["alone", "beside another"])
def test_is_the_network_written_in_numpy(beside: tuple[str, ...]) -> None:
    values = {"bearing_friction.M_c": 0.7} if beside else {}
    others = effects_named(beside)
    effect = learned()
    alone = torque(*others, **values)
    expected = in_numpy(effect, alone)

    # In whatever place it stands, it comes after all others and sees what they make.
    for effects in ((*others, effect), (effect, *others)):
        np.testing.assert_allclose(torque(*effects, **values) - alone, expected, rtol=0, atol=1e-9)
    assert np.ptp(expected) > 0.1


@pytest.mark.parametrize("size", [1.0, 1e6])
def test_never_runs_away(size: float) -> None:
    far = SIGNALS * np.array([[50.0], [50.0], [1.0], [1.0]])
    added = torque(learned(size=size), signals=far) - torque(signals=far)

    assert np.isfinite(added).all()
    assert np.abs(added / (0.375 * far[2] * RIG.a)).max() <= 0.3 + 1e-9


def test_derivatives_are_the_slopes() -> None:
    model = Model(effects=(learned(),), corners=6)
    theta, close = np.array([MU, K]), np.array([1e-6, 1.0])
    exact = simulate(model, SIGNALS, theta, GEOMETRY, np.eye(2)).sensitivities
    for column in range(2):
        step = np.eye(2)[column] * close
        ends = [simulate(model, SIGNALS, theta + side * step, GEOMETRY).M_z for side in (1, -1)]
        slope = (ends[0] - ends[1]) / (2 * close[column])
        scale = np.abs(slope).max()
        np.testing.assert_allclose(exact[:, column], slope, rtol=0, atol=1e-4 * scale)


def test_compiled_code_says_the_same() -> None:
    model = Model(effects=(learned(),), corners=4)
    built, here = compiled(model.step), model.step
    memory = model.initial(SIGNALS[:, 0], [MU, K], GEOMETRY)
    for signals in SIGNALS.T[:60]:
        memory, M_z = here(memory, signals, [MU, K], GEOMETRY)
        assert float(built(memory, signals, [MU, K], GEOMETRY)[1]) == pytest.approx(
            float(here(memory, signals, [MU, K], GEOMETRY)[1]), abs=1e-12
        )
        assert math.isfinite(float(M_z))


def test_an_observer_carries_it() -> None:
    effect = learned(bound=0.2)
    M_z = torque(effect) + 0.02 * np.random.default_rng(4).standard_normal(DRIVE.psi.size)
    columns = {"t": DRIVE.t, "psi": DRIVE.psi, "F_N": DRIVE.F_N, "M_z": M_z}
    errors = {}
    for name, model in (("with", Model(effects=(effect,), corners=6)), ("without", Model(corners=6))):
        estimates = run(Ekf(model=model, values={"k": K}, rig=RIG), **columns)
        assert np.isfinite(estimates.mu).all()
        errors[name] = float(np.abs(estimates.mu[300:] - MU).mean())
    assert errors["with"] < 0.02
    assert errors["without"] > 3 * errors["with"]


def document(effect: LearnedTorque, **changes: Any) -> dict[str, Any]:
    model = Model(effects=(*effects_named(["torque_offset"]), effect))
    content = {"version": 1, **effects_tables(model), "shared": {"k": K}}
    return content | {"learned": content["learned"] | changes}


def test_round_trip_through_a_file_is_exact() -> None:
    effect = learned(size=1 / 3)
    found = model_from_tables(json.loads(json.dumps(document(effect), allow_nan=False)))

    assert [e.name for e in found.model.effects] == ["torque_offset", "learned"]
    assert found.model.effects[-1] == effect


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"weights": [1.0]}, "learned.weights must hold 46 numbers for 5 units, got 1"),
        ({"weights": "many"}, "learned.weights must be a list of numbers"),
        ({"weights": [True] * 46}, "learned.weights.0 must be a number, got True"),
        ({"weights": [math.nan] * 46}, "learned.weights must be finite numbers"),
        ({"units": 0}, "learned.weights must hold 1 numbers for 0 units"),
        ({"units": 5.0}, "learned.units must be a whole number, got '5.0'"),
        ({"angle": 0}, "learned.angle must be a finite number greater than 0, got 0.0"),
        ({"bound": math.inf}, "learned.bound must be a finite number greater than 0, got inf"),
        ({"bound": "1"}, "learned.bound must be a number, got '1'"),
        ({"ways": [1]}, "'learned' must be a table of angle, bound, units, weights"),
    ],
)
def test_faults_of_a_table(changes: dict[str, Any], fault: str) -> None:
    with pytest.raises(InvalidInputError) as caught:
        model_from_tables(document(learned(), **changes))
    assert str(caught.value).startswith(fault)


def test_faults_of_the_place() -> None:
    content = document(learned())
    without = {key: value for key, value in content.items() if key != "learned"}
    for wrong, fault in [
        (without, "'learned' must be a table of"),
        (content | {"effects": ["torque_offset"]}, "'learned' is there, but is not the last of"),
        (content | {"effects": ["learned", "torque_offset"]}, "'learned' is there, but is not the last"),
        (without | {"effects": ["learned", "torque_offset"]}, "unknown effect 'learned'"),
    ]:
        with pytest.raises(InvalidInputError) as caught:
            model_from_tables(wrong)
        assert str(caught.value).startswith(fault)


def test_is_a_value() -> None:
    assert learned() == learned()
    assert hash(learned()) == hash(learned())
    assert replace(learned(), bound=0.1) != learned()
