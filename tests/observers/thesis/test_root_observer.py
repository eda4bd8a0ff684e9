"""The source's own method: the root, what it needs, and where it ends."""

from dataclasses import replace
from math import isnan, nan
from pathlib import Path as FilePath
from time import perf_counter

import numpy as np
import pytest

from observers.protocol import Sample, Status
from observers.thesis.root_observer import RootObserver, ZoneRootState, nearest_root
from observers.thesis.zone_state_machine import zone_torque_curve
from symbolic import InvalidInputError, Model, Rig
from symbolic.float_array_type import Array
from tests.observers.published import DECLARED, FIVE_ZONES, MU, SETTLED, STEEL, TIME, published, rms
from tests.symbolic.oracles import Path, Tyre, run, straight, worst

TYRE = Tyre(mu=1.3)
RIG = Rig(a=TYRE.a, e=TYRE.e)
LOAD = 400.0
REACH = 4 * TYRE.slope(LOAD) * TYRE.a
"""A turn after which nearly all of the patch slides [rad]."""


def root(rig: Rig = RIG, k: float = TYRE.k, **settings: float) -> RootObserver:
    return RootObserver(rig=rig, k=k, **{"least_turn": 1e-9, **settings})


def states_of(
    observer: RootObserver, psi: Array, M_z: Array | float = nan, F_N: Array | float = LOAD
) -> list[ZoneRootState]:
    rows = np.broadcast_arrays(psi, M_z, F_N)
    state, states = None, []
    for angle, torque, load in zip(*rows, strict=True):
        sample = Sample(psi=angle, psi_dot=0.0, F_N=load, dt=0.01, M_z=torque)
        state = observer.step(observer.init(sample) if state is None else state, sample)
        states.append(state)
    return states


def mu_of(states: list[ZoneRootState]) -> Array:
    return np.array([state.mu for state in states])


def exact(psi: Array, tyre: Tyre = TYRE) -> Array:
    return run(Model(), Path(psi=psi, F_N=np.full(psi.shape, LOAD), tyre=tyre)).M_z


def test_torque_follows_the_exact_patch_through_three_and_five_zones() -> None:
    psi = 0.02 + straight(0.0, REACH, -1.3 * REACH, 1.5 * REACH, 0.0)
    states = states_of(root(mu=TYRE.mu), psi)

    error = worst(np.array([state.M_z_predicted for state in states]), exact(psi))
    assert {state.zones.zones for state in states} == {3, 5}
    assert error < 1e-12


@pytest.mark.parametrize("mu", [0.5, 0.9, 1.8])
def test_friction_is_recovered_without_noise(mu: float) -> None:
    tyre = replace(TYRE, mu=mu)
    reach = REACH * mu / TYRE.mu
    psi = straight(0.0, reach, -1.3 * reach, 1.5 * reach, 0.0)
    states = states_of(root(), psi, exact(psi, tyre))

    slides = 10
    error = np.abs(mu_of(states) - mu)[slides:].max()
    print(f"mu = {mu}: within {error:.1e}")
    assert error < 1e-4
    assert not states[0].informed
    assert all(state.informed for state in states[slides:])


@pytest.mark.parametrize("guess", [0.3, 1.0, 3.0])
def test_friction_is_recovered_from_five_zones_alone(guess: float) -> None:
    psi = straight(0.0, REACH, -0.95 * REACH)
    M_z = exact(psi)
    M_z[:-1] = nan
    *_, before, last = states_of(root(mu=guess), psi, M_z)

    assert (before.mu, before.informed, before.status) == (guess, False, Status.MISSING)
    assert (last.zones.zones, last.solved, last.status) == (5, True, Status.USED)
    assert last.mu == pytest.approx(TYRE.mu, abs=1e-6)


def test_two_roots_in_five_zones_and_the_start_chooses() -> None:
    torque = zone_torque_curve((REACH, -0.5 * REACH), LOAD, TYRE.k, RIG)
    M_z = torque(TYRE.mu)[0]

    low, high = (nearest_root(torque, M_z, start, (0.02, 4.0), 1e-6) for start in (0.8, 1.5))

    print(f"mu = {TYRE.mu} looks like {low[0]:.3f} too")
    assert (low[1], high[1]) == (True, True)
    assert high[0] == pytest.approx(TYRE.mu, abs=1e-6)
    assert low[0] < 0.9 * TYRE.mu


@pytest.mark.parametrize("start", [0.1, 1.0, 3.9])
def test_without_a_root_the_nearest_point_counts(start: float) -> None:
    torque = zone_torque_curve((REACH, -0.9 * REACH), LOAD, TYRE.k, RIG)
    tried = np.linspace(0.02, 4.0, 4001)
    reached = np.array([torque(mu)[0] for mu in tried])

    mu, solved = nearest_root(torque, reached.max() + 0.1, start, (0.02, 4.0), 1e-6)

    assert not solved
    assert mu == pytest.approx(tried[reached.argmax()], abs=2e-3)


@pytest.mark.parametrize(("factor", "bound"), [(1.1, 4.0), (-0.1, 0.02)])
def test_beyond_stick_and_against_the_turn_mu_lies_on_its_bound(factor: float, bound: float) -> None:
    psi = np.array([0.0, 1e-3])
    stick = zone_torque_curve((1e-3, 0.0), LOAD, TYRE.k, RIG)(1e3)[0]
    last = states_of(root(), psi, np.array([0.0, factor * stick]))[-1]

    assert (last.mu, last.solved) == (bound, False)
    assert last.status == Status.BOUND | Status.NO_ROOT


@pytest.mark.parametrize("name", ["psi", "M_z", "F_N"])
def test_missing_samples_keep_the_estimate(name: str) -> None:
    psi = straight(0.0, REACH, -0.9 * REACH)
    rows = {"psi": psi.copy(), "M_z": exact(psi), "F_N": np.full(psi.shape, LOAD)}
    gone = np.flatnonzero(np.random.default_rng(3).random(psi.size) < 0.3)[1:]
    rows[name][gone] = nan
    states = states_of(root(), *rows.values())

    flag = Status.MISSING if name == "M_z" else Status.HELD
    for i in gone:
        assert (states[i].mu, states[i].raw) == (states[i - 1].mu, states[i - 1].raw)
        assert states[i].status == flag
        assert not states[i].solved
        assert np.isfinite(states[i].M_z_predicted)
    assert np.abs(mu_of(states)[10:] - TYRE.mu).max() < 1e-4


@pytest.mark.parametrize("name", ["psi", "F_N"])
def test_until_angle_and_load_are_known_there_is_the_first_guess(name: str) -> None:
    psi = 0.05 + straight(0.0, REACH)
    rows = {"psi": psi.copy(), "M_z": exact(psi), "F_N": np.full(psi.shape, LOAD)}
    rows[name][:3] = nan
    if name == "psi":
        # The patch then stands at rest where its angle is first seen.
        rows["M_z"][3:] = exact(psi[3:])
    states = states_of(root(mu=0.9), *rows.values())

    assert [state.mu for state in states[:3]] == [0.9] * 3
    assert all(isnan(state.M_z_predicted) for state in states[:3])
    assert mu_of(states)[-1] == pytest.approx(TYRE.mu, abs=1e-6)


def test_smoothing_is_the_printed_filter() -> None:
    psi = straight(0.0, REACH, -REACH)
    M_z = exact(psi) + 0.05 * np.random.default_rng(4).standard_normal(psi.size)
    raw = mu_of(states_of(root(), psi, M_z))
    smooth = mu_of(states_of(root(smoothing=0.9), psi, M_z))

    expected, mu = [], 1.0
    for one in raw:
        mu = 0.9 * mu + 0.1 * one
        expected.append(mu)
    np.testing.assert_allclose(smooth, expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("k", nan), ("mu", 0.01), ("mu", 5.0), ("mu", nan), ("bounds", (0.0, 4.0)),
        ("bounds", (4.0, 0.02)), ("bounds", (0.02, np.inf)), ("smoothing", 1.0), ("smoothing", -0.1),
        ("smoothing", nan), ("least_turn", -1e-3), ("least_turn", nan),
    ],
)  # fmt: skip
def test_settings_out_of_range_are_refused(name: str, value: float) -> None:
    with pytest.raises(InvalidInputError, match=name):
        root(**{name: value})


@pytest.mark.parametrize(("mu", "late_bound"), [(0.5, 0.45), (1.8, 0.3)])
def test_published_simulations(mu: float, late_bound: float, simulation_dir: FilePath) -> None:
    file = simulation_dir / f"sim_mu_{10 * mu:02.0f}.csv"
    t, psi, _, torque, e, F_N, _, _, published, _ = np.genfromtxt(file, delimiter=",")[1:].T
    observer = RootObserver(rig=Rig(a=0.04, e=e[0]), k=6e4)
    # The torque has the other sign and is one sample late.
    in_time = mu_of(states_of(observer, psi[:-1], -torque[1:], F_N[:-1]))
    as_it_stands = mu_of(states_of(observer, psi, -torque, F_N))

    late, theirs = (rms((found - mu)[t >= 0.5]) for found in (as_it_stands, published))
    ours = rms((in_time - mu)[t[:-1] >= 0.5])
    print(f"mu = {mu}: rmse {ours:.4f}, {late:.4f} without the shift, published {theirs:.4f}")
    assert ours < 1.5 * theirs
    assert late < late_bound


@pytest.mark.measured
@pytest.mark.parametrize(("name", "shift"), STEEL)
def test_measured_on_steel_it_is_as_good_as_published(
    measured_dir: FilePath, name: str, shift: int
) -> None:
    recording, columns, same = published(measured_dir, name, shift)
    observer = RootObserver(rig=recording.rig, k=recording.tyre.k)
    begin = perf_counter()
    states = states_of(observer, recording.psi, recording.M_z, recording.F_N)
    spent = (perf_counter() - begin) / len(states)
    author, settled, found = columns[MU], columns[TIME] >= SETTLED, mu_of(states)[same]
    estimates = (found, author, np.clip(author, *observer.bounds))
    ours, theirs, bounded = (rms(mu[settled] - DECLARED) for mu in estimates)
    rootless = np.mean([not state.solved for state in states[shift:]])
    print(
        f"{name}: rmse {ours:.3f}, published {theirs:.3f} ({bounded:.3f} within our bounds); no root in"
        f" {rootless:.0%} of the samples; {spent * 1e6:.0f} us a step"
    )
    three = columns[FIVE_ZONES] == 0
    assert np.median(np.abs(found - author)[three]) < 0.01
    assert ours < 1.05 * theirs
    assert ours == pytest.approx(bounded, rel=0.05)
