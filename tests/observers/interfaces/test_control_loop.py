"""The stateful wrapper says what `run` says; a late measurement ends where a punctual one does."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from observers import Ekf, Estimate, Loop, Observer, RootObserver, Sample, Status, causal_rate, run
from reference_rig import RigRecording
from symbolic import InvalidInputError, Model
from tests.observers.conftest import RIG, K
from tests.observers.factories import MODEL_OBSERVERS, SampleRecorder

pytestmark = pytest.mark.usefixtures("interpreted")

COUNT = 120
OBSERVERS: dict[str, Callable[[], Observer]] = {
    **MODEL_OBSERVERS,
    "root": lambda: RootObserver(rig=RIG, k=K),
}


@pytest.fixture(params=OBSERVERS)
def observer(request: pytest.FixtureRequest) -> Observer:
    return OBSERVERS[request.param]()


def samples_of(made: RigRecording, begin: int = 100) -> list[Sample]:
    """Samples of a recording where it turns, without a yaw rate; the wheel's torque is made up."""
    chosen = slice(begin, begin + COUNT)
    dt = float(made.t[1] - made.t[0])
    return [
        Sample(psi=psi, psi_dot=np.nan, F_N=F_N, dt=dt, M_z=M_z, M=-M_z)
        for psi, F_N, M_z in zip(made.psi[chosen], made.F_N[chosen], made.M_z[chosen], strict=True)
    ]


def fed(observer: Observer, samples: list[Sample], **settings: Any) -> Loop:
    loop = Loop(observer, **settings)
    for sample in samples:
        loop(sample)
    return loop


def test_what_is_not_usable_has_a_remedy(observer: Observer, recording: RigRecording) -> None:
    loop = Loop(observer)
    estimates = [loop(sample) for sample in samples_of(recording)]
    wide = Estimate(mu=2.0, mu_std=0.6, M_z_predicted=0.0, informed=False)

    assert [not now.remedy for now in estimates] == [now.usable for now in estimates]
    assert wide.remedy.startswith("the deviation of mu is 30 % of mu")
    assert replace(wide, mu_std=np.nan).remedy.startswith("the patch has not slid far enough")
    assert replace(wide, status=Status.SUSPECT).remedy == Status.SUSPECT.remedy
    assert replace(wide, informed=True).remedy == ""


def assert_same(one: Any, other: Any) -> None:
    """The states hold the same numbers."""
    if hasattr(one, "values"):
        np.testing.assert_array_equal(one.values, other.values)
    else:
        assert repr(one) == repr(other)


def test_says_what_a_run_says(observer: Observer, recording: RigRecording) -> None:
    samples = samples_of(recording)
    samples[5:8] = [replace(sample, psi=np.nan) for sample in samples[5:8]]
    samples[20:23] = [replace(sample, M_z=np.nan, M=np.nan) for sample in samples[20:23]]
    loop = Loop(observer)
    said = [loop(sample) for sample in samples]

    names = ("psi", "F_N", "M_z", "M")
    columns = {name: np.array([getattr(s, name) for s in samples]) for name in names}
    t = np.arange(COUNT) * samples[0].dt
    made = run(observer, t, columns["psi"], columns["F_N"], columns["M_z"], M=columns["M"])
    for name in ("mu", "mu_std", "M_z_predicted", "informed", "status"):
        expected = getattr(made, name)
        np.testing.assert_allclose([getattr(now, name) for now in said], expected, atol=1e-9, rtol=0)


def test_a_yaw_rate_that_is_measured_is_used(recording: RigRecording) -> None:
    observer = Ekf(model=Model(), values={"k": K}, rig=RIG, acquire=False)
    first, second, *_ = samples_of(recording)
    loop = fed(observer, [first, replace(second, psi_dot=0.25)])
    expected = observer.step(observer.init(first), replace(first, psi_dot=0.0))

    assert_same(loop.state, observer.step(expected, replace(second, psi_dot=0.25)))


@pytest.mark.parametrize("fault", [{"psi": np.nan}, {"F_N": np.nan}, {"F_N": 0.0}, {"F_N": np.inf}])
def test_starts_at_the_first_usable_sample(
    observer: Observer, recording: RigRecording, fault: dict[str, float]
) -> None:
    useless, *samples = samples_of(recording)
    loop = Loop(observer)
    before = loop(replace(useless, **fault))
    prior = observer.estimate(observer.init(useless))

    assert loop.state is None
    assert before.status == Status.MISSING
    assert before.mu == prior.mu
    assert not before.informed
    np.testing.assert_array_equal(before.mu_std, prior.mu_std)

    loop(samples[0])
    assert loop.state is not None


def test_reset_forgets_everything(observer: Observer, recording: RigRecording) -> None:
    samples = samples_of(recording)
    loop = fed(observer, samples)
    loop.reset()

    assert loop.state is None
    for sample in samples[:20]:
        loop(sample)
    assert_same(loop.state, fed(observer, samples[:20]).state)


@pytest.mark.parametrize("age", [0, 1, 7, 49])
@pytest.mark.parametrize("channel", ["M_z", "M", "psi"])
def test_late_is_as_good_as_in_time(
    observer: Observer, recording: RigRecording, channel: str, age: int
) -> None:
    samples = samples_of(recording)
    at = COUNT - 1 - age
    without = [*samples[:at], replace(samples[at], **{channel: np.nan}), *samples[at + 1 :]]
    loop, punctual = fed(observer, without), fed(observer, samples)
    now = loop.late(age, **{channel: getattr(samples[at], channel)})

    assert_same(loop.state, punctual.state)
    assert repr(now) == repr(observer.estimate(punctual.state))


def test_a_sensor_that_is_always_late(recording: RigRecording) -> None:
    observer, samples, lag = OBSERVERS["ekf"](), samples_of(recording), 4
    loop = Loop(observer, history=lag + 1)
    for i, sample in enumerate(samples):
        loop(replace(sample, M_z=np.nan))
        if i >= lag:
            loop.late(lag, M_z=samples[i - lag].M_z)
    heard = [*samples[:-lag], *(replace(sample, M_z=np.nan) for sample in samples[-lag:])]

    assert_same(loop.state, fed(observer, heard).state)


def test_nan_takes_a_measurement_back(recording: RigRecording) -> None:
    observer, samples = OBSERVERS["ekf"](), samples_of(recording)
    wrong, lost = (
        fed(observer, [*samples[:-3], replace(samples[-3], M_z=M_z), *samples[-2:]])
        for M_z in (50.0, np.nan)
    )
    wrong.late(2, M_z=np.nan)

    assert_same(wrong.state, lost.state)


def test_a_late_angle_may_start_the_loop(observer: Observer, recording: RigRecording) -> None:
    samples = samples_of(recording)[:20]
    loop = fed(observer, [replace(samples[0], psi=np.nan), *samples[1:]])
    loop.late(19, psi=samples[0].psi)

    assert_same(loop.state, fed(observer, samples).state)


def test_refuses_what_it_cannot_place(recording: RigRecording) -> None:
    observer, samples = OBSERVERS["ekf"](), samples_of(recording)
    loop = fed(observer, samples, history=10)

    for age in (10, -1, 2.0):
        with pytest.raises(InvalidInputError, match=r"age must be a whole number from 0 to 9, .* got"):
            loop.late(age, M_z=1.0)  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError, match="needs one of M_z, M, psi"):
        loop.late(3)
    with pytest.raises(InvalidInputError, match="no sample is kept yet"):
        Loop(observer).late(0, M_z=1.0)
    loop.late(np.int64(3), M_z=1.0)  # type: ignore[arg-type]


@pytest.mark.parametrize("history", [0, -1, 2.5, None])
def test_history_is_a_whole_number(history: Any) -> None:
    with pytest.raises(InvalidInputError, match="history must be a whole number of at least 1"):
        Loop(OBSERVERS["ekf"](), history=history)


@pytest.mark.parametrize("absent", [np.nan, np.inf, -np.inf, 1e12])
def test_an_absent_rate_is_the_causal_one_also_through_gaps_of_the_angle(absent: float) -> None:
    rng = np.random.default_rng(3)
    dt = rng.uniform(0.005, 0.02, 60)
    t, psi = np.cumsum(dt), 0.7 + 0.2 * np.sin(np.arange(60) / 7)
    psi[20:23] = psi[40] = np.nan
    rows = zip(psi, dt, strict=True)
    samples = [Sample(psi=p, psi_dot=absent, F_N=400.0, dt=step) for p, step in rows]
    recorder, known = SampleRecorder(), np.isfinite(psi)
    fed(recorder, samples)

    rates = np.array([sample.psi_dot for sample in recorder.samples])
    expected = causal_rate(t[known], psi[known])
    np.testing.assert_allclose(rates[known], expected, rtol=1e-12, atol=1e-12)
    # While the angle is missing the last rate stands.
    np.testing.assert_array_equal(rates[20:23], rates[19])
    assert rates[0] == 0.0
