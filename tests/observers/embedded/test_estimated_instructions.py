"""Counted instructions are as guarded in instructions.toml, and as told beforehand."""

import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.embedded import counted
from observers import AligningTorque, Ekf
from observers.embedded import DOUBLE, SINGLE
from observers.embedded.estimated_instructions import (
    CORNERS,
    ERROR,
    MAX_CORNERS,
    VECTORS,
    estimated_instructions,
)
from tests.observers.embedded.cortex.target import M4F, TOOLS, tools_installed
from tests.observers.embedded.generated_code import (
    FOUND,
    generate_code,
    observer_named,
    observer_of,
    observer_of_budget,
    tunable_of,
)

BUDGET = tomllib.loads(Path(__file__).with_name("instructions.toml").read_text("utf-8"))
RESOLUTION = 40
"""Instructions to which the emulator tells the longest step."""


@pytest.mark.parametrize("name", BUDGET)
def test_a_count_is_estimated(name: str) -> None:
    observer, words = observer_of_budget(name)
    real = DOUBLE if "double" in words else SINGLE
    cost = estimated_instructions(observer, real, tunable_of(words))
    mean, _, most = BUDGET[name]

    assert cost.instructions == pytest.approx(mean, rel=ERROR)
    assert cost.at_most == pytest.approx(most, rel=ERROR)
    assert cost.at_most >= most
    assert (cost.error, cost.vectors) == (ERROR, False)


def test_what_a_corner_and_what_acquiring_friction_takes_is_told() -> None:
    cost = estimated_instructions(observer_named("ekf declared aligning"))
    alone = estimated_instructions(observer_named("ekf declared aligning", acquire=False))
    bristles = estimated_instructions(observer_named("ekf effects aligning"))

    assert (cost.corners, cost.most_corners) == (CORNERS, MAX_CORNERS) == (7, 30)
    assert cost.instructions is not None
    assert cost.at_most is not None
    assert cost.at_most - cost.instructions > cost.corner * (MAX_CORNERS - CORNERS) + cost.acquiring / 2
    assert f"{cost.corner} for each corner of the patch, from 7 to 30" in str(cost)
    assert (alone.acquiring, alone.corner, bristles.corner) == (0, cost.corner, 0)
    assert "corner" not in str(bristles)


def test_what_is_not_known_is_not_told() -> None:
    iterated = estimated_instructions(replace(observer_named("ekf declared aligning"), iterations=2))

    assert (iterated.vectors, iterated.instructions) == (True, VECTORS)
    assert "one iteration is written as loops" in str(iterated)
    cost = estimated_instructions(observer_of(Ekf, FOUND, AligningTorque()), tunable="all")
    assert (cost.vectors, cost.instructions, cost.at_most) == (True, VECTORS, None)
    assert "the tuning alone" in str(cost)


@pytest.mark.long
@pytest.mark.skipif(not tools_installed(), reason=TOOLS)
@pytest.mark.parametrize("name", BUDGET)
def test_instructions(name: str, tmp_path: Path) -> None:
    observer, words = observer_of_budget(name)
    real = DOUBLE if "double" in words else SINGLE
    code = generate_code(observer, real, tmp_path, tunable=tunable_of(words))
    cost = counted(M4F, code)
    print(f"{name}: {cost.mean:.0f} instructions a step, at most {cost.ordinary} and {cost.most}")

    mean, ordinary, most = BUDGET[name]
    again = "another count: renew instructions.toml"
    assert cost.mean == pytest.approx(mean, rel=0.05), again
    assert cost.ordinary == pytest.approx(ordinary, rel=0.05, abs=RESOLUTION), again
    assert cost.most == pytest.approx(most, rel=0.05, abs=RESOLUTION), again
