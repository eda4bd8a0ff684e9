import pytest

from symbolic import compiler
from tests.attack import generated_c
from tests.attack.attack_class import Effort, undertake
from tests.observers.embedded.generated_code import NO_COMPILER

pytestmark = pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
SHORT = Effort(seconds=20, inputs=40_000)
CLASSES = [
    pytest.param(name, marks=() if name == "c_ekf_declared_steering" else pytest.mark.long)
    for name in generated_c.CLASSES
]


@pytest.mark.parametrize("name", CLASSES)
def test_the_estimate_comes_back(name: str) -> None:
    outcome = undertake(generated_c.CLASSES[name], SHORT)

    assert outcome.failures == ()
    assert outcome.inputs >= generated_c.ROUND


def test_an_estimate_that_stays_away_is_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generated_c, "NEAR", 0.0)
    monkeypatch.setattr(generated_c, "PATIENCE", 2)
    first = next(iter(generated_c.CLASSES.values()))
    (line,) = undertake(first, Effort(seconds=20, inputs=1)).failures

    assert "after 20 s mu is" in line
