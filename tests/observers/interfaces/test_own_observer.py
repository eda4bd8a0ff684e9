"""The observer of examples/own_observer.py: run, in a loop, beside other methods, and as C."""

import json
import re
import runpy
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from examples.own_observer import MODEL, VALUES, ConstantGain
from identification import Recording, read_recording, read_rig
from observers import Loop, RootObserver, Sample, run
from observers.embedded import DOUBLE, generate
from symbolic import InvalidInputError, compiler
from symbolic.float_array_type import Array
from tests.observers.embedded.generated_code import NO_COMPILER, generate_code, python_estimates
from tests.refusal import refused

PLANTED = 1.37


@pytest.fixture(scope="module")
def recording(repository_root: Path) -> Recording:
    folder = repository_root / "examples" / "recordings"
    return read_recording(folder / "holdout_c.csv", read_rig(folder / "rig.toml"))


@pytest.fixture(scope="module")
def observer(recording: Recording) -> ConstantGain:
    return ConstantGain(model=MODEL, values=VALUES, rig=recording.rig)


def test_script_prints_it(repository_root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    runpy.run_path(str(repository_root / "examples" / "own_observer.py"), run_name="__main__")

    end, planted = re.findall(r"\d\.\d{3}", capsys.readouterr().out)
    assert float(planted) == PLANTED
    assert abs(float(end) - PLANTED) < 0.05 * PLANTED


def test_whole_sample_by_sample_and_in_a_loop_are_the_same(
    observer: ConstantGain, recording: Recording
) -> None:
    t, psi, F_N, M_z = (getattr(recording, name)[:150] for name in ("t", "psi", "F_N", "M_z"))
    whole, single = (run(observer, t, psi, F_N, M_z, one_by_one=flag) for flag in (False, True))
    loop, dt = Loop(observer), float(t[1] - t[0])
    looped = [
        loop(Sample(psi=p, psi_dot=np.nan, F_N=F, dt=dt, M_z=M)).mu
        for p, F, M in zip(psi, F_N, M_z, strict=True)
    ]

    np.testing.assert_allclose(single.mu, whole.mu, rtol=1e-12)
    np.testing.assert_allclose(looped, whole.mu, rtol=1e-9)


@pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
def test_c_is_the_same(observer: ConstantGain, recording: Recording, tmp_path: Path) -> None:
    code = generate_code(observer, DOUBLE, tmp_path)
    dt = np.full(300, recording.t[1] - recording.t[0])
    nothing = np.full(300, np.nan)
    rows = np.column_stack([recording.psi[:300], nothing, recording.M_z[:300], recording.F_N[:300], dt])
    rows[100:120, 0] = rows[150:160, 2] = rows[200, 3] = np.nan

    np.testing.assert_allclose(code.run(rows), python_estimates(observer, rows), rtol=1e-9, atol=1e-12)
    assert "constantgain" in (tmp_path / "brushgrip.json").read_text("utf-8")


def test_an_observer_without_functions_is_refused(recording: Recording, tmp_path: Path) -> None:
    solver = RootObserver(rig=recording.rig, k=recording.tyre.k)

    message = refused(generate, solver, tmp_path)
    for told in ("casadi Functions, got RootObserver", "observers.FunctionObserver", "step_function"):
        assert told in message


def test_fields_of_an_object_may_be_the_observer(observer: ConstantGain, tmp_path: Path) -> None:
    names = ("model", "values", "rig", "name", "title", "layout", "initial_function", "step_function",
             "constants", "constant_labels", "informed_below", "prior", "settings", "channel", "init",
             "step", "estimate")  # fmt: skip
    fields = SimpleNamespace(**{name: getattr(observer, name) for name in names})
    generate(observer, tmp_path / "class")
    generate(fields, tmp_path / "fields")

    for path in sorted((tmp_path / "class").iterdir()):
        assert (tmp_path / "fields" / path.name).read_bytes() == path.read_bytes()

    del fields.constants
    with pytest.raises(InvalidInputError, match=r"got SimpleNamespace without constants$"):
        generate(fields, tmp_path / "fields")


@dataclass(frozen=True, kw_only=True, eq=False)
class WithTables(ConstantGain):
    """Settings that JSON does not have."""

    table: Array
    limits: dict[Any, Any]
    folder: Path = Path("some") / "where"


def test_settings_of_any_type_are_in_the_parameters(recording: Recording, tmp_path: Path) -> None:
    limits = {1: (np.float64(2.0), float("-inf")), "unknown": float("nan"), "on": True, "none": None}
    table = np.array([[1.0, np.inf], [0.5, 2.0]])
    own = WithTables(model=MODEL, values=VALUES, rig=recording.rig, table=table, limits=limits)
    generate(own, tmp_path)

    parameters = json.loads((tmp_path / "brushgrip.json").read_text("utf-8"))
    assert parameters["table"] == [[1.0, "inf"], [0.5, 2.0]]
    assert parameters["limits"] == {"1": [2.0, "-inf"], "unknown": "nan", "on": True, "none": None}
    assert parameters["folder"] == str(Path("some") / "where")
