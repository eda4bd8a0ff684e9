"""Contacts that agree on k, and contacts that do not."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from identification.free_decay import identifiability
from identification.free_decay.estimator import identify_free_decay
from identification.free_decay.identifiability import (
    StiffnessOfOneContact,
    stiffness_by_contact,
    stiffnesses_agree,
)
from identification.free_decay.likelihood import Likelihood
from identification.free_decay.onset import find_vibration
from identification.free_decay.recording import Decay
from identification.free_decay.solution import solve
from reference_rig import THESIS_TYRE as TYRE
from reference_rig import make_impacts
from symbolic import Rig
from tests.identification.factories import as_decay

LENGTHS = (0.030, 0.042, 0.054)
RNG = np.random.default_rng(6)


@pytest.fixture(scope="module")
def decays() -> list[Decay]:
    return [as_decay(made) for made in make_impacts(9, lengths=LENGTHS, impacts=2)]


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
    drawn = RNG.normal(100, 1, (4000, 5))
    std = np.sqrt(RNG.chisquare(20, (4000, 5)) / 20)
    told = [
        stiffnesses_agree([alone(k, s) for k, s in zip(*row, strict=True)])
        for row in zip(drawn, std, strict=True)
    ]

    assert told.count(False) < 40


def test_each_contact_tells_k(decays: list[Decay]) -> None:
    found = stiffness_by_contact(Likelihood([find_vibration(decay) for decay in decays]))

    assert list(found) == [(a, TYRE.e) for a in LENGTHS]
    for one in found.values():
        assert abs(one.k - TYRE.k) < 4 * one.std
        assert one.std < 0.003 * TYRE.k
    assert stiffnesses_agree(found.values()) is True
    assert stiffness_by_contact(Likelihood([find_vibration(decay) for decay in decays[:2]])) == {}


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
    made = identify_free_decay([replace(decay, rig=wrong(decay.rig)) for decay in decays])
    told = [c.k.value for c in made.contacts if c.k is not None]

    assert made.contacts_agree is False
    assert max(told) / min(told) > 1.003
    assert made.identifiability[2].startswith("One contact at a time, k runs from -")


def test_no_free_vibration_shows_the_inertia(decays: list[Decay]) -> None:
    heavier = [replace(decay, rig=replace(decay.rig, J_A=1.05 * decay.inertia)) for decay in decays]
    usual, made = identify_free_decay(decays), identify_free_decay(heavier)

    assert made.contacts_agree is True
    assert made.k.value / usual.k.value == pytest.approx(1.05, rel=1e-4)
    assert made.b_t.value / usual.b_t.value == pytest.approx(1.05, rel=1e-3)


def test_contacts_that_do_not_tell(decays: list[Decay], monkeypatch: pytest.MonkeyPatch) -> None:
    likelihood = Likelihood([find_vibration(decay) for decay in decays])

    def singular(_: Likelihood) -> None:
        raise np.linalg.LinAlgError

    monkeypatch.setattr(identifiability, "solve", singular)
    assert stiffness_by_contact(likelihood) == {}
    monkeypatch.setattr(identifiability, "solve", lambda part: replace(solve(part), converged=False))
    assert stiffness_by_contact(likelihood) == {}
