"""Friction is acquired on the declared patch: what effects add to its torque, and a compliance."""

from dataclasses import replace
from typing import Any

import casadi as ca
import numpy as np
import pytest

from observers import PROFILES, Ekf, Estimates, Status, SteeringTorque, causal_rate, run
from observers.planning.steering_limits_and_paths import fastest_path
from observers.quality.equivalent_patch import REST, build_equivalent_contact, build_patch_angle
from observers.quality.hysteresis_branches import loads_of_branches
from reference_rig import (
    RIG_EFFECTS,
    Hand,
    RigTyre,
    constant_friction,
    free_path,
    make_recording,
    make_steering_recording,
    simulate_bristles,
)
from symbolic import Rig
from symbolic.full_slide_friction import build_full_slide
from symbolic.patch_moment_by_zones import full_slide_arm
from tests.observers.conftest import RIG, K
from tests.observers.factories import found_model

ADDED = {
    "steering_return": ("stiffness", lambda psi, _, stiffness: -stiffness * psi),
    "contact_damping": ("c", lambda _, psi_dot, c: -c * psi_dot),
    "bearing_friction": ("M_c", lambda _, psi_dot, M_c: -M_c * np.tanh(psi_dot / 0.01)),
}
"""Parameter of an effect, and its torque [N m]."""


def estimates_of(
    made: Any, torque: Any, name: str = "", value: float = 0.0, **settings: Any
) -> Estimates:
    """Estimates of a filter that knows rate friction, of nearly no strength, and a further effect."""
    added = {f"{name}.{ADDED[name][0]}": value} if name else {}
    observer = Ekf(**found_model({"rate_friction.c": 1e-6, **added}, bristles=40), rig=RIG, **settings)
    return run(observer, made.t, made.psi, made.F_N, **{observer.channel: torque})


@pytest.mark.long
@pytest.mark.parametrize("mu", [0.05, 0.8])
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("steering_return", 6.0),
        ("steering_return", -10.0),
        ("bearing_friction", 0.5),
        ("contact_damping", 1.0),
    ],
)
def test_a_torque_that_the_model_knows_changes_nothing(mu: float, name: str, value: float) -> None:
    made = make_recording(21, mu=mu, k=K, bristles=500, duration=8.0)
    without = estimates_of(made, made.M_z)
    added = ADDED[name][1](made.psi, causal_rate(made.t, made.psi), value)
    estimates = estimates_of(made, made.M_z + added, name, value)

    both = estimates.usable & without.usable
    assert without.usable.mean() > 0.3
    # The noise that a torque shows is taken before.
    assert np.mean(estimates.status == without.status) > 0.98
    np.testing.assert_allclose(estimates.mu[both], without.mu[both], rtol=5e-3)
    np.testing.assert_allclose(estimates.mu_std[both], without.mu_std[both], rtol=0.05)
    predicted = without.M_z_predicted + added
    np.testing.assert_allclose(estimates.M_z_predicted[both], predicted[both], atol=0.02)


def test_one_step_serves_all_rigs_and_values() -> None:
    softer, stiffer = (
        Ekf(**found_model({"carcass_torsion.k_t": k_t}, bristles=40), rig=rig)
        for k_t, rig in ((200.0, RIG), (2000.0, replace(RIG, a=1.1 * RIG.a)))
    )

    assert softer.screened_step is stiffer.screened_step
    # The softer carcass looks like a softer patch.
    assert softer.equivalent_patch.stiffness < stiffer.equivalent_patch.stiffness < 1.02
    for observer in (softer, stiffer):
        patch = observer.equivalent_patch
        assert observer.constants[-2:].tolist() == [patch.stiffness, patch.friction]
        assert observer.constant_labels[-2:] == (
            "equivalent patch: stiffness [1]", "equivalent patch: friction [1]",
        )  # fmt: skip


@pytest.mark.long
def test_a_spring_beside_the_steering_torque_is_no_friction() -> None:
    drive = {"tyre": RigTyre(k=K, mu=0.1), "duration": 6.0, "rate": 200.0}
    made = make_steering_recording(5, constant_friction(0.1), **drive)
    measured = {"measurement_model": SteeringTorque()}
    without = estimates_of(made, made.M, **measured)
    estimates = estimates_of(made, made.M - 8.0 * made.psi, "steering_return", -8.0, **measured)

    assert estimates.usable.mean() > 0.9 * without.usable.mean() > 0
    off = np.abs(estimates.mu - 0.1)[estimates.usable]
    assert (off < 3 * estimates.mu_std[estimates.usable]).all()


PERIOD, LOAD = 0.01, 450.0


def deviations(mu: float, rate: float, turns: tuple[float, float], **tuning: float) -> np.ndarray:
    """Usable deviations of mu over their standard deviation, on growing turns from rest."""
    rng = np.random.default_rng(0)
    sizes = np.append(np.geomspace(*turns, 4), np.full(40, turns[1]))
    points = [0.0, *(size * (-1) ** i for i, size in enumerate(sizes))]
    path = fastest_path(points, rate, rate / 0.2, PERIOD, 8.0, rest=0.5)
    t = PERIOD * np.arange(path.psi.size)
    tyre = RigTyre(a=0.05, e=0.011, k=2.21e6, mu=mu)
    planted = [RIG_EFFECTS["rate_friction"](c=0.05), RIG_EFFECTS["carcass_torsion"](k_t=264.0)]
    drive = free_path(t, path.psi, load=LOAD, rate=1 / PERIOD)
    truth = simulate_bristles(drive, tyre, planted, bristles=800)
    found = found_model({"carcass_torsion.k_t": 264.0, "rate_friction.c": 0.05}, k=2.21e6)
    rig, tuning = Rig(a=0.05, e=0.011, J_A=0.05, b_t=0.1), replace(PROFILES["real_tyre"], **tuning)
    observer = Ekf(**found, rig=rig, tuning=tuning)
    M_z = truth.M_z + 0.04 * rng.standard_normal(t.size)
    found = run(observer, t, path.psi, np.full(t.size, LOAD), M_z)
    return np.abs(found.mu - mu)[found.usable] / found.mu_std[found.usable]


def test_small_turns_are_not_usable_and_wrong():
    # The memory of a mu that was not yet known once passed for torque: 10 deviations.
    sharp = {"error": 0.0036, "noise": 0.0078, "stiffness_std": 0.23, "error_travel": 0.03}
    assert (deviations(0.47, 0.35, (0.05, 0.05), **sharp, mu_walk=0.0012, mu_floor=0.004) < 3).all()


@pytest.mark.parametrize("mu", [0.1, 0.45, 0.8])
def test_turns_that_slide_the_whole_patch_are_usable_and_right(mu):
    usable = deviations(mu, 0.2, (0.05, 0.2), error=0.008)
    assert usable.size > 100
    assert (usable < 3).all()


@pytest.mark.parametrize("mu", [0.1, 0.8])
def test_a_gap_that_the_model_knows_does_not_keep_friction_from_being_known(mu: float) -> None:
    """The torque tells its flanks apart; taken for a part of the patch, a gap is never explained."""
    for seed in (31, 32):
        drive = {"mu": mu, "k": K, "load": 400.0, "bristles": 300, "duration": 12.0}
        made = make_recording(seed, {"backlash": {"gap": 0.02}}, **drive)
        observer = Ekf(**found_model({"backlash.gap": 0.02}, bristles=40), rig=RIG)
        found = run(observer, made.t, made.psi, made.F_N, made.M_z)
        late = found.usable & (made.t > 8)

        assert late.sum() > 0.9 * np.count_nonzero(made.t > 8)
        assert found.mu_eff[late] == pytest.approx(mu, rel=0.05)
        assert np.mean(found.status & (Status.INCONSISTENT | Status.SUSPECT) != 0) < 0.1


@pytest.mark.parametrize(
    ("effect", "values", "load"),
    [
        ("rate_friction", {"c": 0.11}, 420.0),
        pytest.param("rate_friction", {"c": -0.08}, 420.0, marks=pytest.mark.long),
        ("contact_length", {"n": 0.6, "F_0": 400.0, "m": 2.0}, 250.0),
        pytest.param(
            "contact_length", {"n": 0.6, "F_0": 400.0, "m": 2.0}, 600.0, marks=pytest.mark.long
        ),
    ],
)
def test_friction_and_length_that_rate_and_load_change_are_acquired(
    effect: str, values: dict[str, float], load: float
) -> None:
    """Taken for a stiffer or softer patch they kept friction from being known, or passed for a unit."""
    drive: dict[str, Any] = {"mu": 0.7, "k": K, "load": load, "bristles": 300, "duration": 12.0}
    made = make_recording(41, {effect: values}, **drive)
    known = {f"{effect}.{name}": value for name, value in values.items()}
    observer = Ekf(**found_model(known, bristles=40), rig=RIG)
    found = run(observer, made.t, made.psi, made.F_N, made.M_z)
    late = found.usable & (made.t > 6)

    assert late.sum() > 0.9 * np.count_nonzero(made.t > 6)
    assert found.mu[late] == pytest.approx(0.7, rel=0.05)
    assert np.mean(found.status & (Status.INCONSISTENT | Status.SUSPECT) != 0) < 0.05


def test_each_branch_carries_the_load_at_which_it_began_and_ended() -> None:
    """From a limit of 60 at rest to one of 100 now the way is that of 80 twice."""
    track = {"count": 3, "count_slid": 1}
    loads = np.asarray(ca.DM(loads_of_branches(track, ca.DM([100.0, 60.0]))))

    assert loads[:3, 0].tolist() == [60.0, 60.0, 80.0]
    assert loads[0, 1] == 100.0


def test_at_rest_friction_is_less_where_it_rises_with_speed_alone() -> None:
    """It has no time to rise there, and creep none to fall."""

    def at_rest(effect: str, **values: float) -> float:
        found = found_model({f"{effect}.{name}": value for name, value in values.items()}, bristles=8)
        theta = found["model"].theta({**found["values"], "mu": 1.0})
        loads, _ = build_equivalent_contact(found["model"])([0, 0.3, 400, 0.01], theta, [0.045, 0.009])
        now, rest = np.asarray(loads).ravel()
        return rest / now

    assert at_rest("rate_friction", c=0.1) < 0.7
    assert at_rest("rate_friction", c=-0.1) == 1
    assert at_rest("stribeck", ratio=1.3, v_s=0.003) == 1
    assert at_rest("frictional_creep", c=0.1) == 1


@pytest.mark.long
def test_a_law_of_speed_is_believed_after_a_turn_back() -> None:
    """Of the wrong sign it once was usable and six deviations off in the first turn."""
    for c, early in ((1e-6, True), (0.15, False)):
        hand = Hand(amplitude=0.45, first=1.0, pace=0.2)
        made = make_recording(
            44, {"rate_friction": {"c": c}}, mu=0.2, k=K, bristles=300, duration=12.0, hand=hand
        )
        observer = Ekf(**found_model({"rate_friction.c": c}, bristles=40), rig=RIG)
        usable = run(observer, made.t, made.psi, made.F_N, made.M_z).usable
        back = int(np.argmax(np.maximum.accumulate(np.abs(made.psi)) - np.abs(made.psi) > 0.01))

        assert usable[:back].any() == early
        assert usable[back:].mean() > 0.5


def test_the_contact_that_slides_as_a_model_does() -> None:
    """Against the torque of a steady full slide to either side, over mu and the declared arm."""
    values = {"rate_friction.c": 0.1, "contact_length.n": 0.5, "contact_length.F_0": 300.0}
    found = found_model(values | {"contact_length.m": 2.0}, bristles=200)
    model, theta = found["model"], found["model"].theta({**found["values"], "mu": 1.0})
    contact, slide = build_equivalent_contact(model), build_full_slide(model)
    memory, geometry = np.zeros(model.memory_size), [0.045, 0.009]

    for psi_dot, F_N in ((0.3, 300.0), (-0.05, 420.0), (0.0, 240.0)):
        loads, half_length = contact([0.0, psi_dot, F_N, 0.01], theta, geometry)
        assert float(half_length) == pytest.approx(0.045 * np.sqrt(F_N / 300.0))
        for load, rate in zip(np.asarray(loads).ravel(), (max(abs(psi_dot), REST), REST), strict=True):
            expected = float(slide(memory, F_N, theta, geometry, rate)[1])
            assert load * float(full_slide_arm(half_length, 0.009)) == pytest.approx(expected, rel=0.04)
    assert build_equivalent_contact(found_model({"carcass_torsion.k_t": 390.0})["model"]) is None


def test_the_angle_behind_a_gap() -> None:
    model = found_model({"backlash.gap": 0.02}, bristles=8)
    angle = build_patch_angle(model["model"])
    theta = model["model"].theta({**model["values"], "mu": 1.0})

    def behind(last: float, psi: float, M_z: float) -> float:
        return float(angle(last, psi, M_z, 0.01, 400.0, theta))

    # The flank that a clear torque touches, whatever came before.
    assert behind(0.0, 0.3, -2.0) == pytest.approx(0.29, abs=1e-5)
    assert behind(0.0, 0.3, 2.0) == pytest.approx(0.31, abs=1e-5)
    # Where the torque may be on either side, what is behind stays, and is taken along at the flanks.
    assert behind(0.295, 0.3, -0.2) == pytest.approx(0.295)
    assert behind(0.25, 0.3, np.nan) == pytest.approx(0.29, abs=1e-5)
    assert behind(0.25, np.nan, -2.0) == 0.25
    assert build_patch_angle(found_model({"carcass_torsion.k_t": 390.0})["model"]) is None
