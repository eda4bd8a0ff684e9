"""CasADi's C after rewriting compiles without a warning and computes the same."""

import ctypes
import re
import subprocess
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from observers.embedded import casadi_c_reduction
from observers.embedded.casadi_c_reduction import casadi_text, embedded_code
from observers.embedded.scalar_type import DOUBLE, SINGLE, Real, count_names
from observers.quality.mu_and_scale_from_hypotheses import build_hypotheses_verdict
from symbolic import BrushgripError, compiler
from tests.observers.embedded.generated_code import STRICT, needs_compiler


def everything() -> ca.Function:
    """A Function with the idioms that casadi writes: calls, conditions, picking, sparse products."""
    x, n = ca.MX.sym("x", 3), ca.MX.sym("n")
    s = ca.SX.sym("s", 3)
    either = ca.if_else(s[0] > 0, ca.exp(s[1]) + 1e-3 * s[2], ca.fmax(s, 2.5))
    inner = ca.Function("inner", [s], [either])
    picked = ca.vertcat(0, x).nz[ca.fmin(ca.fabs(n), 3)]
    y = inner(x) * ca.logic_not(n) + ca.if_else(ca.logic_and(x > 0, n < 2), ca.sqrt(ca.fabs(x)), x**2.5)
    diagonal = ca.MX(ca.Sparsity.diag(3), x)
    outputs = [y + diagonal @ y, picked, ca.mmax(x)]
    return ca.Function("everything", [x, n], outputs, ["x", "n"], list("abc"))


@needs_compiler
@pytest.mark.parametrize("real", [SINGLE, DOUBLE], ids=["float", "double"])
def test_rewritten_code_computes_the_same(tmp_path: Path, real: Real) -> None:
    function = everything()
    code = embedded_code([function], real, "pre")
    number, size = real.c_type, f"[{max(code.w, 1)}]"
    wrapper = (
        f"void call(const {number} *x, const {number} *n, {number} *y) {{\n"
        f"  const {number} *arg[{code.arg}] = {{x, n}};\n"
        f"  {number} *res[{code.res}] = {{y, y+3, y+4}};\n"
        f"  {number} w{size};\n  int32_t iw[{code.iw + 1}];\n  everything(arg, res, iw, w, 0);\n}}\n"
    )
    (tmp_path / "f.c").write_text(f"{code.text}\n{wrapper}")
    flags = [*STRICT, "-O1", "-ffp-contract=off", "-fPIC", "-shared"]
    subprocess.run([str(compiler()), *flags, "f.c", "-o", "f.so", "-lm"], cwd=tmp_path, check=True)
    library = ctypes.CDLL(str(tmp_path / "f.so"))
    for x, n in [([1.0, -2.0, 0.5], 0.0), ([-1.0, 0.25, 3.0], 3.0), ([0.0, 0.0, -0.5], 1.0)]:
        inputs, output = (np.array(x, real.dtype), np.array([n], real.dtype)), np.zeros(5, real.dtype)
        library.call(*(ctypes.c_void_p(array.ctypes.data) for array in (*inputs, output)))
        expected = np.concatenate([part.full().ravel() for part in function(x, n)])
        np.testing.assert_allclose(output, expected, rtol=1e-6 if real is SINGLE else 0)


def test_nothing_is_exported_and_nothing_is_left_for_casadi() -> None:
    text = embedded_code([everything()], SINGLE, "pre").text
    names = count_names(text)

    assert not {"everything_n_in", "everything_work", "CASADI_SYMBOL_EXPORT", "double"} & set(names)
    assert "long long" not in text
    assert not [line for line in text.splitlines() if line.startswith(("int ", "void ", "casadi_real "))]


@pytest.mark.parametrize(
    "name",
    [
        "CONDITIONS", "COMMENTS", "DEFINITION", "STATIC_FUNCTION", "TABLE", "SCALARS", "EXTREMES",
        "COMPARISONS",
    ],
)  # fmt: skip
def test_casadi_writes_what_is_rewritten(name: str) -> None:
    x = ca.SX.sym("x")
    ratio = ca.Function("ratio", [x], [ca.if_else(ca.logic_or(x > 0, ca.logic_not(x)), 1 / x, ca.inf)])
    text = casadi_text([everything(), ratio, build_hypotheses_verdict()], SINGLE, "pre")
    piece = getattr(casadi_c_reduction, name)
    pieces = [piece] if isinstance(piece, re.Pattern) else list(piece)
    patterns = [pattern[0] if isinstance(pattern, tuple) else pattern for pattern in pieces]
    absent = [
        pattern
        for pattern in patterns
        if re.search(pattern if isinstance(pattern, re.Pattern) else as_written(pattern), text) is None
    ]

    assert not absent, (
        f"CasADi {ca.CasadiMeta.version()} does not write {absent}:"
        f" revise {name} in observers/embedded/casadi_c_reduction.py"
    )


def as_written(literal: str) -> str:
    """A pattern for the text before the rewriting makes functions static."""
    return re.escape(literal.removeprefix("static "))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("#if __STDC_VERSION__ < 199901L", "#if __STDC_VERSION__ < 201112L", "condition '#if __STDC"),
        ("*sz_iw = ", "*size_iw = ", "no work sizes of everything"),
        ("\nvoid casadi_copy(", "\nextern void casadi_copy(", "'extern void casadi_copy"),
        ("int everything(", "int everything_else(", "no function everything"),
        ("exp(", "cbrt(", "a call of cbrt"),
        ("fmax(x, y)", "fmax(y, x)", "a call of fmax"),
    ],
)
def test_unknown_text_is_an_error(
    monkeypatch: pytest.MonkeyPatch, old: str, new: str, message: str
) -> None:
    text = casadi_text([everything()], SINGLE, "pre")
    assert old in text
    monkeypatch.setattr(casadi_c_reduction, "casadi_text", lambda *_: text.replace(old, new))
    version = re.escape(ca.CasadiMeta.version())

    with pytest.raises(BrushgripError, match=rf"CasADi {version} .*{re.escape(message)}"):
        embedded_code([everything()], SINGLE, "pre")
