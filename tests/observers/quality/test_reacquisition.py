"""What a handover and a later acquisition take for known, and faults that pass for a new ground."""

from typing import Any

import casadi as ca
import numpy as np
import pytest

from observers import AligningTorque, Loop, Sample, SteeringTorque, run
from observers.protocol import OUTPUT, Status
from observers.quality.acquisition import (
    DECLARED_PATCH,
    FAILED,
    HOPELESS,
    OVER,
    OWN,
    PROVED,
    EquivalentPatch,
    build_acquisition_decision,
)
from observers.quality.acquisition_and_tracking import MAY_HAVE_MOVED, _search_restart_moments
from observers.quality.branch_consistency_and_band import NEW_GROUND, build_tracking_consistency
from observers.quality.hysteresis_branches import TRACK, build_new_ground_branches
from observers.quality.innovation_attribution import IN_A_ROW, smoothed_innovation_test
from observers.quality.mu_and_scale_from_hypotheses import VERDICT
from observers.quality.mu_over_k_hypotheses import (
    RESTART_STD,
    SETTINGS,
    build_hypothesis_search_restart,
    build_hypothesis_search_start,
    hypothesis_fields,
    search_layout,
)
from observers.tuning import Tuning
from reference_rig import RigTyre, friction_step, make_ground_recording, make_recording
from symbolic import SIGNALS, Model, simulate
from symbolic.masing import virgin_torque
from tests.observers.conftest import RIG, K
from tests.observers.factories import acquiring_ekf, columns_of, wrong_and_usable


def own_states(psi: Any, F_N: Any, M_z: Any) -> dict[str, Any]:
    """What the acquisition keeps after each sample, by name."""
    loop, own = Loop(acquiring_ekf()), []
    for angle, load, torque in zip(psi, F_N, M_z, strict=True):
        loop(Sample(psi=angle, psi_dot=0.0, F_N=load, M_z=torque, dt=0.01))
        own.append(np.asarray(loop.state["own"]).ravel())
    return dict(zip(OWN, np.array(own).T, strict=True))


@pytest.mark.parametrize("direction", [-1.0, 0.0, 1.0])
def test_a_later_acquisition_leaves_open_what_the_patch_was(direction: float) -> None:
    """At the last turn back it was free of torque, slid to the other side, or between the two."""
    layout = search_layout(False)
    search = np.asarray(build_hypothesis_search_start()(0.2, 1, 10.0, 0, 0.2)).ravel()
    at = layout.places["track"][0].start
    search[at + TRACK.index("direction")] = direction
    tyre = [K, RIG.a, RIG.e]
    restarted = build_hypothesis_search_restart()(search, 0, 5, tyre, 1.1, 0.1, 0.3, 0.2)
    after = layout.split(ca.MX(ca.DM(restarted)))
    names = ("track", "points", "hypotheses")
    track, points, hypotheses = (np.asarray(ca.evalf(after[name])) for name in names)

    np.testing.assert_array_equal(points[:, 0], 0.2)
    assert points[0, 1] == 0.2 + direction
    np.testing.assert_array_equal(points[1:, 1], 0.2)
    assert track[TRACK.index("count"), 0] == 1
    assert track[TRACK.index("count_slid"), 0] == (2 if direction else 1)
    names = hypothesis_fields(False)
    np.testing.assert_allclose(hypotheses[names.index("twist")], 0.55)
    np.testing.assert_allclose(hypotheses[names.index("gain")], 1.1)
    assert (hypotheses[names.index("D_twist")] > 0).all()


@pytest.mark.parametrize("side", [-1.0, 1.0])
@pytest.mark.parametrize("since", [0.01, 0.3])
def test_friction_that_rises_begins_where_it_rose(side: float, since: float) -> None:
    """There the patch was free of torque, slid to this side, or between; never before the turn back."""
    track = dict.fromkeys(TRACK, 0.0) | {"direction": side, "extreme": 0.1 * side, "origin": -0.1 * side}
    stuck = float(virgin_torque(since, 400.0, 100.0, K, RIG.a, RIG.e))
    M_z, tyre = side * (stuck - 0.2), [K, RIG.a, RIG.e]
    after, points = build_new_ground_branches()([*track.values()], M_z, 0.2, tyre)
    origin = side * (0.1 - min(since, 0.2))

    assert np.asarray(after)[TRACK.index("origin"), 0] == pytest.approx(origin, rel=1e-3)
    np.testing.assert_allclose(np.asarray(points)[:, 0], origin, rtol=1e-3)
    np.testing.assert_allclose(np.asarray(points)[:, 1], [origin - side, *[origin] * 3], rtol=1e-3)
    assert np.asarray(after)[TRACK.index("count_slid"), 0] == 1


@pytest.mark.parametrize(
    ("before", "after", "seed"),
    [
        *[(0.05, 1.0, 630_000), (0.05, 1.0, 630_001), (0.3, 0.8, 630_000), (0.8, 0.5, 630_018)],
        *[(1.0, 0.8, 630_002), (1.0, 0.8, 630_019), (0.08, 0.05, 630_000), (0.08, 0.05, 630_015)],
    ],
)
def test_another_ground_is_known_soon(before: float, after: float, seed: int) -> None:
    """Each of these changes once left friction doubted, or off, for the seven seconds that follow."""
    change = friction_step(5.0, before, after)
    tyre = RigTyre(a=RIG.a, e=RIG.e, k=K, mu=before)
    made = make_ground_recording(seed, change, tyre=tyre, duration=12.0)
    found = run(acquiring_ekf(), **columns_of(made))
    late = made.t > 11.0

    assert found.usable[(made.t > 4.5) & (made.t < 5.0)].all()
    assert found.usable[late].all()
    assert (np.abs(found.mu - after)[late] < 2 * found.mu_std[late]).all()


@pytest.mark.parametrize(
    ("confirmed", "weight", "lasting", "lost"),
    [(3, 12.0, 3.0, True), (2, 12.0, 3.0, False), (3, 12.0, 0.1, False), (3, 12.0, -3.0, True)],
)
def test_what_lasts_is_another_ground_to_a_model_that_was_right_for_long(
    confirmed: int, weight: float, lasting: float, lost: bool
) -> None:
    """Of one that had explained less it is the model that is wrong."""
    assert bool(_tracked(confirmed=confirmed, weight=weight, lasting=lasting, doubt=4.0)["lost"]) is lost


@pytest.mark.parametrize(("weight", "confirmed"), [(4.0, 0), (8.0, 2), (12.0, 3)])
def test_a_model_is_right_once_it_has_explained_ten_independent_samples(
    weight: float, confirmed: int
) -> None:
    assert _tracked(weight=weight)["confirmed"] == confirmed


def test_a_model_proves_itself_again_once_its_doubt_is_gone() -> None:
    """After one change that lasted, another needs more than ten independent samples between them."""
    assert _tracked(weight=12.0, doubt=1.5)["confirmed"] == PROVED - 1
    assert _tracked(weight=12.0, doubt=0.4)["confirmed"] == PROVED


@pytest.mark.parametrize(
    ("confirmed", "lost", "times"), [(PROVED, 1, MAY_HAVE_MOVED), (PROVED - 1, 1, 1), (PROVED, 0, 1)]
)
def test_where_an_innovation_lasted_scale_and_zero_may_have_moved(
    confirmed: int, lost: int, times: float
) -> None:
    own = dict.fromkeys(OWN, 0.0) | {"scale": 1, "F_N": 400.0, "confirmed": confirmed, "lost": lost}
    given = {name: ca.DM(value) for name, value in own.items()}
    verdict = ca.DM([0.2 * (name == "log_gain") for name in VERDICT])
    known = given, verdict, ca.DM(1), ca.DM(0), 1.5
    gain, gain_std, _, zero_std = _search_restart_moments(*known, "M_z")
    assert float(_search_restart_moments(*known, "")[1]) == RESTART_STD, (
        "on ice a steering torque tells no s anew"
    )

    assert float(gain) == pytest.approx(np.exp(0.2))
    assert float(gain_std) == pytest.approx(times * RESTART_STD)
    assert float(zero_std) == pytest.approx(times * 1.5)


def test_single_spikes_of_the_torque_are_no_other_ground() -> None:
    """Two in a thousand samples, as large as the torque's range."""
    made = make_recording(9001, mu=0.5, k=K, load=400.0, bristles=500, duration=14.0)
    rng = np.random.default_rng(9001)
    spikes = (rng.random(made.t.size) < 0.002) * rng.choice([-1, 1], made.t.size) * np.ptp(made.M_z)
    found = run(acquiring_ekf(), made.t, made.psi, made.F_N, made.M_z + spikes)

    assert np.count_nonzero(spikes) >= 2
    assert not (found.status & Status.RESET).any()
    assert found.usable[made.t > 3].mean() > 0.9


@pytest.mark.parametrize(
    ("seed", "mu", "rate", "duration"),
    [(660_004, 0.3, 0.1, 14.0), (5002, 0.05, 0.5, 5.0), (5002, 0.05, 0.5, 14.0)],
)
def test_a_zero_that_drifts_is_never_usable_and_wrong(
    seed: int, mu: float, rate: float, duration: float
) -> None:
    """It drifts [N m/s] beside 2 N m of full slide; on ice, beyond all that a zero may be."""
    made = make_recording(seed, mu=mu, k=K, load=400.0, bristles=500, duration=duration)
    found = run(acquiring_ekf(), made.t, made.psi, made.F_N, made.M_z + rate * made.t)

    assert np.mean(wrong_and_usable(found, mu)) < (0.01 if mu < 0.1 else 1e-9)


def _tracked(*, is_computed: bool = False, var_zero: float = 0.0, **own: float) -> dict[str, float]:
    """The supervision's own numbers after a sample whose torque is predicted while the patch slides."""
    before = dict.fromkeys(OWN, 0.0) | {"scale": 1, "F_N": 400.0, "phase": OVER} | own
    output = dict.fromkeys(OUTPUT, 1.0) | {
        "status": 0,
        "M_z_predicted": 3.0,
        "M_slide": 6.75,
        "nis": 0.1,
    }
    sensing = SteeringTorque() if is_computed else AligningTorque()
    follow = build_tracking_consistency(DECLARED_PATCH, sensing)
    verdict = [var_zero * (name == "var_zero") for name in VERDICT]
    limits = [getattr(Tuning(stiffness_std=0.1), name) for name in SETTINGS]
    given: list[Any] = [[*before.values()], verdict, [*output.values()], 0.1, 0.3, 1e-3]
    after, _ = follow(*given, 3.0, 1e-4, 1, [K, RIG.a, RIG.e], limits, 1)
    return dict(zip(OWN, np.asarray(after).ravel(), strict=True))


def test_a_new_ground_by_the_steering_torque_leaves_the_model_doubted() -> None:
    """A zero that drifts makes torques in a row that differ, too: it is no new ground time and again."""
    predicted = {"scale": 2.0, "predicted": 6.0, "predicted_before": 6.0}
    after = _tracked(is_computed=True, streak=IN_A_ROW - 1, confirmed=PROVED, **predicted)

    assert after["lost"]
    assert after["doubt"] == NEW_GROUND


def test_a_zero_that_was_dragged_does_not_keep_friction_from_being_confirmed_for_ever() -> None:
    predicted = dict.fromkeys(("predicted", "predicted_before"), 3.0)
    known = {"is_computed": True, "weight": 10.0, "lasting": 1.0, **predicted}

    assert _tracked(**known, again=1, var_zero=0.1)["confirmed"] == PROVED
    assert _tracked(**known, again=1)["confirmed"] == 1, "the zero is known"
    assert _tracked(**known, var_zero=0.1)["confirmed"] == 1, "the zero is of the first acquisition"


def test_a_model_that_has_failed_for_long_explains_no_other_ground() -> None:
    """A zero that drifts by 0.1 N m/s is `INCONSISTENT` for seconds, then seems a new ground."""
    made = make_recording(570_001, mu=0.3, k=K, load=400.0, bristles=500, duration=14.0)
    torque = made.M_z + 0.1 * made.t
    found = run(acquiring_ekf(), made.t, made.psi, made.F_N, torque)
    new = np.flatnonzero(found.status & Status.RESET)

    assert new.size > 0
    assert made.t[new[0]] > 7
    assert not found.usable[new[0] :].any()


def test_another_ground_begins_with_the_scale_that_was_found() -> None:
    """A k of 0.8 of the declared one, found before the ground changes, is known at the next handover."""
    made = make_ground_recording(
        680_001, friction_step(6.0, 0.8, 0.3), tyre=RigTyre(a=RIG.a, e=RIG.e, k=0.8 * K, mu=0.8),
        duration=10.0,
    )  # fmt: skip
    own = own_states(made.psi, made.F_N, made.M_z)

    for at in (590, -1):
        assert not own["acquiring"][at]
        assert own["scale"][at] < 0.97


USUAL = Tuning()


def concluded(
    verdict: dict[str, float], output: dict[str, float], M_z: float, again: int = 0,
    tuning: Tuning = USUAL, patch: EquivalentPatch = DECLARED_PATCH,
) -> dict[str, float]:  # fmt: skip
    """The supervision's own numbers after a sample at which friction may be handed over."""
    begun = dict.fromkeys(("acquiring", "phase", "scale"), 1)
    own = dict.fromkeys(OWN, 0.0) | begun | {"F_N": 400.0, "load": 400.0, "again": again}
    found = dict.fromkeys(VERDICT, 0.0) | {"variance": 1e-3, "verified": 1, "wiped": 1} | verdict
    told = dict.fromkeys(OUTPUT, 1.0) | {"status": 0} | output
    conclude = build_acquisition_decision(patch, AligningTorque())
    given: list[Any] = [[*own.values()], [*found.values()], [*told.values()], 0.5, 1, 1, 1, M_z, 0]
    limits = [getattr(tuning, name) for name in SETTINGS]
    after, *_ = conclude(*given, [K, RIG.a, RIG.e], limits, patch.friction)
    return dict(zip(OWN, np.asarray(after).ravel(), strict=True))


@pytest.mark.parametrize(("again", "handed"), [(0, True), (1, False), (2, True)])
def test_another_friction_is_handed_over_where_the_torque_is_predicted(again: int, handed: bool) -> None:
    """The estimator remembers the old ground until its patch slides; a doubted model does not wait."""
    for M_z, expected in ((5.0, handed), (3.2, True), (np.nan, True)):
        own_next = concluded({}, {"M_z_predicted": 3.0, "M_slide": 6.75}, M_z, again)
        assert bool(own_next["acquiring"]) is not expected
        # What had explained nothing is handed over with its doubt.
        assert own_next["doubt"] == (HOPELESS if again == FAILED else 0)


@pytest.mark.parametrize("patch", [DECLARED_PATCH, EquivalentPatch(misfit=0.01)])
@pytest.mark.parametrize(("off", "variance"), [(0.2, 0.0), (0.0, 0.04), (-0.15, 0.01)])
def test_doubt_of_the_scale_widens_the_band(off: float, variance: float, patch: EquivalentPatch) -> None:
    verdict = {"log_gain": off, "var_log_gain": variance}
    after = concluded(verdict, {}, 1, tuning=Tuning(stiffness_std=0.14), patch=patch)

    # Of two pieces of evidence, the torque and the tolerances, the precisions add up.
    known = np.sqrt(1 / (1 / variance + 1 / 0.14**2)) if variance else 0
    # Of the declared model, what is off and its deviation are correlated by half.
    both = np.sqrt(off**2 + known**2 + (0 if patch.misfit else abs(off) * known))
    expected = 0.5 * max(0.0, np.exp(both) - 1 - 0.14 * (0.25 if patch.misfit else 0.5))
    assert after["excess"] == pytest.approx(expected)


def test_the_search_for_the_scale_goes_on_until_friction_is_confirmed() -> None:
    """On ice the deviation of ln s is 0.19 at handover, 0.09 once friction is confirmed."""
    made = make_recording(560_011, mu=0.05, k=1.1 * K, bristles=500, duration=6.0)
    own = own_states(made.psi, made.F_N, made.M_z)
    phase, excess = own["phase"], own["excess"]
    handed, known = int(np.argmin(own["acquiring"])), int(np.argmax(own["confirmed"] == 2))

    assert 0 < handed < known
    assert set(phase[handed:known]) == {0, 1}
    assert excess[known] < 0.8 * excess[handed]
    assert (phase[known:] == OVER).all()
    assert (excess[known:] == excess[known]).all()


@pytest.mark.parametrize("later", [1, 2])
@pytest.mark.parametrize("behind", [0.0, 5e-5])
def test_a_wheel_that_stands_confirms_nothing(behind: float, later: int) -> None:
    """It stops after the handover, as far behind its farthest angle as the angle's noise allows."""
    turned = np.append(np.zeros(20), 0.002 * np.arange(100))

    def own_along(psi: Any) -> dict[str, Any]:
        rows = {"psi": psi, "psi_dot": 0 * psi, "F_N": 400 + 0 * psi, "dt": 0.01 + 0 * psi}
        theta = np.asarray(Model().theta({"mu": 0.5, "k": K})).ravel()
        signals = np.vstack([rows[name] for name in SIGNALS])
        M_z = simulate(Model(), signals, theta, np.array([RIG.a, RIG.e])).M_z
        return own_states(psi, rows["F_N"], M_z)

    handed = int(np.argmin(own_along(turned)["acquiring"]))
    stop = handed + later
    stands = np.concatenate([turned[: stop + 1], np.full(300, turned[stop] - behind)])
    weight = own_along(stands)["weight"]
    assert 0 < weight[stop] < 1
    assert weight[-1] - weight[stop] < 0.5


def test_of_the_noise_a_smoothed_innovation_has_a_part() -> None:
    """An exponential average over n samples leaves 1 / (2 n - 1) of the variance of white noise.

    Three times that is allowed.
    """
    tuning = Tuning(error=1e-6)
    names = ("own", "output", "M_z", "interval", "added", "tyre", "limits")
    own = dict.fromkeys(OWN, 0.0) | {"scale": 1, "F_N": 400.0}
    output = dict.fromkeys(OUTPUT, 0.0)
    limits = [getattr(tuning, name) for name in SETTINGS]

    def tested(lasting: float) -> tuple[bool, bool]:
        values = ({**own, "lasting": lasting}, output, lasting, 0.01, 0.3**2, [K, 0.045, 0.009], limits)
        inputs = dict(zip(names, map(ca.DM, (0, 0, *values[2:])), strict=True))
        _, beyond, clear = smoothed_innovation_test(inputs, values[0], values[1], ca.DM(0))
        return bool(beyond), bool(clear)

    limit = 0.3 * np.sqrt(3 / (2 * 10 - 1))
    assert tested(0.98 * 0.7 * limit) == (False, True)
    assert tested(1.02 * 0.7 * limit) == tested(0.98 * 3 * limit) == (False, False)
    assert tested(1.02 * 3 * limit) == (True, False)
