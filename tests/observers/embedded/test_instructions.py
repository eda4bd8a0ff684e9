"""What generated C costs on a Cortex-M4F is what it cost before, to within 5 %."""

import tomllib
from pathlib import Path

import pytest

from benchmarks.embedded import counted
from observers.embedded import DOUBLE, SINGLE
from tests.observers.embedded.cortex.target import M4F, TOOLS, tools_installed
from tests.observers.embedded.generated_code import (
    generate_code,
    observer_of_budget,
    tunable_of,
)

BUDGET = tomllib.loads(Path(__file__).with_name("instructions.toml").read_text("utf-8"))
RESOLUTION = 40
"""Instructions to which the emulator tells the longest step."""


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
