"""What generated C costs on a Cortex-M4F is what it cost before, to within 5 %."""

import tomllib
from pathlib import Path

import pytest

from benchmarks.embedded import adversarial, samples, steered
from observers.embedded import SINGLE, Tunable
from tests.observers.embedded.cortex.target import M4F, TOOLS, run_on, tools_installed
from tests.observers.embedded.generated_code import generate_code, observer_named

BUDGET = tomllib.loads(Path(__file__).with_name("instructions.toml").read_text("utf-8"))
TUNABLE: dict[str, Tunable] = {"": "", "tuning": "tuning", "all": "all"}
RESOLUTION = 40
"""Instructions to which the emulator tells the longest step."""


@pytest.mark.long
@pytest.mark.skipif(not tools_installed(), reason=TOOLS)
@pytest.mark.parametrize("name", BUDGET)
def test_instructions(name: str, tmp_path: Path) -> None:
    kind, model, torque, *at_run_time = name.split()
    observer = observer_named(f"{kind} {model} {torque}")
    code = generate_code(observer, SINGLE, tmp_path, tunable=TUNABLE[" ".join(at_run_time)])
    usual = run_on(M4F, code, steered() if torque == "steering" else samples()[:700])
    most = max(usual.most, run_on(M4F, code, adversarial()).most)
    print(f"{name}: {usual.instructions:.0f} instructions a step, at most {most}")

    mean, longest = BUDGET[name]
    assert usual.instructions == pytest.approx(mean, rel=0.05), "fewer: renew instructions.toml"
    assert most == pytest.approx(longest, rel=0.05, abs=RESOLUTION), "fewer: renew instructions.toml"
