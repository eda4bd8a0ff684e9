"""casadi's C, tidied: what is left compiles without a word and computes the same."""

import ctypes
import subprocess
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from observers.embedded.casadi_c import embedded_source
from observers.embedded.literals import names_in
from observers.embedded.scalar_type import DOUBLE, SINGLE
from symbolic.compiled import compiler
from tests.observers.embedded.building import NO_COMPILER, STRICT


def everything() -> ca.Function:
    """A Function with the idioms that casadi writes: calls, conditions, picking, sparse products."""
    x, n = ca.MX.sym("x", 3), ca.MX.sym("n")
    s = ca.SX.sym("s", 3)
    inner = ca.Function(
        "inner", [s], [ca.if_else(s[0] > 0, ca.exp(s[1]) + 1e-3 * s[2], ca.fmax(s, 2.5))]
    )
    picked = ca.vertcat(0, x).nz[ca.fmin(ca.fabs(n), 3)]
    y = inner(x) * ca.logic_not(n) + ca.if_else(ca.logic_and(x > 0, n < 2), ca.sqrt(ca.fabs(x)), x**2.5)
    diagonal = ca.MX(ca.Sparsity.diag(3), x)
    return ca.Function(
        "everything", [x, n], [y + diagonal @ y, picked, ca.mmax(x)], ["x", "n"], list("abc")
    )


@pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
@pytest.mark.parametrize("real", [SINGLE, DOUBLE], ids=["float", "double"])
def test_says_what_casadi_says(tmp_path: Path, real: object) -> None:
    assert isinstance(real, type(SINGLE))
    function = everything()
    source = embedded_source([function], real, "pre")
    number, sizes = real.c_type, f"[{max(source.w, 1)}]"
    wrapper = (
        f"void call(const {number} *x, const {number} *n, {number} *y) {{\n"
        f"  const {number} *arg[{source.arg}] = {{x, n}};\n"
        f"  {number} *res[{source.res}] = {{y, y+3, y+4}};\n"
        f"  {number} w{sizes};\n  int32_t iw[{source.iw + 1}];\n  everything(arg, res, iw, w, 0);\n}}\n"
    )
    (tmp_path / "f.c").write_text(f"{source.text}\n{wrapper}")
    flags = [*STRICT, "-O1", "-ffp-contract=off", "-fPIC", "-shared"]
    subprocess.run([str(compiler()), *flags, "f.c", "-o", "f.so", "-lm"], cwd=tmp_path, check=True)
    library = ctypes.CDLL(str(tmp_path / "f.so"))
    for x, n in [([1.0, -2.0, 0.5], 0.0), ([-1.0, 0.25, 3.0], 3.0), ([0.0, 0.0, -0.5], 1.0)]:
        given, count, made = np.array(x, real.dtype), np.array([n], real.dtype), np.zeros(5, real.dtype)
        library.call(*(ctypes.c_void_p(array.ctypes.data) for array in (given, count, made)))
        expected = np.concatenate([part.full().ravel() for part in function(x, n)])
        np.testing.assert_allclose(made, expected, rtol=1e-6 if real is SINGLE else 0)


def test_nothing_is_exported_and_nothing_is_left_for_casadi() -> None:
    text = embedded_source([everything()], SINGLE, "pre").text
    names = names_in(text)

    assert not {"everything_n_in", "everything_work", "CASADI_SYMBOL_EXPORT", "double"} & set(names)
    assert "long long" not in text
    assert not [line for line in text.splitlines() if line.startswith(("int ", "void ", "casadi_real "))]
