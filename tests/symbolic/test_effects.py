"""Every effect: declared sanely, gone at its neutral value, the same as on the reference rig."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from reference_rig import Hand, RigTyre, build_effects, hand_path
from reference_rig import simulate_bristles as on_the_rig
from symbolic import (
    EFFECTS,
    BristleTraits,
    Effect,
    InvalidInputError,
    Model,
    Parameter,
    Signals,
    TorqueAndSensitivities,
    Values,
    simulate,
)
from symbolic.bristle_patch import BristlePatch
from tests.symbolic.oracles import Array, flat, theta_of, worst

pytestmark = pytest.mark.usefixtures("interpreted")

TYRE = RigTyre()
DRIVE = hand_path(3, 10.0, hand=Hand(nesting=0.6), load=480.0, rate=100.0)
GEOMETRY = np.array([TYRE.a, TYRE.e])
VALUES: dict[str, dict[str, float]] = {
    "rate_friction": {"c": 0.04},
    "speed_law": {"slow": 0.06, "middle": 0.03, "fast": -0.02},
    "frictional_creep": {"c": 0.06},
    "stribeck": {"ratio": 1.3, "v_s": 3e-3},
    "load_dependent_friction": {"n": 0.4},
    "asymmetric_friction": {"ratio": 1.2},
    "friction_drift": {"gain": 0.3, "scale": 0.6},
    "carcass_torsion": {"k_t": 150.0},
    "contact_length": {"n": 0.4, "F_0": 450.0, "m": 2.4},
    "patch_width": {"half_width": 0.03},
    "pressure_shape": {"exponent": 4.0},
    "pressure_skew": {"skew": 0.4},
    "viscoelastic_relaxation": {"gain": 0.5, "time": 0.6},
    "contact_damping": {"c": 2.0},
    "bearing_friction": {"M_c": 0.7},
    "steering_return": {"stiffness": 3.0},
    "sensor_delay": {"delay": 0.023},
    "torque_offset": {"M_0": 0.8},
    "pretwist": {"psi_0": -0.06},
    "tared_pretwist": {"psi_0": 0.04, "M_0": 0.9},
    "zero_drift": {"rate": -0.05},
    "backlash": {"gap": 0.02},
}
EACH = pytest.mark.parametrize("effect", EFFECTS.values(), ids=EFFECTS)
UNITS = {"1", "m", "N", "s", "rad"}


def model_torque(planted: Mapping[str, Mapping[str, float]], **realisation: Any) -> Array:
    """M_z of the model over DRIVE, effects in the order of their names as given."""
    return torque_of(Model(effects=tuple(EFFECTS[name] for name in planted), **realisation), planted)


def torque_of(model: Model, planted: Mapping[str, Mapping[str, float]]) -> Array:
    return simulated(model, planted, samples()).M_z


def samples() -> Array:
    dt = np.diff(DRIVE.t, prepend=DRIVE.t[0] - 0.01)
    return np.vstack([DRIVE.psi, DRIVE.psi_dot, DRIVE.F_N, dt])


def simulated(
    model: Model, planted: Mapping[str, Mapping[str, float]], signals: Array
) -> TorqueAndSensitivities:
    theta = theta_of(model, flat(planted), TYRE)
    # Derivatives are made where nobody looks at them, too: these Functions are the ones that fits run.
    return simulate(model, signals, theta, GEOMETRY, np.eye(len(theta)))


@dataclass(frozen=True, kw_only=True)
class Room(Effect):
    """Room for a patch that does not grow."""

    name: str = "room"
    summary: str = "nothing"
    parameters: tuple[Parameter, ...] = ()

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """Bristles beyond the patch."""
        del values
        return replace(traits, growth=lambda *_: 1)


def declared_torque(effect: Effect) -> Array:
    """The declared model on the bristles that the effect asks for: as many columns, as far apart."""
    patch = Model(effects=(effect,)).patch()
    if not isinstance(patch, BristlePatch):
        return model_torque({})
    wide = patch.traits.half_width is not None
    columns = patch.bristle_count // (patch.rows if wide else 1)
    added = (Room(),) if patch.traits.growth else ()
    return torque_of(Model(effects=added, discretised=True, bristles=columns), {})


def rig_torque(planted: Mapping[str, Mapping[str, float]]) -> Array:
    return on_the_rig(DRIVE, TYRE, build_effects(planted)).M_z


def neutral(effect: Effect) -> dict[str, float]:
    return {p.name: p.start if p.neutral is None else p.neutral for p in effect.parameters}


def test_the_table_of_values_covers_the_vocabulary() -> None:
    assert sorted(VALUES) == sorted(EFFECTS)
    for name, values in VALUES.items():
        assert list(values) == [p.name for p in EFFECTS[name].parameters]


@EACH
def test_parameters_are_declared_sanely(effect: Effect) -> None:
    assert EFFECTS[effect.name] is effect
    assert effect.summary
    assert any(p.neutral is not None for p in effect.parameters), "nothing switches it off"
    for p in effect.parameters:
        assert {*re.split(r"[ /]", re.sub(r"\^\d", "", p.unit))} <= UNITS
        assert p.lower < p.start < p.upper
        assert 0 < p.scale < math.inf
        own = dict.fromkeys(("torque_offset", "pretwist", "zero_drift"), "recording")
        shared = "ground" if (effect.name, p.name) == ("friction_drift", "gain") else "tyre"
        assert p.scope == own.get(effect.name, shared)
        if p.neutral is not None:
            assert p.lower <= p.neutral <= p.upper
            assert p.start != p.neutral, "a fit that starts neutral sees no derivative"
        assert p.to_coordinate(p.to_coordinate(p.start)) == pytest.approx(p.start)
        assert math.isfinite(p.to_coordinate(p.start))
        assert p.coordinate_name == (f"1/{p.name}" if p.inverse else p.name)


@EACH
def test_effect_vanishes_at_its_neutral_value(effect: Effect) -> None:
    declared = declared_torque(effect)

    M_z = model_torque({effect.name: neutral(effect)})

    np.testing.assert_allclose(M_z, declared, rtol=0, atol=1e-12)


@EACH
def test_effect_is_the_one_of_the_rig(effect: Effect) -> None:
    planted = {effect.name: VALUES[effect.name]}
    reference, declared = rig_torque(planted), rig_torque({})

    error = worst(model_torque(planted), reference)

    seen = worst(reference, declared)
    # The exact patch meets the rig to the rig's own grid. Between samples the rig interpolates the late
    # torque, the effect the angle that makes it. The rig's flanks are hard, those of the effect rounded.
    apart = {"sensor_delay": 1e-3, "backlash": 5e-3}
    assert error <= (3e-3 if effect.needs_bristles else apart.get(effect.name, 1e-5))
    assert seen > 10 * error, "the path shows what the effect does"


@EACH
def test_weak_effect_is_in_proportion_to_the_rigs(effect: Effect) -> None:
    """A sign or a factor that a strong effect might hide: the first order, on both sides of neutral."""
    start, off = neutral(effect), VALUES[effect.name]
    name = next(p.name for p in effect.parameters if p.neutral is not None)
    if effect.parameters[0].inverse:
        weak = start | {name: 20 * off[name]}
    else:
        weak = off | {name: start[name] + 0.2 * (off[name] - start[name])}
    planted = {effect.name: weak}

    ours = model_torque(planted) - declared_torque(effect)
    theirs = rig_torque(planted) - rig_torque({})

    share = float(ours @ theirs / (theirs @ theirs))
    assert share == pytest.approx(1.0, abs=0.03)
    assert np.linalg.norm(ours - theirs) <= 0.15 * np.linalg.norm(theirs)


@EACH
def test_sample_that_takes_no_time_changes_nothing(effect: Effect) -> None:
    """Recordings and observers refuse it; whoever calls `simulate` may ask for it."""
    planted = {effect.name: VALUES[effect.name]}
    model, once = Model(effects=(effect,)), samples()[:, :300]
    twice = np.insert(once, 150, once[:, 149], axis=1)
    twice[3, 150] = 0.0

    made, expected = (simulated(model, planted, signals) for signals in (twice, once))

    span = np.ptp(expected.M_z)
    np.testing.assert_allclose(np.delete(made.M_z, 150), expected.M_z, rtol=0, atol=1e-6 * span)
    assert np.isfinite(made.M_z).all()
    assert np.isfinite(made.sensitivities).all()


@pytest.mark.parametrize(
    ("names", "allowed"),
    [
        (("carcass_torsion", "friction_drift", "torque_offset", "pretwist"), 1e-5),
        (("carcass_torsion", "rate_friction", "pressure_skew"), 3e-3),
        pytest.param(
            ("stribeck", "pressure_shape", "asymmetric_friction", "steering_return"),
            3e-3,
            marks=pytest.mark.long,
        ),
        (("patch_width", "viscoelastic_relaxation", "bearing_friction"), 3e-3),
        (("viscoelastic_relaxation", "frictional_creep"), 3e-3),
        (("frictional_creep", "friction_drift", "zero_drift"), 3e-3),
        pytest.param(("carcass_torsion", "frictional_creep", "pretwist"), 3e-3, marks=pytest.mark.long),
        pytest.param(("patch_width", "frictional_creep", "rate_friction"), 3e-3, marks=pytest.mark.long),
        pytest.param(
            ("contact_length", "frictional_creep", "carcass_torsion", "pressure_skew"),
            3e-3,
            marks=pytest.mark.long,
        ),
        (("contact_length", "pressure_shape", "patch_width"), 3e-3),
        (("carcass_torsion", "backlash", "rate_friction"), 5e-3),
    ],
)
def test_effects_act_together(names: tuple[str, ...], allowed: float) -> None:
    planted = {name: VALUES[name] for name in names}

    assert worst(model_torque(planted), rig_torque(planted)) <= allowed


def test_a_zero_drifts_with_time_from_the_first_sample_on() -> None:
    """Whatever the first period is, and over a gap."""
    once = samples()[:, :300]
    once[3, [0, 150]] = 3.0, 7.0
    elapsed = np.cumsum(once[3]) - 3.0

    drifting, still = (
        simulated(Model(effects=(EFFECTS["zero_drift"],)), {"zero_drift": {"rate": rate}}, once).M_z
        for rate in (-0.2, 0.0)
    )

    np.testing.assert_allclose(drifting - still, -0.2 * elapsed, rtol=0, atol=1e-12)


def test_effect_that_remembers_must_say_what() -> None:
    forgetful = Effect(name="forgetful", summary="has memory", parameters=(), memory=1)

    with pytest.raises(NotImplementedError, match="forgetful has memory but no initial value"):
        forgetful.initial(Signals(psi=0.0, psi_dot=0.0, F_N=400.0, dt=0.01))


@pytest.mark.parametrize(("name", "unit"), [
    ("a b", "1"), ("", "1"), ("\udcff", "1"), ("%s", "1"), ("c", "two\nlines"), ("c", 'N "m"'),
    ("c", "<b>"), ("c", "a&b"), ("c", "*/"), ("c", "/*"), ("c", "\\"), ("c", "\x1b[2J"), ("c", "\u2028"),
])  # fmt: skip
def test_names_and_units_that_files_cannot_quote_are_refused(name: str, unit: str) -> None:
    with pytest.raises(InvalidInputError, match=r"identifier|plain signs"):
        Parameter(name=name, unit=unit, neutral=0.0, start=1.0, lower=0.0, upper=2.0, scale=1.0)


@pytest.mark.parametrize("unit", ["N m/rad", "N·m/°", "µm", "%", "m^2", "1", ""])
def test_other_units_stand(unit: str) -> None:
    settings = {"neutral": 0.0, "start": 1.0, "lower": 0.0, "upper": 2.0, "scale": 1.0}

    assert Parameter(name="c", unit=unit, **settings).unit == unit
