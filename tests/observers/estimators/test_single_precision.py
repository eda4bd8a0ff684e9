"""Generated code in single precision: the same filter, and its covariance sound under random samples."""

import ctypes
from collections.abc import Callable
from functools import cache
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from observers import AligningTorque, Ekf, SteeringTorque, Tuning
from observers.embedded import SINGLE
from symbolic import Model
from tests.compile_once import OPTIMISATION
from tests.observers.conftest import RIG, K
from tests.observers.embedded.generated_code import (
    EFFECTS,
    GeneratedCode,
    RunningCode,
    generate_code,
    needs_compiler,
)

pytestmark = needs_compiler
STEPS = 100_000
TRIALS = {"plain": (0.0, 1e6), "harsh": (3e-4, 1e35)}
"""Share of the samples at which a channel fails for long, and wild numbers over the usual ones [1]."""
THREE = {"measurement_model": AligningTorque(stiffness=True)}
WHEEL, FIVE = (
    {"measurement_model": SteeringTorque(**more)} for more in ({}, {"zero": True, "stiffness": True})
)
SHARP: dict[str, Any] = {"noise": 1e-3, "error": inf, "gate": 5.0}
TRUSTING = SHARP | {"gate": inf, "mu_walk": 0.0, "zero_walk": 0.0}
OPEN: dict[str, Any] = {
    "mu_std": 1e3, "zero_std": 1e2, "stiffness_std": 1e2, "psi_dot_std": 1e2, "least": 1e-4,
    "greatest": 1e3,
}  # fmt: skip
CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "as it comes": ({}, {}),
    "tiny noise": ({}, SHARP),
    "tiny noise, no walk, no gate": ({}, TRUSTING),
    "huge prior": ({}, OPEN),
    "huge prior, tiny noise": ({}, OPEN | SHARP),
    "mu alone, huge prior": ({"measurement_model": AligningTorque(zero=False)}, OPEN | TRUSTING),
    "3 states": (THREE, {}),
    "3 states, huge prior, tiny noise": (THREE, OPEN | SHARP),
    "3 states, huge prior, no walk": (THREE, OPEN | TRUSTING),
    "3 states, huge prior, 3 iterations": (THREE | {"iterations": 3}, OPEN | SHARP),
    "3 states, bristles": (THREE | {"model": Model(discretised=True, bristles=40)}, SHARP),
    "carcass and rate friction": (EFFECTS, SHARP),
    "steering": (WHEEL, {}),
    "steering, 5 states": (FIVE, {}),
    "steering, 5 states, huge prior": (FIVE, OPEN | SHARP),
    "steering, 5 states, no walk": (FIVE, OPEN | TRUSTING),
}
"""Settings of the filter and of its tuning, by what is special about them."""
QUICK = {("steering", "plain"), ("steering, 5 states, huge prior", "harsh")}


@pytest.fixture(scope="module")
def code_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], GeneratedCode]:
    """The generated code of a case, each once."""

    def generated(case: str) -> GeneratedCode:
        settings, tuning = CASES[case]
        usual = {"model": Model(), "values": {"k": K}, "rig": RIG, "acquire": False}
        observer = Ekf(**{**usual, **settings, "tuning": Tuning(**tuning)})
        return generate_code(observer, SINGLE, tmp_path_factory.mktemp("single"))

    return cache(generated)


def drive(code: GeneratedCode, trial: str) -> tuple[int, np.ndarray]:
    """Sound samples, and what was seen: missing torques, resets, least and greatest D."""
    layout, n = code.observer.layout, len(code.observer.states)
    at = layout.places["factor"][0].start
    is_compact = "filter[2]" in (code.folder / "brushgrip.h").read_text()
    factor = "filter[state->now].factor" if is_compact else f"values[state->now]+{at}"
    here = Path(__file__)
    flags = [OPTIMISATION, "-fPIC", "-shared", f"-I{here.parents[1] / 'embedded'}", f"-DFACTOR={factor}"]
    sources = (code.core.name, str(here.with_name("single_precision.c")))
    library = ctypes.CDLL(str(code.compile(*flags, sources=sources, out=f"{trial}.so")))
    library.drive.restype = ctypes.c_int64
    running, seen = RunningCode(code), np.zeros(4)
    sound = library.drive(
        running.at, ctypes.c_int64(STEPS), ctypes.c_uint64(1), n,
        *map(ctypes.c_double, TRIALS[trial]), ctypes.c_void_p(seen.ctypes.data),
    )  # fmt: skip
    return sound, seen


@pytest.mark.parametrize(
    ("case", "trial"),
    [
        pytest.param(case, trial, marks=() if (case, trial) in QUICK else pytest.mark.long)
        for case in CASES
        for trial in TRIALS
    ],
)
def test_covariance_stays_positive_definite(code_of, case: str, trial: str) -> None:
    sound, (missing, resets, least, greatest) = drive(code_of(case), trial)
    print(f"{case}, {trial}: D from {least:.1e} to {greatest:.1e}, {resets:.0f} resets")

    assert sound == STEPS
    # The samples were trying: sensors failed, and the ground changed where that can be noticed.
    assert 0.04 * STEPS < missing < 0.4 * STEPS
    assert resets > 100 or code_of(case).observer.tuning.gate == inf


def test_a_negative_variance_is_noticed(code_of, tmp_path: Path) -> None:
    code = generate_code(code_of("steering").observer, SINGLE, tmp_path)
    source = tmp_path / "brushgrip.c"
    source.write_text(source.read_text().replace("factor_next[0] = ", "factor_next[0] = -"))

    assert drive(code, "plain")[0] < 10
