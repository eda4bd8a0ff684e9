"""What is no number, or a state of something else, is named where it is handed over."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from observers import Ekf, Loop, Mhe, ObserverState, RootObserver, Sample, run
from symbolic import InvalidInputError, Model, Rig

GOOD = {"psi": 0.1, "psi_dot": 1.0, "F_N": 400.0, "dt": 0.01, "M_z": -0.5, "M": 2.0}
FIRST = Sample(**GOOD)
RIG = Rig(a=0.045, e=0.009)
OBSERVERS = {
    "ekf": Ekf(model=Model(), values={"k": 2.4e6}, rig=RIG),
    "mhe": Mhe(model=Model(), values={"k": 2.4e6}, rig=RIG, window=3),
    "root": RootObserver(rig=RIG, k=2.4e6),
}
pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.mark.parametrize("name", GOOD)
@pytest.mark.parametrize(
    "value", ["0.1", b"1", None, [1.0], np.ones(1), np.ones(2), 1j, np.complex128(1), 10**400],
    ids=lambda value: str(value)[:20],
)  # fmt: skip
def test_a_value_that_is_no_number_is_named(name: str, value: Any) -> None:
    with pytest.raises(InvalidInputError, match=f"one number for {name}, NaN where"):
        Sample(**{**GOOD, name: value})


@pytest.mark.parametrize("value", [1, True, np.float32(1), np.array(1.0), np.int64(1)])
def test_other_numbers_become_floats(value: Any) -> None:
    sample = Sample(**dict.fromkeys(GOOD, value))

    assert [type(number) for number in sample.numbers] == [float] * len(GOOD)
    assert sample == Sample(**dict.fromkeys(GOOD, 1.0))


def test_a_late_measurement_that_is_no_number_is_named() -> None:
    loop = Loop(OBSERVERS["root"])
    before = loop(FIRST)

    with pytest.raises(InvalidInputError, match="M_z"):
        loop.late(0, M_z="0.1")  # type: ignore[arg-type]
    assert repr(loop(replace(FIRST, M_z=np.nan)).mu) == repr(before.mu)


@pytest.mark.parametrize("name", OBSERVERS)
@pytest.mark.parametrize("call", ["step", "estimate"])
def test_a_foreign_state_is_named(name: str, call: str) -> None:
    observer = OBSERVERS[name]
    arguments = (FIRST,) if call == "step" else ()
    others = [other.init(FIRST) for key, other in OBSERVERS.items() if key != name]

    for state in (None, "x", {}, [1.0], np.zeros(3), Loop(observer), *others):
        with pytest.raises(InvalidInputError, match=r"^state "):
            getattr(observer, call)(state, *arguments)


@pytest.mark.parametrize("name", ["ekf", "mhe"])
def test_a_state_of_another_order_is_foreign(name: str) -> None:
    observer = OBSERVERS[name]
    state = observer.init(FIRST)
    layout = replace(state.layout, fields=state.layout.fields[::-1])

    with pytest.raises(InvalidInputError, match="another observer"):
        observer.step(ObserverState(state.values, layout), FIRST)


@pytest.mark.parametrize("name", ["ekf", "mhe"])
@pytest.mark.parametrize("part", ["memory", "x", "factor"])
def test_a_state_of_nan_is_not_gone_on_with(name: str, part: str) -> None:
    observer = OBSERVERS[name]
    state = observer.step(observer.init(FIRST), FIRST)
    values = state.values.copy()
    values[state.layout.places[part][0].start] = np.nan

    with pytest.raises(InvalidInputError, match="state has NaN; begin anew"):
        observer.step(ObserverState(values, state.layout), FIRST)


@pytest.mark.parametrize("name", OBSERVERS)
def test_no_estimate_is_made_of_nan(name: str) -> None:
    observer = OBSERVERS[name]
    state: Any = observer.init(FIRST)
    nan = (
        replace(state, mu=np.nan)
        if name == "root"
        else ObserverState(np.full_like(state.values, np.nan), state.layout)
    )

    with pytest.raises(InvalidInputError, match="state has NaN"):
        observer.estimate(nan)


@pytest.mark.parametrize("name", ["t", "psi", "F_N", "M_z", "psi_dot"])
@pytest.mark.parametrize("value", ["x", ["a"] * 20, [1j] * 20, [[1], [2, 3]]], ids=str)
def test_a_column_that_is_no_number_is_named(name: str, value: Any) -> None:
    t = np.linspace(0, 1, 20)
    columns = {"t": t, "psi": 0.1 * t, "F_N": 400.0, "M_z": -t, name: value}

    with pytest.raises(InvalidInputError, match=rf"^{name} must hold numbers"):
        run(OBSERVERS["root"], **columns)
