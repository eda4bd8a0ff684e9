"""Loops over vectors compute what CasADi computes."""

import ctypes
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from observers.embedded.c_loops_over_vectors import c_function_with_loops
from observers.embedded.vectors_by_c_loop import Known
from observers.quality.mu_and_scale_from_hypotheses import build_hypotheses_verdict
from observers.quality.mu_over_k_hypotheses import RATIOS, SETTINGS, hypothesis_fields
from symbolic import BrushgripError, compiler
from symbolic.compilation.scalar_c import c_function
from tests.compile_once import compile_once
from tests.observers.embedded.generated_code import needs_compiler

COUNT = 5
HEAD = """#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#define natural_log log
#define lesser fmin
#define greater fmax
"""


def compiled(function: ca.Function, count: int, folder: Path, known: Known | None = None) -> ctypes.CDLL:
    """The C of a Function, as a library with `rolled`."""
    text = c_function_with_loops("rolled", function, count, "double", known or {})
    (folder / "rolled.c").write_text(HEAD + text.removeprefix("static "), "utf-8")
    command = [str(compiler()), "-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-fPIC", "-shared"]
    compile_once([*command, "rolled.c", "-o", "rolled.so", "-lm"], folder, "rolled.so")
    return ctypes.CDLL(str(folder / "rolled.so"))


def called(library: ctypes.CDLL, size: int, *inputs: np.ndarray | float) -> np.ndarray:
    result = np.empty(size)
    kept = [np.ascontiguousarray(np.ravel(given, order="F"), float) for given in inputs]
    arguments = [
        ctypes.c_double(float(given)) if np.ndim(given) == 0 else ctypes.c_void_p(array.ctypes.data)
        for given, array in zip(inputs, kept, strict=True)
    ]
    library.rolled(*arguments, ctypes.c_void_p(result.ctypes.data))
    return result


def weighted() -> ca.Function:
    """Moments about the mean, the element at the maximum and the one beside it."""
    rows, scale = ca.MX.sym("rows", 2, COUNT), ca.MX.sym("scale")
    first, second = (row.T for row in ca.vertsplit(rows))
    numbers, best = ca.DM(range(COUNT)), ca.mmax(first)
    weight = ca.exp(first - best)
    weight = weight / ca.sum1(weight)
    mean = ca.dot(weight, second)
    spread = ca.dot(weight, (second - mean) ** 2)
    place = ca.fmin(ca.mmax(numbers * (best <= first)), COUNT - 2)
    chosen, next_one = (ca.dot(numbers == place + i, second * scale) for i in (0, 1))
    result = ca.vertcat(mean, ca.if_else(spread > 1, spread, -spread), chosen, next_one, best)
    return ca.Function("weighted", [rows, scale], [result], ["rows", "scale"], ["result"], {"cse": True})


@needs_compiler
@pytest.mark.parametrize("seed", range(6))
def test_sums_maxima_and_choices(tmp_path: Path, seed: int) -> None:
    rows = np.random.default_rng(seed).normal(size=(2, COUNT)) * (1 + 3 * (seed % 2))
    function = weighted()
    actual = called(compiled(function, COUNT, tmp_path), 5, rows, 1.7)

    np.testing.assert_allclose(actual, np.asarray(function(rows, 1.7)).ravel(), rtol=1e-14)


@needs_compiler
@pytest.mark.parametrize("known", [False, True], ids=["at run time", "numbers"])
def test_the_verdict_of_the_hypotheses(tmp_path: Path, known: bool) -> None:
    rng, verdict = np.random.default_rng(5), build_hypotheses_verdict()
    limits = dict.fromkeys(SETTINGS, 0.05) | {"mu": 1.0, "mu_std": 0.5, "stiffness_std": 0.14}
    numbers = {"limits": {i: limits[name] for i, name in enumerate(SETTINGS[:3])}} if known else {}
    library = compiled(verdict, len(RATIOS), tmp_path, numbers)
    for spread in (1.0, 30.0, 500.0):
        gain = rng.uniform(0.01, 3.0, len(RATIOS))
        variance = rng.uniform(1e-9, 2.0, (2, len(RATIOS)))
        part = dict.fromkeys(hypothesis_fields(gear=False), np.zeros(len(RATIOS))) | {
            "log_likelihood": -spread * rng.random(len(RATIOS)), "gain": gain,
            "zero": rng.normal(size=len(RATIOS)), "D_gain": variance[0], "D_zero": variance[1],
            "U_zero_gain": 0.3 * np.sqrt(variance[1] / variance[0]), "left": gain,
        }  # fmt: skip
        rows = np.vstack([part[name] for name in hypothesis_fields(gear=False)])
        given = (rows, 12.0, 3.0, np.array(list(limits.values())))
        actual = called(library, verdict.numel_out(0), *given)

        np.testing.assert_allclose(actual, np.asarray(verdict(*given)).ravel(), rtol=1e-11, atol=1e-13)


def test_of_a_choice_c_computes_one_value() -> None:
    x = ca.SX.sym("x")
    either = ca.Function("either", [x], [ca.if_else(x > 1, ca.sqrt(x), ca.sin(x))], ["x"], ["y"])

    assert "y[0] = t0 ? sqrt(x) : sin(x);" in c_function("either", either, "double")
    assert "!" not in c_function_with_loops("weighted", weighted(), COUNT, "double", {})


def test_what_cannot_be_rolled_is_told() -> None:
    rows = ca.MX.sym("rows", 2, COUNT)
    function = ca.Function("norm", [rows], [ca.norm_fro(rows)], ["rows"], ["result"])

    with pytest.raises(BrushgripError, match="cannot be rolled"):
        c_function_with_loops("norm", function, COUNT, "double", {})
