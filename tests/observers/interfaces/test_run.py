"""Whole recordings: sample by sample and at once, causal, with gaps, whatever is missing."""

from dataclasses import fields
from math import inf, nan
from typing import Any

import numpy as np
import pytest

from observers import AligningTorque, Ekf, Estimates, Mhe, RootObserver, Status, SteeringTorque, run
from reference_rig import RigRecording, SteeringRecording
from symbolic import Model
from symbolic.float_array_type import Array
from tests.interpreted import without_machine_code
from tests.observers.conftest import RIG, K, make
from tests.observers.factories import FIELDS, assert_steps_are_the_run, columns_of, samples_of
from tests.refusal import refused

OBSERVERS: dict[str, Any] = {
    "ekf": make(Ekf),
    "ekf, stiffness": make(Ekf, measurement_model=AligningTorque(stiffness=True)),
    "ekf, bristles": make(Ekf, model=Model(discretised=True)),
    "ekf, steering": make(Ekf, measurement_model=SteeringTorque()),
    "mhe": make(Mhe, window=20),
    "mhe, stiffness": make(Mhe, window=20, measurement_model=AligningTorque(stiffness=True)),
    "mhe, steering": make(Mhe, window=20, measurement_model=SteeringTorque()),
    "root": RootObserver(rig=RIG, k=K),
}


LONG = ("ekf, stiffness", "mhe", "mhe, stiffness", "mhe, steering")
"""The states of these are among those of the others, whose compiling takes long enough."""
MARKED = [pytest.param(n, marks=pytest.mark.long if n in LONG else ()) for n in OBSERVERS]


@pytest.fixture(params=MARKED)
def observer(request: pytest.FixtureRequest) -> Any:
    return OBSERVERS[request.param]


@pytest.fixture
def columns(observer: Any, recording: RigRecording, steered: SteeringRecording) -> dict[str, Array]:
    """What suits the observer, of a length that is no multiple of a stretch."""
    steers = isinstance(getattr(observer, "measurement_model", None), SteeringTorque)
    made = steered if steers else recording
    return columns_of(made, slice(0, 777 if steers else 333))


def changed(columns: dict[str, Array], name: str, at: Any, value: float) -> dict[str, Array]:
    column = columns[name].copy()
    column[at] = value
    return {**columns, name: column}


def torque_of(columns: dict[str, Array]) -> str:
    return "M_z" if "M_z" in columns else "M"


def test_sample_by_sample_is_the_same(observer: Any, columns: dict[str, Array]) -> None:
    assert_steps_are_the_run(observer, columns)


def test_machine_code_says_what_the_interpreter_says(
    observer: Any, columns: dict[str, Array], monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = run(observer, **columns), run(observer, **columns, one_by_one=True)
    without_machine_code(monkeypatch)
    interpreter = run(observer, **columns), run(observer, **columns, one_by_one=True)

    for one, other in zip(machine, interpreter, strict=True):
        for name in FIELDS:
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-9)


@pytest.mark.parametrize("count", [2, 100, 101, 250])
def test_no_row_depends_on_later_samples(observer: Any, columns: dict[str, Array], count: int) -> None:
    whole = run(observer, **columns)
    part = run(observer, **{name: column[:count] for name, column in columns.items()})

    for name in ("t", *FIELDS):
        np.testing.assert_array_equal(getattr(part, name), getattr(whole, name)[:count])


@pytest.mark.parametrize("missing", [{"psi"}, {"F_N"}, {"psi", "F_N", "torque"}])
@pytest.mark.parametrize("nothing", [nan, inf])
def test_until_the_patch_is_seen_the_prior_stands(
    observer: Any, columns: dict[str, Array], missing: set[str], nothing: float
) -> None:
    cut = {name: column[7:] for name, column in columns.items()}
    for name in missing:
        columns = changed(columns, torque_of(columns) if name == "torque" else name, slice(7), nothing)
    estimates, later = run(observer, **columns), run(observer, **cut)

    prior = observer.tuning if hasattr(observer, "tuning") else None
    np.testing.assert_array_equal(estimates.mu[:7], 1.0)
    np.testing.assert_array_equal(estimates.mu_std[:7], prior.mu_std if prior else nan)
    assert np.isnan(estimates.M_z_predicted[:7]).all()
    assert not estimates.informed[:7].any()
    np.testing.assert_array_equal(estimates.status[:7], int(Status.MISSING))
    for name in FIELDS:
        np.testing.assert_allclose(getattr(estimates, name)[7:], getattr(later, name), atol=1e-12)


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
def test_a_torque_at_100_hz_tells_as_much_in_a_loop_of_1_khz(recording: RigRecording, kind: Any) -> None:
    """It counts for the time and the turn since the one before; in between, torques are missing."""
    columns = columns_of(recording, slice(0, 600))
    t = np.linspace(columns["t"][0], columns["t"][-1], 10 * 599 + 1)
    angle, load = (np.interp(t, columns["t"], columns[name]) for name in ("psi", "F_N"))
    M_z = np.full(t.size, nan)
    M_z[::10] = columns["M_z"]
    usual = run(make(kind, acquire=True), **columns)
    rare = run(make(kind, acquire=True), t=t, psi=angle, F_N=load, M_z=M_z)

    assert np.argmax(rare.usable[::10]) == pytest.approx(np.argmax(usual.usable), abs=40)
    both = usual.usable & rare.usable[::10]
    assert np.count_nonzero(both) > 0.9 * np.count_nonzero(usual.usable) > 100
    np.testing.assert_allclose(rare.mu_std[::10][both], usual.mu_std[both], rtol=0.1)
    np.testing.assert_allclose(rare.mu[::10][both], usual.mu[both], rtol=0.02)


def test_times_need_not_begin_at_zero(observer: Any, columns: dict[str, Array]) -> None:
    estimates = run(observer, **columns)
    shifted = run(observer, **{**columns, "t": columns["t"] + 1e3})

    np.testing.assert_allclose(shifted.mu, estimates.mu, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(shifted.t, columns["t"] + 1e3)


def test_rate_may_be_given(recording: RigRecording) -> None:
    columns = columns_of(recording, slice(0, 200))
    found = np.array([s.psi_dot for s in samples_of(columns)])
    model = Model(discretised=True)
    for observer in (make(Ekf), make(Ekf, model=model)):
        given = run(observer, **columns, psi_dot=found)
        np.testing.assert_array_equal(given.mu, run(observer, **columns).mu)


@pytest.mark.parametrize("kind", [Ekf, Mhe])
def test_status_of_every_sample(recording: RigRecording, kind: Any) -> None:
    columns = changed(columns_of(recording, slice(0, 120)), "M_z", 50, nan)
    columns = changed(changed(columns, "psi", 60, nan), "F_N", 70, -1.0)
    status = run(make(kind, window=20) if kind is Mhe else make(kind), **columns).status
    flags = {i: Status(int(status[i])) for i in np.flatnonzero(status & ~int(Status.UNSETTLED))}

    assert status.dtype == np.int64
    missing_and_held = Status.MISSING | Status.HELD
    assert flags == {50: Status.MISSING, 60: missing_and_held, 70: missing_and_held}


@pytest.mark.parametrize("kind", [Ekf, pytest.param(Mhe, marks=pytest.mark.long)])
@pytest.mark.parametrize("load", [0.03, 1e-3, 1e-170, 5.0])
def test_a_load_of_nothing_leaves_friction_alone(
    recording: RigRecording, kind: Any, load: float
) -> None:
    observer, columns, light = make(kind), columns_of(recording, slice(0, 900)), slice(700, 720)
    faulty = run(observer, **changed(columns, "F_N", light, load))
    without = run(observer, **changed(changed(columns, "F_N", light, nan), "M_z", light, nan))
    whole = run(observer, **columns)

    np.testing.assert_array_equal(faulty.mu, without.mu)
    np.testing.assert_array_equal(faulty.mu_std, without.mu_std)
    np.testing.assert_allclose(faulty.mu, whole.mu, rtol=0, atol=2e-3)
    assert not (faulty.status & (Status.RESET | Status.REJECTED | Status.BOUND)).any()


@pytest.mark.parametrize(
    ("change", "word"),
    [
        (lambda c: {"M_z": c["M_z"][1:]}, "M_z must have the shape of t"),
        (lambda c: {"psi": c["psi"].reshape(1, -1)}, "psi must have the shape of t"),
        (lambda c: {"M": c["M_z"][:2]}, "M must have the shape of t"),
        (lambda c: {"psi_dot": c["psi"][1:]}, "psi_dot must have the shape of t"),
        (lambda c: {n: column[:1] for n, column in c.items()}, "n >= 2"),
        (lambda c: {n: column[:0] for n, column in c.items()}, "n >= 2"),
        (lambda c: {"t": c["t"][::-1]}, "t must increase"),
        (lambda c: {"t": np.zeros_like(c["t"])}, "t must increase"),
        (lambda c: {"t": np.where(c["t"] == 0.03, nan, c["t"])}, "t must increase"),
        (lambda c: {"t": np.where(c["t"] == c["t"][-1], inf, c["t"])}, "t must"),
        (lambda c: {"t": np.where(c["t"] == c["t"][0], -inf, c["t"])}, "t must"),
        (lambda _: {"M_z": None}, "this observer needs M_z"),
        (lambda c: {"psi": np.full_like(c["t"], nan)}, "in at least one sample"),
        (lambda c: {"F_N": np.full_like(c["t"], inf)}, "in at least one sample"),
        (lambda c: {"F_N": -c["F_N"]}, "in at least one sample"),
    ],
)
def test_faults_of_a_recording(recording: RigRecording, change: Any, word: str) -> None:
    columns: dict[str, Any] = columns_of(recording, slice(0, 50))
    assert word in refused(run, make(Ekf), **{**columns, **change(columns)})


def test_a_notebook_shows_estimates_as_a_line() -> None:
    made, none = (
        Estimates(**{field.name: np.array(numbers) for field in fields(Estimates)})
        for numbers in ([0.5, 0.7], [])
    )

    assert repr(made) == "<Estimates of 2 samples to 0.7 s: mu 0.700 ± 0.700 at the end, informed>"
    assert repr(none) == "<Estimates of no sample>"
