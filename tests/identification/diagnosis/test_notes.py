"""What is said beside the figures: every recording that got worse, every parameter at its bound."""

import re
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from identification import Recording, Standstills, diagnose
from identification.diagnosis.found_vs_declared_stiffness import (
    StiffnessComparison,
    compare_fitted_stiffness,
    compare_stiffness,
    stiffness_note,
)
from identification.diagnosis.graded_effects import final_model_notes
from identification.diagnosis.result_parts import TorqueErrors
from identification.fits.fitting import Fit, parameters_at_bounds
from identification.fits.values_by_ground_and_recording import ParameterEstimate, Values
from symbolic import Model, Rig, Tolerances, effects_named
from tests.identification.factories import read_campaign, recording

pytestmark = pytest.mark.usefixtures("interpreted")


def errors(left_out: dict[str, float] | None = None, **nrmse: float) -> TorqueErrors:
    each = {"rmse": nrmse, "nrmse": nrmse, "left_out": left_out or {}}
    return TorqueErrors(training=tuple(nrmse), holdout=(), **each)


def _recording(a: float = 0.045, e: float = 0.009) -> Recording:
    return recording("a", rig=Rig(a=a, e=e), k=2.4e6)


@pytest.fixture
def fitted() -> Fit:
    return Fit(
        prior_weights=np.zeros(3),
        prior_steps=np.zeros(3),
        model=Model(effects=effects_named(("contact_length", "sensor_delay"))),
        values=Values(
            tyre={"k": 2e6, "contact_length.n": 0.4, "sensor_delay.delay": 0.02}, own={"a": {"mu": 1.0}}
        ),
        residuals={},
        jacobian=np.zeros((0, 3)),
        labels=((None, "k"), (None, "contact_length.n"), (None, "sensor_delay.delay")),
        scales=np.ones(3),
        bound_distances=np.array([[-1.0], [1.0]]) * np.ones(3),
        status="converged",
        converged=True,
    )


def test_every_recording_that_got_worse_and_no_other(fitted: Fit) -> None:
    before = errors({"a": 0.04, "b": 0.03}, a=0.04, b=0.03, c=0.01)
    after = errors({"a": 0.041, "b": 0.02}, a=0.02, b=0.031, c=0.012)

    assert final_model_notes(before, after, fitted) == (
        "b got worse: 3.00% of range before, 3.10% after",
        "c got worse: 1.00% of range before, 1.20% after",
        "a got worse when left out: 4.00% of range before, 4.10% after",
    )
    assert final_model_notes(errors(a=0.04, b=0.03), errors(a=0.02, b=0.03), fitted) == ()


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("contact_length.n", 1.0, "contact_length: n is at the end of its range, 1, so"),
        ("sensor_delay.delay", 0.15, "sensor_delay: delay is at the end of its range, 0.15 s, so"),
        ("sensor_delay.delay", 0.0, None),
    ],
    ids=["share", "delay", "neutral"],
)
def test_parameter_at_its_bound(fitted: Fit, name: str, value: float, said: str | None) -> None:
    values = replace(fitted.values, tyre={**fitted.values.tyre, name: value})

    notes = final_model_notes(errors(a=0.04), errors(a=0.02), replace(fitted, values=values))

    assert [note.partition(", so")[0] + ", so" for note in notes] == [said] * (said is not None)
    ended = [name.split(".")] * (said is not None)
    assert [[*one[:2]] for one in parameters_at_bounds(replace(fitted, values=values))] == ended


@pytest.mark.parametrize(
    ("name", "value", "told"),
    [
        ("a", 0.047, "a is at the end of its tolerance, 0.047 m"),
        (
            "growth_share",
            1.87,
            "growth_share (growth of the wheels' torque towards the locks over",
        ),
    ],
)
def test_a_value_at_the_end_of_its_tolerance_in_a_validation_recording(
    fitted: Fit, name: str, value: float, told: str
) -> None:
    values = replace(fitted.values, rig={"c": {name: value}})
    own = replace(
        fitted, labels=(("c", name),), prior_weights=np.ones(1), values=values,
        bound_distances=np.array([[-2.0], [0.0]]), prior_steps=np.zeros(1), scales=np.ones(1),
    )  # fmt: skip

    notes = final_model_notes(errors(a=0.04), errors(a=0.02), fitted, own=[own])

    (note,) = notes
    assert note.startswith(f"c: {told}")


def _lengths(fitted: Fit, *found: float, end: float = 0.0475, declared: float = 0.05) -> Fit:
    """Of recordings that want such half-lengths, in units of a millimetre."""
    names = "bcde"[: len(found)]
    off = [1e3 * (a - declared) for a in found]
    return replace(
        fitted, labels=tuple((name, "a") for name in names), prior_weights=np.ones(len(found)),
        values=replace(fitted.values, rig=dict(zip(names, ({"a": a} for a in found), strict=True))),
        bound_distances=np.array([[1e3 * (end - a), 1.0] for a in found]).T,
        prior_steps=np.array(off), scales=np.full(len(found), 1e-3),
        residuals={name: np.zeros(1) for name in names},
    )  # fmt: skip


ALL = "all 3 recordings want a less than the declared 0.05 m, 0.048 m or beyond: measure it"
ENDED = "b: a is at the end of its tolerance, 0.0475 m"


@pytest.mark.parametrize(
    ("found", "std", "notes"),
    [
        ((0.048, 0.0478, 0.0482), 0.0003, (ALL,)),
        ((0.048, 0.0478), 0.0003, ()),  # Too few.
        ((0.048, 0.0478, 0.0482), 0.003, ()),  # No more than what is not known.
        ((0.048, 0.0478, 0.0482), 0.00013, ()),  # They do not agree.
        ((0.048, 0.0478, 0.0502), 0.001, ()),
        ((0.048, 0.0478, 0.0482), None, ()),
        ((0.0475, 0.0478, 0.05), 0.0003, (ENDED,)),
        ((0.0475,) * 3, 0.0003, (ALL.replace("0.048", "0.0475"),)),
    ],
)
def test_what_all_recordings_want_of_a_declared_value_is_said_once(
    fitted: Fit, found: tuple[float, ...], std: float | None, notes: tuple[str, ...]
) -> None:
    stds = {f"a [{name}]": ParameterEstimate(value=0.0, std=std, unit="m") for name in "bcde"}

    assert (
        final_model_notes(errors(a=0.04), errors(a=0.02), _lengths(fitted, *found), estimates=stds)
        == notes
    )


@pytest.mark.long
def test_a_length_that_is_too_short_in_every_recording_is_said_once() -> None:
    """The rig has 40 mm, 37.2 are declared; k takes a part of it."""
    _, made = read_campaign(None, 3, 4, duration=8.0)
    only = Tolerances(a=0.0025, e=0, load=0)
    short = [replace(one, rig=replace(one.rig, a=0.93 * one.rig.a, tolerances=only)) for one in made]
    notes = diagnose(short[:3], short[3:], candidates=(), jobs=1).notes

    (note,) = (note for note in notes if "recordings want" in note)
    assert note.startswith("all 4 recordings want a more than the declared 0.0372 m, 0.038")
    assert not any("at the end of its tolerance" in note for note in notes)


def test_what_all_want_in_place_of_zero(fitted: Fit) -> None:
    stds = {f"a [{name}]": ParameterEstimate(value=0.0, std=3e-4, unit="m") for name in "bcd"}
    told = _lengths(fitted, 0.0031, 0.0028, 0.0033, declared=0.0)
    told = replace(told, prior_steps=(1 + 1e-13) * told.prior_steps)  # As rounding makes it.
    (note,) = final_model_notes(errors(a=0.04), errors(a=0.02), told, estimates=stds)

    assert note == "all 3 recordings want a more than the declared 0 m, 0.00307 m or beyond: measure it"


def test_what_all_want_is_not_said_where_one_has_no_tolerance(fitted: Fit) -> None:
    stds = {f"a [{name}]": ParameterEstimate(value=0.0, std=3e-4, unit="m") for name in "bcd"}
    told = _lengths(fitted, 0.048, 0.0478, 0.0482)
    exact = replace(told, residuals={**told.residuals, "z": np.zeros(1)})

    assert final_model_notes(errors(a=0.04), errors(a=0.02), exact, estimates=stds) == ()


def test_fit_that_stopped_early(fitted: Fit) -> None:
    stopped = replace(fitted, converged=False, status="Maximum_Iterations_Exceeded")

    (note,) = final_model_notes(errors(a=0.04), errors(a=0.02), stopped)

    assert "stopped early (Maximum_Iterations_Exceeded)" in note


@pytest.mark.parametrize(
    ("tolerance", "said", "refused"),
    [
        (None, False, False),
        (1e5, True, True),
        (3e5, True, False),
        (1e6, False, False),
        (0.0, True, True),
    ],
)
def test_a_stiffness_beyond_its_tolerance(
    fitted: Fit, tolerance: float | None, said: bool, refused: bool
) -> None:
    """It is 2e6 where 2.4e6 was declared, 17 % less; 20 % is the usual tolerance."""
    rig = Rig(a=0.045, e=0.009, tolerances=Tolerances(k=tolerance))
    notes = final_model_notes(errors(a=0.04), errors(a=0.02), fitted, [replace(_recording(), rig=rig)])
    begin = "the fitted stiffness k is 2·10⁶ N/m², 17 % below the declared 2.4·10⁶"

    assert [note.startswith(begin) for note in notes] == [True] * said
    assert any("estimate refuses this model" in note for note in notes) == refused


@pytest.mark.parametrize(("M_0", "said"), [(-1.05, True), (0.1, False)])
def test_an_offset_far_beyond_the_tolerance_of_the_zero_is_doubted(
    fitted: Fit, M_0: float, said: bool
) -> None:
    rig = Rig(a=0.045, e=0.009, tolerances=Tolerances(zero=0.05, k=1e6))
    values = replace(fitted.values, own={"a": {**fitted.values.own["a"], "torque_offset.M_0": M_0}})
    offset = replace(fitted, values=values)
    notes = final_model_notes(errors(a=0.04), errors(a=0.02), offset, [replace(_recording(), rig=rig)])

    begin = "a: a torque offset of -1.1 N m is 21 times the tolerance of the zero: friction may be less"
    assert [note.startswith(begin) for note in notes] == [True] * said


def test_a_cars_k_is_low_by_suspension_and_column_or_by_the_force() -> None:
    car = replace(_recording(), standstills=cast(Standstills, SimpleNamespace()))
    soft, stiff = (stiffness_note(k, car) for k in (1.2e6, 4.8e6))

    assert "if the force reads too low (unit, motor_ratio), friction is told too low" in soft
    assert "if suspension, column or tyres are really so soft" in soft
    assert "if the force reads too high (unit, motor_ratio)" in stiff
    assert "suspension" not in stiff


@pytest.mark.parametrize("e", [0.0, 0.009, 0.03])
@pytest.mark.parametrize("longer", [0.7, 1.25, 1.6])
def test_what_a_wrong_torque_or_half_length_does_to_friction(e: float, longer: float) -> None:
    """By sums over bristles: the slope of the torque at rest and its size in full slide."""
    a = 0.045

    def slope_and_size(half: float) -> tuple[float, float]:
        x = np.linspace(-half, half, 20001)
        size = np.average(np.abs(x - e), weights=half**2 - x**2)
        return float(np.mean((x - e) ** 2) * 2 * half), float(size)

    (stiff, arm), (other_stiff, other_arm) = slope_and_size(a), slope_and_size(longer * a)
    # A tyre of k = 2.4e6 with another half-length than declared is taken for one of this k.
    k, mu = 2.4e6 * other_stiff / stiff, other_arm / arm
    note = stiffness_note(k, _recording(a, e))
    assert (mu > 1) == (k > 2.4e6) == (longer > 1)
    assert f"half-length of the contact is too {'short' if longer > 1 else 'long'}" in note
    factor = float(re.search(r"by a factor of ([\d.]+) at most", note)[1])  # type: ignore[index]
    assert max(mu, 1 / mu) <= factor * 1.05
    assert f"torque reads too {'high' if k > 2.4e6 else 'low'} (" in note
    assert compare_stiffness(k, _recording(a, e)).ratio == pytest.approx(k / 2.4e6)
    assert compare_stiffness(2.4e6, _recording(a, e)).ratio == 1


def test_the_stiffness_farthest_from_the_declared_one_is_put_beside_it() -> None:
    known = {"ice": 2.0e6, "snow": 2.6e6}
    made = [replace(_recording(0.04, 0.009), name=name, ground=name) for name in known]
    values = SimpleNamespace(of=lambda recording: {"k": known[recording.name]})
    fitted = cast(Fit, SimpleNamespace(values=values))
    told = {"declared": 2.4e6, "tolerance": pytest.approx(0.48e6), "assumed": True}
    assert compare_fitted_stiffness(fitted, made) == StiffnessComparison(
        found=2.0e6, **told, several=True
    )
    assert compare_fitted_stiffness(fitted, made[1:]) == StiffnessComparison(found=2.6e6, **told)
