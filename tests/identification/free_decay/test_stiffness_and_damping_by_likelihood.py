"""k and b_t from free vibrations of the independent rig."""

import json
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from identification import Decay, FreeDecay, identify_free_decay
from identification.free_decay import (
    identifiability,
    noise_continuation,
    stiffness_and_damping_by_likelihood,
)
from identification.free_decay.identifiability import (
    StiffnessOfOneContact,
    stiffness_by_contact_geometry,
    stiffnesses_agree,
)
from identification.free_decay.likelihood import Likelihood
from identification.free_decay.noise_continuation import maximise_likelihood
from identification.free_decay.vibration_detection import find_vibration
from reference_rig import CONTACT_HALF_LENGTHS as LENGTHS
from reference_rig import FOURTEEN_BIT_STEP, ImpactRecording, load_at, make_impacts
from reference_rig import THESIS_DAMPING as B_T
from reference_rig import THESIS_TYRE as TYRE
from rig_recordings import as_decay
from symbolic import InvalidInputError, Rig, Tolerances
from tests.identification.factories import decay
from tests.refusal import refused

FEW = (0.036, 0.045, 0.054)
NOISE = np.random.default_rng(0).normal(0, 10, 5000)


def read(recordings: list[ImpactRecording]) -> list[Decay]:
    return [as_decay(made) for made in recordings]


def errors(made: FreeDecay) -> tuple[float, float]:
    return made.k.value / TYRE.k - 1, made.b_t.value / B_T - 1


@pytest.fixture(scope="module")
def whole() -> FreeDecay:
    """Seven contact lengths, three impacts each, 14 bits, 1 kHz."""
    return identify_free_decay(read(make_impacts(3, impacts=3)))


@pytest.fixture(scope="module")
def few() -> list[Decay]:
    return read(make_impacts(4, lengths=FEW, impacts=1))


@pytest.fixture(scope="module")
def of_few(few: list[Decay]) -> FreeDecay:
    return identify_free_decay(few)


def test_campaign(whole: FreeDecay) -> None:
    k, b_t = errors(whole)

    assert whole.converged
    assert whole.remedy == ""
    assert abs(k) < 0.0005
    assert abs(b_t) < 0.002
    for parameter, true in ((whole.k, TYRE.k), (whole.b_t, B_T)):
        assert abs(parameter.value - true) < 3.5 * parameter.std
        assert parameter.interval[0] < parameter.value < parameter.interval[1]
    assert whole.k.std < 0.0003 * TYRE.k
    assert whole.b_t.std < 0.001 * B_T
    assert whole.encoder_step == pytest.approx(FOURTEEN_BIT_STEP)


def test_friction_force_comes_with_it(whole: FreeDecay) -> None:
    for contact, a in zip(whole.contacts, LENGTHS, strict=True):
        true = TYRE.mu * load_at(a)
        assert (contact.a, contact.e) == (a, TYRE.e)
        assert contact.force is not None
        assert contact.force.std is not None
        assert abs(contact.force.value - true) < 4 * contact.force.std
        assert contact.force.std < 0.03 * true
        assert contact.k is not None
        assert abs(contact.k.value - TYRE.k) < 0.002 * TYRE.k
    assert whole.contacts_agree is True


def test_readings_are_met(whole: FreeDecay) -> None:
    for vibration in whole.vibrations:
        assert vibration.share_of_readings_reproduced > 0.97
        # The error of rounding is even within the step.
        assert vibration.rms == pytest.approx(FOURTEEN_BIT_STEP / np.sqrt(12), rel=0.15)
        assert 0.003 < vibration.amplitude < 0.011


def test_result_is_a_file(whole: FreeDecay) -> None:
    content = json.loads(json.dumps(whole.to_dict(), allow_nan=False))

    assert content["k"]["value"] == whole.k.value
    assert content["k"]["unit"] == "N/m^2"
    assert content["b_t"]["interval_95"] == list(whole.b_t.interval)
    covariance = np.array(content["covariance"]["values"])
    assert np.sqrt(covariance[0, 0]) == pytest.approx(whole.k.std)
    assert whole.correlation == pytest.approx(covariance[0, 1] / (whole.k.std * whole.b_t.std))
    assert whole.correlation < -0.5
    assert 1 < whole.condition < 1e4
    assert len(content["recordings"]) == 21


def test_says_what_it_rests_on(whole: FreeDecay, few: list[Decay]) -> None:
    known, given = whole.identifiability

    assert known.startswith("21 recordings at 7 contact lengths tell k to 0.0")
    # d ln K / d ln a of (5.7), averaged over the lengths.
    shared = (
        "1 % more J_A is 1 % more k and b_t, which no free vibration shows, 1 % more a is 2.7 % less k"
    )
    assert shared in given
    assert "All recordings have one contact length" in identify_free_decay(few[:1]).identifiability[2]


@pytest.mark.long
@pytest.mark.parametrize(
    ("tolerances", "errors_by"),
    [(Tolerances(a=0.001, e=0.002), (0.001, 0.002)), (Tolerances(), (0.002,) * 2)],
)
def test_what_lengths_may_be_off_is_in_the_deviation_of_k(
    few: list[Decay], of_few: FreeDecay, tolerances: Tolerances, errors_by: tuple[float, float]
) -> None:
    exact = of_few
    made = identify_free_decay([replace(d, rig=replace(d.rig, tolerances=tolerances)) for d in few])
    # Anywhere within the tolerances, K = 2 a k (e^2 + a^2/3) of (5.7) being what the swing tells.
    draws = map(np.random.default_rng, (1, 2))
    a, e = (rng.uniform(-t, t, 20000) for rng, t in zip(draws, errors_by, strict=True))
    k = np.mean([_scaled(d.rig.a + a, d.rig.e + e) / _scaled(d.rig.a, d.rig.e) for d in few], axis=0)
    lengths = made.k.value * np.std(np.log(k))

    assert made.k.value == exact.k.value
    assert made.b_t == exact.b_t
    assert made.k.std == pytest.approx(np.hypot(exact.k.std, lengths), rel=0.05)
    halves = [one.k.interval[1] - one.k.value for one in (exact, made)]
    assert halves[1] == pytest.approx(np.hypot(halves[0], 1.96 * lengths), rel=0.05)
    assert made.covariance[0, 0] == pytest.approx(made.k.std**2)
    share = f"make {100 * np.sqrt(made.k.std**2 - exact.k.std**2) / made.k.value:.2g} %, the recordings"
    assert share in made.identifiability[1]
    assert made.identifiability[0] == exact.identifiability[0], "more impacts do not help lengths"


def _scaled(a: np.ndarray | float, e: np.ndarray | float) -> np.ndarray | float:
    return 1 / (a * (e**2 + a**2 / 3))


def test_a_patch_that_sticks_would_be_off_by_percents(few: list[Decay], of_few: FreeDecay) -> None:
    k, b_t = errors(identify_free_decay(few, sliding=False))
    k_sliding, b_t_sliding = errors(of_few)

    assert k < -0.01
    assert b_t > 0.04
    assert abs(k_sliding) < 0.001
    assert abs(b_t_sliding) < 0.005


def test_a_patch_that_does_stick() -> None:
    made = identify_free_decay(read(make_impacts(4, lengths=FEW, impacts=1, load=np.inf)))
    k, b_t = errors(made)

    assert abs(k) < 0.002
    assert abs(b_t) < 0.01
    assert all(contact.force is None or contact.force.value > 5000 for contact in made.contacts)


@pytest.mark.parametrize(
    "settings",
    [
        {"noise": 0.5 * FOURTEEN_BIT_STEP},
        {"rate": 200.0},
        *(
            pytest.param(made, marks=pytest.mark.long)
            for made in ({"encoder_step": 0.0}, {"swing": 0.04}, {"swing": 0.003})
        ),
        {"duration": 0.9},
    ],
    ids=lambda settings: next(iter(settings)),
)
def test_other_recordings(settings: dict[str, float]) -> None:
    made = identify_free_decay(read(make_impacts(6, lengths=FEW, impacts=1, **settings)))

    assert made.converged
    for parameter, true in ((made.k, TYRE.k), (made.b_t, B_T)):
        # 5e-5 is what the rig's bristles and steps are worth.
        assert abs(parameter.value - true) < 4 * parameter.std + 5e-5 * true
    assert made.k.std < 0.01 * TYRE.k


def test_wrong_and_missing_readings(few: list[Decay]) -> None:
    rng = np.random.default_rng(8)
    spoiled = []
    for one in few:
        psi, kept = one.psi.copy(), rng.random(one.psi.size) > 0.2
        psi[rng.choice(psi.size, 10, replace=False)] += 0.01
        spoiled.append(replace(one, t=one.t[kept], psi=psi[kept]))

    k, b_t = errors(identify_free_decay(spoiled))

    assert abs(k) < 0.005
    assert abs(b_t) < 0.02


def test_past_and_impact_do_not_matter(few: list[Decay], of_few: FreeDecay) -> None:
    # From the first turning point on: neither what struck it nor what the patch was before is seen.
    first = [find_vibration(d).first for d in few]
    cut = [replace(d, t=d.t[at:], psi=d.psi[at:]) for d, at in zip(few, first, strict=True)]

    part = identify_free_decay(cut)

    assert part.k.value == pytest.approx(of_few.k.value, abs=3 * of_few.k.std)
    assert part.b_t.value == pytest.approx(of_few.b_t.value, abs=3 * of_few.b_t.std)


def test_another_impact_is_named(few: list[Decay]) -> None:
    one, step = few[1], FOURTEEN_BIT_STEP
    half = one.psi[-1] + step * np.round((one.psi - one.psi[-1]) / (2 * step))
    t, psi = np.append(one.t, one.t[-1] + 0.001 + one.t), np.append(one.psi, half)
    twice = replace(one, t=t, psi=psi)

    made = identify_free_decay([twice])

    assert "goes on with another deflection at t = 1." in made.identifiability[-1]
    assert abs(errors(made)[0]) < 0.005


def test_needs_a_recording() -> None:
    assert "at least one" in refused(identify_free_decay, [])


@pytest.mark.parametrize("singular", ["maximise_likelihood", "jackknife_covariance"])
def test_recordings_that_tell_nothing(
    singular: str, few: list[Decay], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise np.linalg.LinAlgError("singular matrix")

    monkeypatch.setattr(stiffness_and_damping_by_likelihood, singular, fail)

    assert "do not tell k and b_t at all: check that" in refused(identify_free_decay, few)


def test_says_when_it_was_not_solved(few: list[Decay], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(noise_continuation, "_MAX_STAGES", 2)

    made = identify_free_decay(few)

    assert not made.converged
    assert made.status.startswith("not solved")
    assert "one impact" in made.remedy
    assert made.contacts_agree is None


def test_a_dozen_readings() -> None:
    t = np.arange(12) * 0.1
    psi = 0.01 * np.exp(-t) * np.cos(20 * t)
    made = identify_free_decay([decay(t, psi)])

    # A linear vibration: no slip, and omega^2 + decay^2 = K / J_A.
    spring = 2 * 0.045 * made.k.value * (0.009**2 + 0.045**2 / 3)
    assert spring / 0.15 == pytest.approx(20**2 + 1, rel=1e-5)
    assert made.b_t.value / (2 * 0.15) == pytest.approx(1, rel=1e-4)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        # As without '# a = ...' in the files: the rig file's a holds for every recording.
        (
            lambda one: replace(one, rig=replace(one.rig, a=0.045)),
            r"^a54_1: psi swings at .* a, e and J_A with the k",
        ),
        (
            lambda one: replace(one, psi=FOURTEEN_BIT_STEP * np.round(NOISE[: one.t.size])),
            r"^a36_1: psi (swings at|does not follow) .*: check that",
        ),
    ],
    ids=["one length for all", "noise"],
)
def test_what_is_no_such_vibration(few: list[Decay], wrong: Callable[[Decay], Decay], said: str) -> None:
    with pytest.raises(InvalidInputError, match=said):
        identify_free_decay([wrong(one) for one in few])


@pytest.mark.parametrize(
    "wrong",
    [lambda d: replace(d, t=1000 * d.t), lambda d: replace(d, rig=replace(d.rig, J_A=1e4 * d.inertia))],
    ids=["milliseconds", "kg cm^2"],
)
def test_wrong_units_are_named(few: list[Decay], wrong: Callable[[Decay], Decay]) -> None:
    usual, strange = identify_free_decay(few[:1]), identify_free_decay([wrong(few[0])])

    assert not any("declared" in sentence for sentence in usual.identifiability)
    assert "times the 2e+06 N/m^2 declared" in strange.identifiability[-1]
    assert "check J_A [kg m^2], a and e [m] and t [s]" in strange.identifiability[-1]


THREE = (0.030, 0.042, 0.054)


@pytest.fixture(scope="module")
def decays() -> list[Decay]:
    return read(make_impacts(9, lengths=THREE, impacts=2))


def alone(k: float, std: float = 1.0, degrees_of_freedom: int = 20) -> StiffnessOfOneContact:
    return StiffnessOfOneContact(k=k, std=std, degrees_of_freedom=degrees_of_freedom)


def test_agree() -> None:
    assert stiffnesses_agree([alone(100), alone(101), alone(99)]) is True
    assert stiffnesses_agree([alone(100), alone(101), alone(110)]) is False
    assert stiffnesses_agree([alone(100, 10.0), alone(101, 10.0), alone(110, 10.0)]) is True
    # What rests on little is believed less.
    assert stiffnesses_agree([alone(100), alone(107), alone(100)]) is False
    assert stiffnesses_agree([alone(100), alone(107), alone(100, degrees_of_freedom=2)]) is True
    assert stiffnesses_agree([alone(100)]) is None


def test_seldom_wrong() -> None:
    rng = np.random.default_rng(6)
    drawn = rng.normal(100, 1, (4000, 5))
    std = np.sqrt(rng.chisquare(20, (4000, 5)) / 20)
    told = [
        stiffnesses_agree([alone(k, s) for k, s in zip(*row, strict=True)])
        for row in zip(drawn, std, strict=True)
    ]

    assert told.count(False) < 40


def test_each_contact_tells_k(decays: list[Decay]) -> None:
    found = stiffness_by_contact_geometry(Likelihood([find_vibration(one) for one in decays]))

    assert list(found) == [(a, TYRE.e) for a in THREE]
    for one in found.values():
        assert abs(one.k - TYRE.k) < 4 * one.std
        assert one.std < 0.003 * TYRE.k
    assert stiffnesses_agree(found.values()) is True
    assert stiffness_by_contact_geometry(Likelihood([find_vibration(one) for one in decays[:2]])) == {}


@pytest.mark.long
@pytest.mark.parametrize(
    "wrong",
    [
        lambda rig: replace(rig, a=rig.a + 0.001),
        lambda rig: replace(rig, a=1.03 * rig.a),
        lambda rig: replace(rig, e=rig.e + 0.003),
        lambda rig: replace(rig, J_A=rig.J_A * (1.03 if rig.a > 0.05 else 1)),
    ],
    ids=["a by 1 mm", "a by 3 %", "e by 3 mm", "J_A of one contact by 3 %"],
)
def test_shows_what_is_wrong(decays: list[Decay], wrong: Callable[[Rig], Rig]) -> None:
    made = identify_free_decay([replace(one, rig=wrong(one.rig)) for one in decays])
    told = [c.k.value for c in made.contacts if c.k is not None]

    assert made.contacts_agree is False
    assert max(told) / min(told) > 1.003
    assert made.identifiability[2].startswith("One contact at a time, k runs from -")


def test_no_free_vibration_shows_the_inertia(few: list[Decay], of_few: FreeDecay) -> None:
    heavier = [replace(one, rig=replace(one.rig, J_A=1.05 * one.inertia)) for one in few]
    made = identify_free_decay(heavier)

    assert made.contacts_agree is True
    assert made.k.value / of_few.k.value == pytest.approx(1.05, rel=1e-4)
    assert made.b_t.value / of_few.b_t.value == pytest.approx(1.05, rel=1e-3)


def test_contacts_that_do_not_tell(decays: list[Decay], monkeypatch: pytest.MonkeyPatch) -> None:
    likelihood = Likelihood([find_vibration(one) for one in decays])

    def singular(_: Likelihood) -> None:
        raise np.linalg.LinAlgError

    monkeypatch.setattr(identifiability, "maximise_likelihood", singular)
    assert stiffness_by_contact_geometry(likelihood) == {}
    monkeypatch.setattr(
        identifiability,
        "maximise_likelihood",
        lambda part: replace(maximise_likelihood(part), converged=False),
    )
    assert stiffness_by_contact_geometry(likelihood) == {}
