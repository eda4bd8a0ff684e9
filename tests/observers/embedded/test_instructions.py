"""What generated C costs on a Cortex-M4F is what it cost before, to within 5 %."""

import tomllib
from pathlib import Path

import pytest

from benchmarks.embedded import MEASURED_RUN, adversarial, samples, steered
from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import SINGLE, Tunable
from symbolic import Model, effects_named
from tests.observers.conftest import K
from tests.observers.embedded.cortex.target import M4F, TOOLS, run_on, tools_installed
from tests.observers.embedded.generated_code import DECLARED, generate_code, observer_of

BUDGET = tomllib.loads(Path(__file__).with_name("instructions.toml").read_text("utf-8"))
KINDS = {"ekf": Ekf, "mhe": Mhe}
TORSION = {
    "model": Model(effects=effects_named(["carcass_torsion"])),
    "values": {"k": K, "carcass_torsion.k_t": 300.0},
}
MODELS = {"declared": DECLARED, "measured": MEASURED_RUN, "torsion": TORSION}
TORQUES = {"aligning": AligningTorque(), "steering": SteeringTorque()}
TUNABLE: dict[str, Tunable] = {"": "", "tuning": "tuning", "all": "all"}
RESOLUTION = 40
"""Instructions to which the emulator tells the longest step."""


@pytest.mark.long
@pytest.mark.skipif(not tools_installed(), reason=TOOLS)
@pytest.mark.parametrize("name", BUDGET)
def test_instructions(name: str, tmp_path: Path) -> None:
    kind, model, torque, *at_run_time = name.split()
    observer = observer_of(KINDS[kind], MODELS[model], TORQUES[torque])
    code = generate_code(observer, SINGLE, tmp_path, tunable=TUNABLE[" ".join(at_run_time)])
    usual = run_on(M4F, code, steered() if torque == "steering" else samples()[:700])
    most = max(usual.most, run_on(M4F, code, adversarial()).most)
    print(f"{name}: {usual.instructions:.0f} instructions a step, at most {most}")

    mean, longest = BUDGET[name]
    assert usual.instructions == pytest.approx(mean, rel=0.05), "fewer: renew instructions.toml"
    assert most == pytest.approx(longest, rel=0.05, abs=RESOLUTION), "fewer: renew instructions.toml"
