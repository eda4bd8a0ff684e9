"""The rig's patch, path and recordings against facts that are known without it."""

import runpy
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from reference_rig import (
    Array,
    RigDrive,
    RigRecording,
    RigTyre,
    hand_path,
    make_campaign,
    make_recording,
    plant_effect,
    simulate_bristles,
)

LOAD = 400.0
TYRE = RigTyre()


def steady(psi: Array) -> RigDrive:
    """A path of small steps at constant load."""
    t = np.arange(len(psi)) * 0.01
    rate = np.gradient(psi, t)
    return RigDrive(t=t, psi=psi, psi_dot=rate, F_N=np.full_like(psi, LOAD), psi_virgin=0.0)


def virgin_torque(psi: float, tyre: RigTyre, load: float = LOAD) -> float:
    """The integral of k q (x - e) over the patch, piece by piece between the kinks of q."""
    a, e, k = tyre.a, tyre.e, tyre.k
    slope = 3 * load * tyre.mu / (4 * a**3 * k)

    def excess(x: float, side: int) -> float:
        return side * (x - e) * psi - slope * (a**2 - x**2)

    def moment(x: float) -> float:
        limit = slope * (a**2 - x**2)
        return k * float(np.clip(-(x - e) * psi, -limit, limit)) * (x - e)

    kinks = [-a, brentq(excess, -a, e, args=(-1,)), brentq(excess, e, a, args=(1,)), a]
    return sum(quad(moment, *piece, epsabs=1e-13)[0] for piece in pairwise(kinks))


@pytest.mark.parametrize("e", [0.0, 0.009, -0.02])
def test_first_turn_follows_the_integral(e: float) -> None:
    tyre = RigTyre(e=e)
    psi = np.linspace(0, 0.5, 41)

    M_z = simulate_bristles(steady(psi), tyre, bristles=4000).M_z

    expected = [virgin_torque(angle, tyre) if angle else 0.0 for angle in psi]
    np.testing.assert_allclose(M_z, expected, atol=3e-6 * np.ptp(expected))
    assert np.all(M_z[1:] < 0)


def test_torque_does_not_depend_on_the_step() -> None:
    coarse, fine = np.linspace(0, 0.3, 4), np.linspace(0, 0.3, 301)

    np.testing.assert_allclose(
        simulate_bristles(steady(coarse), TYRE).M_z,
        simulate_bristles(steady(fine), TYRE).M_z[::100],
        atol=1e-11,
    )


def test_grid_converges() -> None:
    psi = np.array([0.0, 0.07])

    errors = [
        abs(simulate_bristles(steady(psi), TYRE, bristles=n).M_z[-1] - virgin_torque(0.07, TYRE))
        for n in (100, 2000)
    ]

    assert errors[1] < errors[0] / 50


def test_masing_and_madelung() -> None:
    back = np.array([0.2, 0.15, 0.05, 0.12, 0.05, -0.1, 0.2, 0.3])

    M_z = simulate_bristles(steady(np.concatenate([[0.0], back])), TYRE, bristles=4000).M_z[1:]

    def virgin(psi: float) -> float:
        return virgin_torque(psi, TYRE)

    down = [virgin(0.2) - 2 * virgin((0.2 - psi) / 2) for psi in (0.15, 0.05, -0.1)]
    nested = down[1] + 2 * virgin((0.12 - 0.05) / 2)
    closed = down[2] + 2 * virgin((0.2 + 0.1) / 2)
    expected = [virgin(0.2), down[0], down[1], nested, down[1], down[2], closed]
    np.testing.assert_allclose(M_z[:-1], expected, atol=5e-5)
    # The loop has closed and is forgotten: the patch goes on as if it had never turned back.
    assert M_z[-1] == pytest.approx(virgin(0.3), abs=5e-5)


@pytest.mark.parametrize("seed", range(8))
def test_hand_turns_like_a_hand(seed: int) -> None:
    path = hand_path(seed)
    speed = np.abs(path.psi_dot)
    reversals = np.flatnonzero(np.diff(np.sign(path.psi_dot[path.psi_dot != 0])))

    assert not np.any(path.psi[path.t < 0.49])
    assert 0.15 < np.max(np.abs(path.psi)) < 0.6
    assert len(reversals) >= 3
    assert speed.max() < 0.45
    assert np.mean((speed > 0.03) & (speed < 0.35)) > 0.6
    assert np.all(np.abs(path.F_N / 400 - 1) < 0.07)
    np.testing.assert_allclose(
        np.diff(path.psi), 0.5 * (path.psi_dot[1:] + path.psi_dot[:-1]) / 400, atol=1e-15
    )


def test_silent_recording_is_the_truth() -> None:
    made = make_recording(3, noise=0.0, encoder_step=0.0)

    assert np.array_equal(made.M_z, made.M_z_true)
    assert np.array_equal(made.psi, made.psi_true)
    assert np.array_equal(made.F_N, made.F_N_true)


def _share(made: RigRecording) -> float:
    tyre = made.tyre
    without = make_recording(12, mu=tyre.mu, k=tyre.k, a=tyre.a, noise=0.0).M_z
    return float(np.sqrt(np.mean((made.M_z_true - without) ** 2)) / np.ptp(without))


@pytest.mark.parametrize(
    "name", [pytest.param("carcass_torsion", marks=pytest.mark.long), "friction_drift", "gust"]
)
def test_planted_effect_is_as_strong_as_asked(name: str) -> None:
    assert _share(plant_effect(name, 12, share=0.06)) == pytest.approx(0.06, rel=0.03)


def test_campaign_shares_the_tyre_and_not_the_day() -> None:
    made = make_campaign("torque_offset", 4, duration=6.0)
    tyres = [recording.tyre for recording in made.recordings]

    assert len({tyre.k for tyre in tyres}) == len({tyre.a for tyre in tyres}) == 1
    assert len({tyre.mu for tyre in tyres}) == 3
    assert len({recording.effects["torque_offset"]["M_0"] for recording in made.recordings}) == 3
    assert made.nominal.a == tyres[0].a
    assert 0.8 <= made.nominal.k / tyres[0].k <= 1.2


def test_campaign_keeps_a_shared_effect() -> None:
    made = make_campaign("bearing_friction", 4, 2, duration=3.0, also={"torque_offset": {"M_0": 0.2}})

    assert made.recordings[0].effects == made.recordings[1].effects
    assert set(made.recordings[0].effects) == {"bearing_friction", "torque_offset"}


@pytest.mark.long
def test_embedded_recordings_are_made_by_the_rig(repository_root: Path) -> None:
    folder = repository_root / "examples" / "recordings"
    made = runpy.run_path(str(folder.parent / "make_recordings.py"))["files"]()

    assert {path.name for path in folder.iterdir()} == set(made)
    for name, text in made.items():
        assert (folder / name).read_text(encoding="utf-8") == text, name


def test_a_campaign_elsewhere_differs_in_lengths_and_friction_alone() -> None:
    there, usual = (
        make_campaign(None, 4, 4, duration=2.0, off=off, grounds=grounds)
        for off, grounds in ((0.0025, ("steel", "emery")), (0.0, ()))
    )

    assert [r.ground for r in there.recordings] == ["steel", "emery"] * 2
    assert [r.ground for r in usual.recordings] == [None] * 4
    assert there.nominal == usual.nominal
    offs = [r.tyre.a - there.nominal.a for r in there.recordings]
    assert max(map(abs, offs)) <= 0.0025
    assert len(set(offs)) == 4
    ratios = [
        one.tyre.mu / two.tyre.mu for one, two in zip(there.recordings, usual.recordings, strict=True)
    ]
    assert ratios[0] == pytest.approx(ratios[2])
    assert ratios[1] == pytest.approx(ratios[3])
    assert abs(ratios[0] - ratios[1]) > 0.01
    for one, two in zip(there.recordings, usual.recordings, strict=True):
        np.testing.assert_allclose(one.psi, two.psi)
        np.testing.assert_allclose(one.F_N, two.F_N, rtol=0.02)
