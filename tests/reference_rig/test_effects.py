"""Effects of the rig against closed forms.

`tests/symbolic/test_effects.py` holds those that the library has too against it, law by law.
"""

import numpy as np
import pytest

from reference_rig import (
    RENEWAL,
    RIG_EFFECTS,
    Array,
    EffectValues,
    RigDrive,
    RigHistory,
    RigTyre,
    build_effects,
    contact_age,
    free_path,
    hand_path,
    simulate_bristles,
)

LOAD = 400.0
CENTRED = RigTyre(e=0.0)
TRAILED = RigTyre(e=0.009)
SLIDE = 3 / 8 * CENTRED.mu * LOAD * CENTRED.a


def turn(psi: Array | list[float], psi_dot: float = 0.1, load: float = LOAD) -> RigDrive:
    """Turn to the angles at a stated rate; its sign follows the way."""
    psi = np.asarray(psi, dtype=float)
    way = np.sign(np.diff(psi, prepend=0.0))
    t, F_N = np.arange(len(psi)) * 0.01, np.full(len(psi), load)
    return RigDrive(t=t, psi=psi, psi_dot=psi_dot * way, F_N=F_N, psi_virgin=0.0)


def run(drive: RigDrive, tyre: RigTyre, planted: EffectValues | None = None) -> RigHistory:
    return simulate_bristles(drive, tyre, build_effects(planted or {}))


def slid(psi_dot: float = 0.1, load: float = LOAD) -> RigDrive:
    return turn([0.0, 500.0], psi_dot, load)


@pytest.mark.parametrize("name", RIG_EFFECTS)
def test_neutral_effect_changes_nothing(name: str) -> None:
    drive = hand_path(1, 6.0, rate=100.0)

    M_z = run(drive, TRAILED, {name: {}}).M_z

    np.testing.assert_allclose(M_z, run(drive, TRAILED).M_z, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "values", "drive", "expected"),
    [
        pytest.param("rate_friction", {"c": 0.5}, slid(0.0), [-0.05], id="rate friction has a floor"),
        pytest.param("stribeck", {"ratio": 1.3, "v_s": 3e-3}, slid(1e-9), [-1.3], id="static at rest"),
        pytest.param("stribeck", {"ratio": 1.3, "v_s": 3e-3}, slid(1e3), [-1.0], id="kinetic in a rush"),
    ],
)
def test_full_slide(name: str, values: dict[str, float], drive: RigDrive, expected: list[float]) -> None:
    """The torque after every turn, over that of the declared patch."""
    M_z = run(drive, CENTRED, {name: values}).M_z

    np.testing.assert_allclose(M_z[1:] / SLIDE, expected, rtol=1e-4)


def test_play_is_a_lost_way() -> None:
    psi = np.array([0.0, 0.005, 0.03, 0.025, 0.01])
    taken_up = np.array([0.0, 0.0, 0.025, 0.025, 0.015])

    played = run(turn(psi), TRAILED, {"play": {"gap": 0.01}})
    np.testing.assert_allclose(played.M_z, run(turn(taken_up), TRAILED).M_z, atol=1e-12)


def test_torque_swings_only_while_sliding() -> None:
    law = {"slide_oscillation": {"amplitude": 0.5, "frequency": 5.0}}
    sticking, sliding = turn(np.linspace(0, 1e-6, 50)), turn(np.linspace(0, 5000, 50))

    def swing(drive: RigDrive) -> float:
        return float(np.max(np.abs(run(drive, CENTRED, law).M_z - run(drive, CENTRED).M_z)))

    assert swing(sticking) < 0.01
    assert swing(sliding) == pytest.approx(0.5, rel=0.02)


def test_gust_is_slow_and_of_its_level() -> None:
    drive = hand_path(3, 14.0, rate=100.0)

    gust = run(drive, TRAILED, {"gust": {"level": 0.4, "seed": 2}}).M_z - run(drive, TRAILED).M_z

    assert np.sqrt(np.mean(gust**2)) == pytest.approx(0.4)
    assert np.max(np.abs(np.diff(gust))) < 0.05


def test_one_branch_only() -> None:
    branch = build_effects({"viscoelastic_relaxation": {"gain": 0.2}})

    with pytest.raises(ValueError, match="one Maxwell branch"):
        simulate_bristles(turn([0.0, 0.1]), TRAILED, [*branch, *branch])


def drive(psi: Array) -> RigDrive:
    """Angles at an even clock under a constant load."""
    return free_path(np.arange(psi.size) * 0.01, psi, load=LOAD, rate=100.0)


def torque(path: RigDrive, **planted: dict[str, float]) -> Array:
    return simulate_bristles(path, TRAILED, build_effects(planted), bristles=200).M_z


def test_a_free_branch_relaxes_and_outgrows_friction() -> None:
    stiffness, time = 300.0, 0.4
    turned = np.concatenate([np.linspace(0, 0.5, 101), np.full(80, 0.5)])

    path = drive(turned)
    added = torque(path) - torque(path, free_branch={"stiffness": stiffness, "time": time})

    # psi' = 0.5 rad/s: twist = psi' tau (1 - exp(-t / tau)), then it decays.
    steady = 0.5 * time * (1 - np.exp(-1.0 / time))
    assert added[100] == pytest.approx(stiffness * steady, rel=1e-9)
    assert added[180] == pytest.approx(stiffness * steady * np.exp(-0.8 / time), rel=1e-9)
    assert added[100] > 2 * np.abs(torque(path)).max()


def test_an_eccentric_encoder_errs_by_a_sine() -> None:
    path = drive(0.4 * np.sin(np.linspace(0, 9, 300)))
    law = {"amplitude": 0.004, "cycles": 8.0, "phase": 0.7}

    wheel = drive(path.psi + 0.004 * np.sin(8.0 * path.psi + 0.7))

    np.testing.assert_allclose(torque(path, encoder_eccentricity=law), torque(wheel), atol=1e-12)
    (effect,) = build_effects({"encoder_eccentricity": law})
    np.testing.assert_allclose(effect.drive(path).psi_dot, wheel.psi_dot, rtol=0, atol=2e-3)


def test_a_torque_sensor_lags_by_its_height() -> None:
    path = hand_path(2, 8.0, rate=100.0)
    bare, height = torque(path), 0.5

    shown = torque(path, sensor_hysteresis={"height": height})

    behind = bare - shown
    rising, falling = np.diff(bare) > 0, np.diff(bare) < 0
    moved = np.diff(shown) != 0
    assert np.abs(behind).max() <= height + 1e-12
    np.testing.assert_allclose(behind[1:][moved & rising], height, atol=1e-9)
    np.testing.assert_allclose(behind[1:][moved & falling], -height, atol=1e-9)


def test_a_contact_ages_at_rest_and_is_renewed_by_turning() -> None:
    dt = 0.01
    psi = np.concatenate([np.zeros(200), np.linspace(0, 3, 501)[1:], np.full(100, 3.0)])

    age = contact_age(psi, np.full(psi.size, dt))

    assert age[199] == pytest.approx(199 * dt)
    # Steady: renewal over rate; then rest adds to it.
    assert age[699] == pytest.approx(RENEWAL / 0.6, rel=1e-6)
    assert age[799] == pytest.approx(RENEWAL / 0.6 + 100 * dt, rel=1e-6)


def test_a_rested_contact_holds_more() -> None:
    path = drive(np.concatenate([np.zeros(5000), np.linspace(0, 2.0, 4000)]))

    rested, bare = torque(path, contact_ageing={"gain": 0.2}), torque(path)

    assert np.abs(rested).max() > 1.03 * np.abs(rested[-1])
    age = RENEWAL / 0.05
    assert rested[-1] / bare[-1] == pytest.approx(1 + 0.2 * np.log1p(age), rel=1e-2)
