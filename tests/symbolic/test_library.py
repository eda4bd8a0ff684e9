"""Effects by name, the library's and the user's own."""

from dataclasses import dataclass, replace
from types import ModuleType
from typing import Any

import pytest

from symbolic import EFFECTS, Effect, InvalidInputError, Parameter, effects_in, effects_named
from tests.refusal import refused


@dataclass(frozen=True, kw_only=True)
class Stop(Effect):
    """An effect of the user's own."""

    name: str = "stop"
    summary: str = "a stop"
    parameters: tuple[Parameter, ...] = (
        Parameter(name="c", unit="N m", neutral=0.0, start=0.1, lower=0.0, upper=9.0, scale=1.0),
    )


@dataclass(frozen=True, kw_only=True)
class Familiar(Stop):
    """An effect whose family is an annotated field, which does no harm."""

    family: str = "friction over speed"  # type: ignore[misc]


def module(**content: Any) -> ModuleType:
    made = ModuleType("mine")
    vars(made).update(content)
    return made


def test_an_effect_stands_for_itself_and_a_name_for_one_that_is_given() -> None:
    stop = Stop()

    assert effects_named(["pretwist", stop]) == (EFFECTS["pretwist"], stop)
    assert effects_named(["stop", "pretwist"], [stop]) == (stop, EFFECTS["pretwist"])
    assert effects_named([*EFFECTS, stop]) == (*EFFECTS.values(), stop)
    with pytest.raises(InvalidInputError, match=r"unknown effect 'stop'; .* --effects MODULE"):
        effects_named(["stop"])
    assert "'pretwist' is named twice" in refused(effects_named, ["pretwist", "pretwist"])


def test_a_module_declares_its_effects() -> None:
    stop = Stop()

    assert effects_in(module(EFFECTS=[stop])) == (stop,)
    assert effects_in(module(EFFECTS=[Familiar()])) == (Familiar(),)
    both = (effect for effect in (stop, EFFECTS["pretwist"]))
    assert effects_in(module(EFFECTS=both)) == (stop, EFFECTS["pretwist"])


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        ({}, "module mine must declare its effects as EFFECTS = "),
        ({"EFFECTS": 3}, "module mine must declare its effects as EFFECTS = "),
        ({"EFFECTS": {"stop": Stop()}}, "module mine must declare its effects as EFFECTS = "),
        ({"EFFECTS": [Stop]}, "module mine: an effect must be an object of Effect, got <class"),
        ({"EFFECTS": ["stribeck"]}, "module mine: an effect must be an object of Effect, got 'str"),
        ({"EFFECTS": [Stop(), Stop(summary="b")]}, "module mine: effect 'stop' is named twice"),
        ({"EFFECTS": [Stop(name="stribeck")]}, "module mine: effect 'stribeck' has the name of another"),
        (
            {"EFFECTS": [replace(EFFECTS["stribeck"], summary="mine")]},
            "module mine: effect 'stribeck' has the name of another one in the library",
        ),
        (
            {"EFFECTS": [Familiar(family="speed")]},
            "module mine: effect 'stop' has the unknown family 'speed'; known are friction over speed,",
        ),
        (
            {"EFFECTS": [Stop(name="a.b")]},
            "module mine: an effect's name must be an identifier, got 'a.b'",
        ),
        (
            {"EFFECTS": [Stop(parameters=list(Stop().parameters))]},  # type: ignore[arg-type]
            "module mine: effect 'stop' must be a frozen dataclass whose parameters must be a tuple",
        ),
    ],
)
def test_faults_of_a_module(content: dict[str, Any], fault: str) -> None:
    assert refused(effects_in, module(**content)).startswith(fault)
