import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from observers import Ekf, Plan, SteeringLimits, plan, profile, run
from observers.planning.forecast import Forecaster
from observers.planning.plan import _PathSearch
from observers.planning.steering_limits_and_paths import fastest_path
from symbolic import InvalidInputError
from tests.observers.planning.conftest import LOAD, observe_on_rig

pytestmark = pytest.mark.usefixtures("optimised")
LIMITS = SteeringLimits(angle=0.3, rate=0.4, time=6.0)


@pytest.fixture(scope="module")
def planned(acquiring: Ekf) -> Plan:
    """Without noise, which takes seven eighths of the time and is in other tests."""
    return plan(acquiring, 0.05, LIMITS, LOAD, mus=(0.1, 0.8), coarse=True, quiet=True)


def test_a_plan_stays_within_the_limits(planned: Plan) -> None:
    path = planned.path

    assert np.abs(path.psi).max() <= LIMITS.angle
    assert LIMITS.slowest <= np.abs(path.psi_dot).max() <= LIMITS.rate
    assert path.t[-1] <= LIMITS.time
    assert planned.reasons == ()
    assert planned.turning_points[-1] == path.psi[-1]
    # It ends soon after the last ground is known.
    assert path.travel[-1] == pytest.approx(1.1 * planned.travels_to_target.max(), rel=0.05)


@pytest.mark.long
@pytest.mark.parametrize("torque", [1.0, 1.2])
def test_a_path_that_reaches_no_more_ends_where_the_torque_is_too_great(
    torque: float, acquiring: Ekf, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("observers.planning.forecast.MOST_NOISE", 0.0)
    limits = SteeringLimits(angle=0.3, rate=0.4, time=6.0, torque=torque)
    planned = plan(acquiring, 0.076, limits, LOAD, mus=(0.06, 0.9), coarse=True)
    (ice, dry), most = planned.reached, np.abs(planned.forecasts[1].torque)
    assert ice is not None
    assert dry is None
    assert 0 < planned.path.t[-1] < limits.time

    # Ice needs more than 1 N m on the other ground, and the plan says so; beyond, no limit is exceeded.
    assert most[ice + 1 :].max(initial=0.0) <= torque
    first = planned.path.t[np.argmax(most > torque)] if torque == 1.0 else planned.path.t[-1] + 0.01
    (said,) = re.findall(r"beyond the limit of the torque from (.*?) s on", planned.reasons[-1])
    assert float(said) == pytest.approx(first, rel=5e-3)
    assert "turn on" not in planned.reasons[-1]
    assert (most.size == ice + 1) == (torque == 1.0)
    assert (planned.path.travel[-1] > 1.5 * planned.path.travel[ice]) == (torque == 1.2)


@pytest.mark.long
def test_a_stricter_target_never_needs_less_on_the_worst_ground(acquiring: Ekf, planned: Plan) -> None:
    looser = [
        plan(acquiring, target, LIMITS, LOAD, mus=(0.1, 0.8), coarse=True, quiet=True)
        for target in (0.08, 0.06)
    ]
    travels = [one.travels_to_target.max() for one in (*looser, planned)]

    assert travels == sorted(travels)


def test_on_the_rig_the_target_is_reached_where_planned(acquiring: Ekf, planned: Plan) -> None:
    for mu, travel in zip(planned.mus, planned.travels_to_target, strict=True):
        estimates, _ = observe_on_rig(acquiring, planned.path, mu)
        good = [one.usable and one.mu_std <= 0.0505 * one.mu for one in estimates]

        # Without noise it is sooner.
        assert 0.6 * travel < planned.path.travel[good.index(True)] <= travel + 0.01
        assert (
            max(abs(one.mu / mu - 1) for one, known in zip(estimates, good, strict=True) if known) < 0.05
        )


def test_turning_back_tells_ice_sooner_than_turning_on(acquiring: Ekf) -> None:
    forecaster = Forecaster(acquiring)
    case = forecaster.cases_at_rest([0.05], 0.0, LOAD, 0.01)[0]
    on, back = (
        fastest_path([0.0, *points], 0.12, 10.0, 0.01, 6.0) for points in ([0.6], [0.03, -0.05, 0.08])
    )

    # The zero of the torque looks like friction until the wheel has turned back.
    assert forecaster.forecast_whole(on, case, LOAD).first_within(0.07) is None
    assert forecaster.forecast_whole(back, case, LOAD).first_within(0.07) is not None


@pytest.mark.long
@pytest.mark.parametrize(
    "seed", [pytest.param(n, marks=() if n in (1, 2, 3) else pytest.mark.long) for n in range(6)]
)
def test_a_wider_limit_never_makes_the_plan_worse(acquiring: Ekf, seed: int) -> None:
    rng = np.random.default_rng(seed)
    tight = {
        name: float(rng.uniform(*bounds))
        for name, bounds in {
            "angle": (0.01, 0.2), "rate": (0.2, 1.0), "slowest": (0.05, 0.1), "torque": (0.5, 6.0),
            "time": (0.5, 3.0), "acceleration": (1.0, 5.0),
        }.items()
    }  # fmt: skip
    wider = rng.choice([1.0, 1.3, 2.0], len(tight))
    relaxed = {
        name: value / by if name == "slowest" else value * by
        for (name, value), by in zip(tight.items(), wider, strict=True)
    }
    mus, objective = ((0.05, 0.8), (0.4,), (0.1, 1.2))[seed % 3], ("travel", "time", "angle")[seed // 2]
    costs = []
    for limits in (tight, relaxed):
        found = plan(
            acquiring, 0.05, SteeringLimits(**limits), LOAD, mus=mus, objective=objective, coarse=True
        )  # type: ignore[call-overload]
        of = {"travel": found.path.travel, "time": found.path.t}
        along = of.get(objective, np.maximum.accumulate(np.abs(found.path.psi)))
        ends = [along[at] for at in found.reached if at is not None]
        least = [one.deviations_or_inf(limits["torque"]).min() for one in found.forecasts]
        costs.append((len(found.reasons), max(np.minimum(least, 1) if found.reasons else ends)))

    assert costs[1] <= costs[0]


@pytest.mark.long
def test_time_and_angle_may_be_least(acquiring: Ekf) -> None:
    given = {"mus": (0.8,), "coarse": True}
    quick = plan(acquiring, 0.05, LIMITS, LOAD, objective="time", **given)
    narrow = plan(acquiring, 0.05, LIMITS, LOAD, objective="angle", over="mean", **given)

    assert quick.path.t[-1] < narrow.path.t[-1]
    assert np.abs(narrow.path.psi).max() < np.abs(quick.path.psi).max()


def test_a_path_needs_samples(acquiring: Ekf) -> None:
    with pytest.raises(InvalidInputError, match=r"limit time must be at least 0\.1 s"):
        plan(acquiring, 0.05, SteeringLimits(time=0.05), LOAD)


@pytest.mark.parametrize(
    ("target", "limits", "words"),
    [
        (0.05, {"torque": 2.0}, "; twice the limit of torque would do"),
        (0.05, {"time": 0.7}, "never usable on the best path; twice the limit of time would do"),
        (0.05, {"angle": 0.008, "time": 1.0}, "no limit alone, twice as wide, would do: friction is"),
    ],
)
def test_what_cannot_be_reached_is_told(
    acquiring: Ekf, target: float, limits: dict[str, float], words: str
) -> None:
    limited = SteeringLimits(**{"angle": 0.3, "rate": 0.4, "time": 3.0} | limits)
    told = plan(acquiring, target, limited, LOAD, mus=(0.8,), coarse=True)

    assert told.reached == (None,)
    assert np.isnan(told.travels_to_target).all()
    assert len(told.reasons) == 1
    assert words in told.reasons[0]


def test_a_target_that_no_ground_can_reach_is_refused_before_a_path_is_tried(acquiring: Ekf) -> None:
    tried: list[int] = []
    with pytest.raises(
        InvalidInputError, match=r"mu = 0\.8: 2\.0% cannot be reached by any steering: tol"
    ):
        plan(acquiring, 0.02, LIMITS, LOAD, mus=(0.1, 0.8), progress=lambda *now: tried.append(now[1]))

    assert not tried


def test_a_target_within_reach_without_noise_alone_is_told_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "observers.planning.plan.largest_uncertainty_part", lambda *_: ("noise", 0.04, 0.01)
    )
    search = SimpleNamespace(
        limits=SteeringLimits(angle=0.3), is_reached_with_wider_limits=lambda *_, **__: False,
        target=0.05, forecaster=SimpleNamespace(observer=None), F_N=LOAD,
    )  # fmt: skip
    forecast = SimpleNamespace(
        least_deviation_index=lambda _: 0, samples_within_torque_limit=lambda _: 1,
        torque=np.zeros(1), status=[0], deviation=[0.049],
    )  # fmt: skip
    told = _PathSearch.unreached_text(search, 0.05, SimpleNamespace(t=[10.0]), forecast, 3)

    assert told.startswith(
        "4.9% without noise, after 10 s, but within 5.0% in 3 of 20 runs with noise; "
    )
    forecast.deviation = [0.06]
    told = _PathSearch.unreached_text(search, 0.05, SimpleNamespace(t=[10.0]), forecast, 0)
    assert told.startswith("6.0% at best, after 10 s; its largest part is noise, 4.0%; ")


def test_a_reason_without_a_flag_ends_in_words() -> None:
    search = SimpleNamespace(
        limits=SteeringLimits(angle=0.3), is_reached_with_wider_limits=lambda *_, **__: False
    )
    forecast = SimpleNamespace(
        least_deviation_index=lambda _: None, samples_within_torque_limit=lambda _: 1,
        torque=np.zeros(1), status=[0],
    )  # fmt: skip

    assert _PathSearch.unreached_text(search, 0.8, None, forecast, 0).endswith("twice as wide, would do")


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"target": 0.0}, "target must be a share"),
        ({"target": 1.0}, "target must be a share"),
        ({"mus": ()}, "frictions must be"),
        ({"mus": (0.001,)}, "frictions must be"),
        (
            {"limits": SteeringLimits(rate=0.06)},
            "limit rate must be at least 0.1 rad/s and acceleration 0.5",
        ),
        ({"F_N": float("nan")}, "load must be greater than 0"),
    ],
)
def test_bad_arguments_are_refused(acquiring: Ekf, given: dict[str, object], words: str) -> None:
    usual = {"target": 0.05, "limits": LIMITS, "F_N": LOAD}
    with pytest.raises(InvalidInputError, match=words):
        plan(acquiring, **usual | given)


@pytest.mark.long
def test_the_deviation_shown_where_a_target_is_reached_is_usable_and_within_it(acquiring: Ekf) -> None:
    observer = replace(acquiring, tuning=profile("real_tyre"))
    told = plan(observer, 0.15, LIMITS, LOAD, mus=(0.1, 0.9), coarse=True)

    assert told.reasons == ()
    for at, forecast in zip(told.reached, told.forecasts, strict=True):
        assert forecast.deviations_or_inf(np.inf)[at] <= 0.15


@pytest.mark.long
def test_with_noise_friction_is_known_at_the_end_of_a_plan(acquiring: Ekf) -> None:
    rig = replace(acquiring.rig, noise=0.07)
    observer, rng = replace(acquiring, rig=rig), np.random.default_rng(7)
    planned = plan(observer, 0.08, LIMITS, LOAD, mus=(0.1, 0.8), coarse=True)

    assert planned.reasons == ()
    path = planned.path
    for mu, at in zip(planned.mus, planned.reached, strict=True):
        assert at is not None
        torque, known = observe_on_rig(observer, path, mu)[1], 0
        for _ in range(20):
            noisy = torque + 0.07 * rng.standard_normal(torque.size)
            one = run(observer, path.t, path.psi, LOAD, noisy)
            known += bool((one.usable & (one.mu_std <= 0.08 * one.mu)).any())
        assert known >= 17


@pytest.mark.long
def test_a_target_close_to_what_no_steering_lowers_is_tried_on_few_paths_and_has_a_cause(
    acquiring: Ekf,
) -> None:
    tried: list[tuple[int, int]] = []
    told = plan(acquiring, 0.033, LIMITS, LOAD, mus=(0.1,), progress=lambda *now: tried.append(now[1:]))

    assert [done for done, _ in tried] == [*range(tried[0][1])]
    assert len(tried) < 200
    (reason,) = told.reasons
    assert "% at best, after 6 s; its largest part is tolerances of half-length and caster, 2" in reason
    assert reason.endswith("; all that no measurement lowers is 3.26%: ask for well above that")
