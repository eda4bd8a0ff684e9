"""Friction by direction, against bristles whose limits differ by direction."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from observers import CLEAN, DirectionalFriction, Ekf, Estimates, Mhe, Status, Tuning, build_clean, run
from observers.measurement.measurement_model import RIG as RIG_NUMBERS
from observers.measurement.motion_and_torque_jacobians import build_linearised_motion
from symbolic import InvalidInputError, Model, effects_named
from symbolic.float_array_type import Array
from tests.observers.conftest import RIG, K

F_N, FORTH, BACK, LATER, CHANGE = 400.0, 1.2, 0.6, 0.7, 10.0
"""Load [N]; friction by direction, and forth after a change at 10 s [1]."""
t = np.arange(0, 20, 0.01)
psi = 0.25 * np.sin(np.pi / 2 * t)
TURNS = np.searchsorted(t, np.arange(1, 20, 2))
"""Where the wheel turns back, after sliding forth and back by turns."""


def torque(angle: Array, forth: Array, back: Array, bristles: int = 300) -> Array:
    """M_z [N m] of stops along the patch, each with its own limit either way."""
    x = RIG.a * ((2 * np.arange(bristles) + 1) / bristles - 1)
    lever, limit = np.abs(x - RIG.e), 0.75 * F_N / (RIG.a * K) * (1 - (x / RIG.a) ** 2)
    stress, found = np.zeros(bristles), []
    for turn, most, least in zip(np.diff(angle, prepend=0.0), forth, back, strict=True):
        stress = np.clip(stress + lever * turn, -least * limit, most * limit)
        found.append(-K * np.sum(lever * stress) * 2 * RIG.a / bristles)
    return np.array(found)


def directed(kind: Any, **tuning: Any) -> Any:
    """An observer of friction by direction on the rig's usual tyre."""
    return kind(
        model=Model(discretised=True, bristles=40), values={"k": K}, rig=RIG,
        measurement_model=DirectionalFriction(), tuning=Tuning(**tuning),
    )  # fmt: skip


def observed(
    kind: Any,
    forth: float,
    later: float,
    back: float,
    factor: float = 1.0,
    zero: float = 0.0,
    **tuning: float,
) -> tuple[Estimates, Array, Array]:
    """Estimates, friction of the direction of motion, and whether the torque opposes it."""
    ahead = np.where(t < CHANGE, forth, later)
    M_z = torque(psi, ahead, np.full(t.size, back))
    noise = 0.01 * 0.375 * F_N * RIG.a * np.random.default_rng(3).standard_normal(t.size)
    rate = np.gradient(psi)
    measured = factor * (M_z + noise) + zero * 0.375 * F_N * RIG.a
    found = run(directed(kind, **tuning), t, psi, np.full(t.size, F_N), measured)
    return found, np.where(rate > 0, ahead, back), rate * (M_z + noise) < -1e-3


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
def test_each_direction_has_its_friction_and_changes_by_itself(kind: Any) -> None:
    found, true, _ = observed(kind, FORTH, LATER, BACK)
    at = TURNS - 1
    changed = (found.status & Status.RESET) > 0

    np.testing.assert_allclose(found.mu[at], true[at], rtol=0.03)
    assert (np.abs(found.mu - true) < 2 * found.mu_std)[at].all()
    assert found.usable[at].mean() >= 0.6
    assert (found.status & Status.ACQUIRING)[:30].all()
    # The wheel goes back from 9 to 11 s, and the alarm comes on the next way forth.
    assert changed.sum() == 1
    assert 11 < t[changed][0] < 13
    assert 0.5 * Tuning().mu_std < found.mu_std[np.searchsorted(t, 0.2)]


@pytest.mark.long
@pytest.mark.parametrize("mu", [(0.05, 0.05, 0.05), (0.1, 0.1, 0.05), (1.0, 0.05, 1.0), (2.5, 2.5, 1.5)])
@pytest.mark.parametrize("walk", [0.01, 0.1])
def test_what_is_usable_is_not_far_off(mu: tuple[float, float, float], walk: float) -> None:
    found, true, loaded = observed(Ekf, *mu, mu_walk=walk, zero_std=0.002)
    usable = found.usable & loaded

    assert usable.mean() > 0.15
    assert (np.abs(found.mu - true) < 3 * found.mu_std)[usable].all()


def test_the_zero_is_part_of_the_band() -> None:
    found, true, loaded = observed(Ekf, 0.15, 0.15, 0.15, zero=0.03)
    usable = found.usable & loaded
    known, *_ = observed(Ekf, 0.15, 0.15, 0.15, zero_std=0.003)

    assert usable.mean() > 0.15
    assert (np.abs(found.mu - true) < 2 * found.mu_std)[usable].all()
    assert (np.abs(found.mu - true) > 0.02)[usable].any()
    assert known.mu_std[-1] < 0.5 * found.mu_std[-1]
    # A quarter of friction and more is not informed.
    assert not observed(Ekf, 0.08, 0.08, 0.08)[0].informed.any()


@pytest.mark.parametrize("every", [1, 2])
@pytest.mark.parametrize(("duration", "alarms"), [(0.035, 0), (0.065, 1)])
def test_a_burst_alarms_by_its_duration_at_any_rate(every: int, duration: float, alarms: int) -> None:
    fine = np.arange(0, 2.8, 0.005 * (3 - every))
    angle, level = 0.25 * np.sin(np.pi / 2 * fine), np.full(fine.size, 1.0)
    burst = (fine > 2.2) & (fine < 2.2 + duration)
    observer = directed(Ekf, alarm=1e6, gate=6.0)
    M_z = torque(angle, level, level) * np.where(burst, 3.0, 1.0)
    found = run(observer, fine, angle, np.full(fine.size, F_N), M_z)

    assert ((found.status & Status.RESET) > 0)[fine < 2.3].sum() == alarms


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
@pytest.mark.parametrize(("ratio", "start"), [(0.85, 0.0), (1 / 0.85, 0.1)])
def test_a_model_with_an_asymmetry_changes_its_limit_where_the_angle_turns(
    kind: Any, ratio: float, start: float
) -> None:
    """Stops whose limit is that of the motion, so that the torque falls where the weaker way begins."""
    angle = start + psi
    way = np.where(np.gradient(psi) > 0, ratio, 1.0)
    slide = 0.375 * F_N * RIG.a
    M_z = torque(angle, way, way) + 0.005 * slide * np.random.default_rng(3).standard_normal(t.size)
    observer = kind(
        model=Model(effects=effects_named(["asymmetric_friction"]), bristles=40),
        values={"k": K, "asymmetric_friction.ratio": ratio}, rig=RIG,
        measurement_model=DirectionalFriction(),
        tuning=Tuning(noise=0.007, error=0.022, explained=2.5, zero_std=0.003),
    )  # fmt: skip
    found = run(observer, t, angle, np.full(t.size, F_N), M_z)
    late, at = t > 6, TURNS[3:] - 1

    assert not (found.status & Status.INCONSISTENT).any()
    # But in the samples of the reversal itself; exchanged later, every fifth is off by so much.
    assert (np.abs(M_z - found.M_z_predicted) > 0.04 * slide)[late].mean() < 0.03
    assert found.usable[late].mean() > 0.9
    np.testing.assert_allclose(found.mu_eff[at], way[at], rtol=0.03)
    side = observer.measurement_model.directions(t, angle, M_z)
    np.testing.assert_array_equal(side[at], np.where(way == ratio, 1, -1)[at])


@pytest.mark.parametrize("factor", [-1.0, 1000.0])
def test_a_torque_of_another_sign_or_unit_is_suspected(factor: float) -> None:
    found, *_ = observed(Ekf, FORTH, FORTH, BACK, factor)

    assert not found.usable[100:].any()
    assert found.status[-1] & Status.SUSPECT


def test_the_share_of_the_weaker_direction_is_that_of_a_model_with_one_friction() -> None:
    settings: Any = {
        "model": Model(effects=effects_named(["asymmetric_friction"]), bristles=40),
        "values": {"k": K, "asymmetric_friction.ratio": 1.25},
        "rig": RIG,
    }

    # 1 and 1.25 have the mean 1.125.
    assert Ekf(**settings).weaker == pytest.approx(0.125 / 1.125)
    assert Ekf(model=Model(), values={"k": K}, rig=RIG).weaker == 0.0
    with pytest.raises(InvalidInputError, match="a state for each direction"):
        _ = Ekf(**settings, measurement_model=DirectionalFriction()).weaker


def test_directions_are_exchanged_where_the_torque_changes_sign() -> None:
    clean, model = build_clean(DirectionalFriction()), DirectionalFriction()
    now: Any = np.zeros(len(CLEAN))
    x, variance, seen = np.log([FORTH, BACK]), np.array([0.01, 0.04]), []
    for angle, M_z in [
        (0.01, -1),
        (0.02, -2),
        (0.0199, -2),
        (0.01, -1),
        (0.0, 1),
        (0.0, np.nan),
        (0.01, np.nan),
    ]:
        last = now
        now, _ = clean([angle, 0.0, F_N, 0.01, M_z, np.nan], last)
        rig = np.full(len(RIG_NUMBERS), RIG.a)
        motion = build_linearised_motion(model)
        x, A, Q, _ = motion(x, 0.0, 0.0, last, now, rig, Tuning(mu_walk=0.2).vector)
        variance = np.diag(np.asarray(A) @ np.diag(variance) @ np.asarray(A).T) + np.asarray(Q).ravel()
        seen.append(np.exp(np.asarray(x).ravel()).round(6).tolist())
    ahead, turned = [FORTH, BACK], [BACK, FORTH]

    # Not by noise, not before the patch is unloaded; where no torque is known, at once.
    assert seen == [ahead, ahead, ahead, ahead, turned, turned, ahead]
    np.testing.assert_allclose(variance, np.array([0.01, 0.04]) + 7 * 0.01 * 0.2**2)


def test_between_torques_that_come_more_slowly_the_direction_waits_for_the_next_one() -> None:
    t, nan = np.arange(0.0, 0.08, 0.001), np.nan
    psi = 0.05 - 2 * np.abs(t - 0.03)
    # Full slide one way; after the wheel has turned back the torque changes its sign only at 60 ms.
    M_z = np.where(np.arange(t.size) % 10 == 0, np.where(t < 0.0595, -2.0, 2.0), nan)
    side = DirectionalFriction().directions(t, psi, M_z)
    np.testing.assert_array_equal(side[10:], np.where(t < 0.0595, 1, -1)[10:])
    # Without torques for longer than that it is exchanged where the angle turns back.
    alone = DirectionalFriction().directions(t, psi, np.where(t < 0.015, M_z, nan))
    assert alone[32] == -1


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
@pytest.mark.parametrize(
    ("back", "zero", "usable"),
    [(0.8, 0.05, True), (0.65, None, True), (0.65, 0.05, False), (0.5, None, False)],
)
def test_friction_by_direction_is_no_zero_beyond_what_it_may_be(
    kind: Any, back: float, zero: float | None, usable: bool
) -> None:
    M_z = torque(psi, np.full(t.size, 0.8), np.full(t.size, back))
    rig = replace(RIG, tolerances=replace(RIG.tolerances, zero=zero))
    found = run(kind(model=Model(), values={"k": K}, rig=rig), t, psi, np.full(t.size, F_N), M_z)

    assert found.usable[t > 10].all() == usable
    assert usable or not found.usable[t > 10].any()


def test_a_declared_zero_is_no_share_of_the_first_load() -> None:
    M_z = torque(psi, np.full(t.size, 0.8), np.full(t.size, 0.5))
    rig, load = replace(RIG, tolerances=replace(RIG.tolerances, zero=0.4)), np.full(t.size, F_N)
    load[:3] *= 2
    found = run(Ekf(model=Model(), values={"k": K}, rig=rig), t, psi, load, M_z)

    assert not found.usable[t > 10].any()
