"""Parameters at run time: C with those of another observer is that one, and refuses what it would."""

import ctypes
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from observers import AligningTorque, CasadiObserver, Ekf, Mhe, SteeringTorque
from observers.embedded import DOUBLE, SINGLE, Real, Tunable, generate
from observers.embedded.run_time_parameters import run_time_parameters
from symbolic import Effect, InvalidInputError, Model, Parameter
from symbolic.float_array_type import Array
from tests.observers.conftest import RIG, K
from tests.observers.embedded.generated_code import (
    CREEP,
    DECLARED,
    GeneratedCode,
    InterpretedObserver,
    RunningCode,
    generate_code,
    needs_compiler,
    observer_of,
    python_estimates,
)

OTHER_TUNING = {
    "mu": 0.7, "mu_std": 0.4, "noise": 0.03, "gate": 6.0, "psi_limit": 0.35, "explained": 0.5,
}  # fmt: skip
OTHER_RIG = replace(RIG, a=0.05, e=0.004, b_t=0.6, slide_rate=0.3)


def drive(count: int = 150) -> Array:
    """Samples (n, 5) of a wheel turned to and fro beyond the other tuning's limit of the angle."""
    t = 0.01 * np.arange(count)
    psi = 0.4 * np.sin(5 * t)
    torque = -9 * np.tanh(8 * np.gradient(psi, 0.01)) + np.sin(40 * t)
    load = 400 + 20 * np.sin(3 * t)
    # Until the angle is known the estimate is the prior.
    psi[0] = np.nan
    return np.column_stack([psi, np.full(count, np.nan), torque, load, np.full(count, 0.01)])


def other(observer: Any, tunable: Tunable) -> Any:
    """The observer with other values of all that is taken at run time."""
    tuning = replace(observer.tuning, **OTHER_TUNING)
    if tunable == "tuning":
        return replace(observer, tuning=tuning)
    values = {name: 1.2 * value for name, value in observer.values.items()}
    return replace(observer, tuning=tuning, rig=OTHER_RIG, values=values)


def block(observer: Any, tunable: Tunable, real: Real) -> Array:
    """The parameters of an observer as C has them."""
    return np.array([p.value for p in run_time_parameters(observer, tunable)], real.dtype)


def run_with(code: GeneratedCode, parameters: Any, samples: Array) -> tuple[int, Array]:
    """What setting the parameters returns, and the estimates thereafter."""
    running, fault = RunningCode(code), 0
    if parameters is not None:
        at = ctypes.c_void_p(parameters.ctypes.data)
        fault = int(code.library.brushgrip_set_parameters(running.at, at))
    return fault, running.run(samples)


@needs_compiler
@pytest.mark.parametrize("tunable", ["tuning", "all"])
@pytest.mark.parametrize(
    ("kind", "model", "sensing"),
    [
        pytest.param(Ekf, DECLARED, AligningTorque(), id="ekf"),
        pytest.param(Ekf, DECLARED, SteeringTorque(), id="ekf-steering", marks=pytest.mark.long),
        pytest.param(Mhe, DECLARED, AligningTorque(stiffness=True), id="mhe", marks=pytest.mark.long),
        pytest.param(Mhe, DECLARED, SteeringTorque(), id="mhe-steering", marks=pytest.mark.long),
        pytest.param(Ekf, CREEP, AligningTorque(), id="ekf-creep", marks=pytest.mark.long),
        pytest.param(Mhe, CREEP, SteeringTorque(), id="mhe-creep", marks=pytest.mark.long),
    ],
)
def test_c_with_other_parameters_is_the_other_observer(
    kind: Any, model: dict[str, Any], sensing: Any, tunable: Tunable, tmp_path: Path
) -> None:
    settings = {"window": 6} if kind is Mhe else {}
    # While friction is acquired, the patch for a model with effects is that of the generation.
    acquire = model is DECLARED or tunable == "tuning"
    observer = replace(observer_of(kind, model, sensing), acquire=acquire, **settings)
    changed, samples = other(observer, tunable), drive()
    code = generate_code(observer, DOUBLE, tmp_path, tunable=tunable)

    for one in (observer, changed):
        fault, estimates = run_with(code, block(one, tunable, DOUBLE), samples)

        assert fault == 0
        # Compiled C of compact code takes as many steps of a fixed count as the search of Python needs.
        expected = python_estimates(InterpretedObserver(one), samples)
        np.testing.assert_allclose(estimates, expected, rtol=1e-6, atol=1e-7)
    usual = run_with(code, None, samples)[1]
    np.testing.assert_array_equal(usual, run_with(code, block(observer, tunable, DOUBLE), samples)[1])
    assert np.nanmax(np.abs(estimates - usual)) > 0.1


@needs_compiler
def test_what_python_refuses_is_refused_and_changes_nothing(tmp_path: Path) -> None:
    observer = observer_of(Ekf, DECLARED, AligningTorque())
    code, samples = generate_code(observer, SINGLE, tmp_path, tunable="all"), drive(60)
    parameters = run_time_parameters(observer, "all")
    places = {p.field: i for i, p in enumerate(parameters)}
    good, usual = block(observer, "all", SINGLE), run_with(code, None, samples)[1]
    bad = {
        "k": 1.0, "a": 2.0, "e": 0.05, "J_A": 0.0, "b_t": -0.1, "slide_rate": 0.0, "mu": 5.0,
        "mu_std": 0.0, "mu_walk": -1.0, "least": 1.5, "greatest": 0.5, "zero_std": np.nan,
        "noise": np.inf, "psi_noise": 0.0, "gate": np.nan, "reset_after": 0.5, "rezero_time": -np.inf,
    }  # fmt: skip
    for field, value in (("reset_after", 2.5), ("reset_after", np.inf)):
        block_of_bad = good.copy()
        block_of_bad[places[field]] = value
        assert run_with(code, block_of_bad, samples)[0] == 1 + places[field]
    told = {"e": "a", "least": "mu", "greatest": "mu"}
    for field, value in bad.items():
        block_of_bad = good.copy()
        block_of_bad[places[field]] = value
        fault, estimates = run_with(code, block_of_bad, samples)

        assert fault == 1 + places[told.get(field, field)], field
        np.testing.assert_array_equal(estimates, usual)
    for field in ("zero_time", "error", "gate", "alarm", "explained", "psi_limit"):
        no_limit = good.copy()
        no_limit[places[field]] = np.inf
        assert run_with(code, no_limit, samples)[0] == 0, field


def test_calibration_tools_find_every_parameter_at_its_place(tmp_path: Path) -> None:
    observer = observer_of(Ekf, CREEP, AligningTorque())
    generate(observer, tmp_path, SINGLE, name="grip", tunable="all")
    text, header = (tmp_path / "grip.a2l").read_text(), (tmp_path / "grip.h").read_text()

    fields = re.search(r"typedef struct \{([^}]*)\} grip_parameters_t;", header)
    assert fields is not None
    in_c = re.findall(r"^    float (\w+);", fields[1], re.MULTILINE)
    told = re.findall(
        r'/begin CHARACTERISTIC grip\.(\w+) "[^"]*" VALUE 0x0 grip_value 0 grip_unit_\d+ (\S+) (\S+)\n'
        r'\s+SYMBOL_LINK "grip_defaults" (\d+)\n',
        text,
    )

    assert [name for name, *_ in told] == in_c
    assert [int(offset) for *_, offset in told] == [4 * i for i in range(len(in_c))]
    assert {"k", "frictional_creep_c", "carcass_torsion_k_t", "a", "mu", "gate"} < set(in_c)
    for parameter, (_, least, most, _) in zip(run_time_parameters(observer, "all"), told, strict=True):
        assert float(least) <= parameter.value
        assert parameter.value <= float(most) or np.isinf(parameter.value)
    assert text.count("/begin ") == text.count("/end ")
    assert "grip.output.mu" in text


def test_an_observer_without_tuning_has_no_parameters() -> None:
    class Own(CasadiObserver):
        """No `Ekf` and no `Mhe`."""

    with pytest.raises(InvalidInputError, match="those of an Ekf or an Mhe, got Own"):
        run_time_parameters(Own(model=Model(), values={"k": K}, rig=RIG), "tuning")


@dataclass(frozen=True, kw_only=True)
class NamedSpring(Effect):
    """A spring under a name of choice."""

    name: str
    summary: str = "a spring"
    parameters: tuple[Parameter, ...] = ()

    def torque(self, signals: Any, values: Any) -> Any:
        return -values[self.parameters[0].name] * signals.psi


@pytest.mark.parametrize(("effect", "parameter"), [("slide", "rate"), ("mu", "walk"), ("größe", "c")])
def test_a_name_that_c_cannot_have_is_refused(effect: str, parameter: str) -> None:
    declared = Parameter(name=parameter, unit="1", neutral=0.0, start=1.0, lower=0, upper=2, scale=1.0)
    spring = NamedSpring(name=effect, parameters=(declared,))
    values = {"k": K, f"{effect}.{parameter}": 1.0}
    observer = Ekf(model=Model(effects=(spring,)), values=values, rig=OTHER_RIG)

    assert run_time_parameters(observer, "tuning")
    with pytest.raises(InvalidInputError, match="names of their own in ASCII"):
        run_time_parameters(observer, "all")
