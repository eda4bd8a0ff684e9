"""CasADi's generated C reduced to what an embedded target compiles.

`casadi.CodeGenerator` is asked for the types, the include files, NAN and INFINITY, and no exported
symbols. No option of it leaves out the functions that describe a Function to CasADi itself and the
branches for compilers before C99, makes the helpers static, or writes comparisons that compile without
a warning: `embedded_code` rewrites these. Neither an operation nor the order of operations changes.
Text that the rewriting does not know is an error that names the version of CasADi.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca

from observers.embedded.scalar_type import MATH_FUNCTIONS, Real, code_in_type, count_names
from symbolic import BrushgripError

CONDITIONS = {
    "#ifdef CASADI_CODEGEN_PREFIX": False,
    "#if __STDC_VERSION__ < 199901L": False,
    "#ifndef casadi_real": True,
    "#ifndef casadi_int": True,
    "#ifndef casadi_nan": True,
    "#ifndef casadi_inf": True,
}
"""Every preprocessor condition that CasADi writes, and its value in generated code."""
COMMENTS = (
    "/* How to prefix internal symbols */",
    "/* Pre-c99 compatibility */",
    "/* Configuration this file was compiled with */",
)
"""Comments on what is left out."""
DEFINITION = re.compile(
    r"^(?P<type>(?:const )?\w+\*?) (?P<name>\w+)\([^)]*\) ?\{(?:[^\n]+\}|\n.*?^\})\n+", re.M | re.S
)
"""A function that is not static."""
STATIC_FUNCTION = re.compile(r"^(static int \w+)\(([^)\n]*)\) ?\{\n(.*?)^\}", re.M | re.S)
TABLE = re.compile(r"^static const casadi_(?:int|real) (\w+)\[\d+\] = \s*\{[^}]*\};\n", re.M)
SCALARS = re.compile(r"^  casadi_real [^;\n]*\bw\d+[^;\n]*;$", re.M)
EXTREMES = (
    ("static casadi_real casadi_fmin(", "static inline casadi_real casadi_fmin("),
    ("static casadi_real casadi_fmax(", "static inline casadi_real casadi_fmax("),
    ("return fmin(x, y);", "return x < y || y != y ? x : y;"),
    ("return fmax(x, y);", "return x > y || y != y ? x : y;"),
)
"""fmin and fmax of math.h, NaN included, without the library call that they are on some targets."""
_OPERAND = r"(?:[aw]\d+|\(\*c[rs]\+\+\)|\*c[rs]\+\+|c[rs]\[i\])"
COMPARISONS = (
    (re.compile(rf"\(({_OPERAND})\?({_OPERAND}):0\)"), r"((\1!=0.0)?\2:0.0)"),
    (re.compile(rf"\(({_OPERAND})\?"), r"((\1!=0.0)?"),
    (re.compile(rf"\(! ?({_OPERAND}) ?\)"), r"(\1==0.0)"),
    (re.compile(rf"\(({_OPERAND})(&&|\|\|)({_OPERAND})\)"), r"((\1!=0.0)\2(\3!=0.0))"),
    (re.compile(r"^(  a\d+=)(\([^?;\n]*(?:<|[!=<]=|&&|\|\|)[^?;\n]*\));$", re.M), r"\1\2 ? 1.0 : 0.0;"),
)
"""Real numbers as truth values and truth values as real numbers, which compilers and MISRA C warn of."""
_SIZES = r".*?".join(rf"\*sz_{name} = (\d+);" for name in ("arg", "res", "iw", "w"))
_KEYWORDS = frozenset({"if", "for", "while", "switch", "return", "sizeof", "defined"})


@dataclass(frozen=True, kw_only=True)
class EmbeddedCode:
    """C of some Functions, and the work space that any of them needs."""

    # The C, all of it static; each Function is `int f(arg, res, iw, w, mem)` under its own name.
    text: str
    arg: int  # Length of the array of pointers to inputs.
    res: int  # Length of that of pointers to outputs.
    iw: int  # Integers of work space.
    w: int  # Reals of work space.


def embedded_code(functions: Sequence[ca.Function], real: Real, prefix: str) -> EmbeddedCode:
    """C99 of Functions of unique names in one type; the names of helpers begin with the prefix.

    InvalidInputError where a constant is beyond the type, BrushgripError where CasADi writes what is not
    known here.
    """
    text = resolve_preprocessor_ifs(casadi_text(functions, real, prefix))
    names = frozenset(function.name() for function in functions)
    arg, res, iw, w = map(max, zip(*(work_sizes(text, name) for name in names), strict=True))
    text = DEFINITION.sub(lambda match: _make_static_or_drop(match, names), text)
    for old, new in EXTREMES:
        text = text.replace(old, new)
    for pattern, replacement in COMPARISONS:
        text = pattern.sub(replacement, text)
    text = STATIC_FUNCTION.sub(_mark_unused_and_init_work, text)
    # Each table has a macro that gives it its prefix, and its definition; those not used are left out.
    count = count_names(text)
    text = TABLE.sub(lambda match: match.group() if count[match[1]] > 2 else "", text)
    text = code_in_type(text, real)
    _check_rewritten_c(text, names, real)
    return EmbeddedCode(text=text, arg=arg, res=res, iw=iw, w=w)


def casadi_text(functions: Sequence[ca.Function], real: Real, prefix: str) -> str:
    """The C that CasADi itself writes, with all that its options can do."""
    options: dict[str, Any] = {
        "casadi_real": real.c_type,
        "casadi_int": "int32_t",
        "with_header": False,
        "with_export": False,
        # math.h has NAN and INFINITY as floats, which would be promoted implicitly.
        "nan": "((casadi_real)NAN)",
        "infinity": "((casadi_real)INFINITY)",
    }
    generator = ca.CodeGenerator(f"{prefix}.c", options)
    generator.add_include("stdint.h")
    for function in functions:
        generator.add(function)
    text: str = generator.dump()
    return text


def work_sizes(text: str, name: str) -> tuple[int, ...]:
    """Lengths of arg, res, iw and w of a Function, from its C: less than `Function.sz_w` says."""
    match = re.search(rf"int {name}_work\(.*?{_SIZES}", text, re.S)
    if match is None:
        raise _unsupported_c_error(f"no work sizes of {name}")
    return tuple(map(int, match.groups()))


def resolve_preprocessor_ifs(text: str) -> str:
    """The branches of preprocessor conditions that hold, without the conditions."""
    lines, branches = [], [True]
    for line in text.splitlines():
        directive = line.strip()
        if directive.startswith("#if"):
            if directive not in CONDITIONS:
                raise _unsupported_c_error(f"the condition {directive!r}")
            branches.append(CONDITIONS[directive])
        elif directive == "#else":
            branches[-1] = not branches[-1]
        elif directive == "#endif":
            branches.pop()
        elif all(branches) and directive not in COMMENTS:
            lines.append(directive if directive.startswith("#") else line)
    return "\n".join(lines) + "\n"


def _make_static_or_drop(match: re.Match[str], names: frozenset[str]) -> str:
    """A helper or one of the Functions, static; nothing for a function that describes them to CasADi."""
    needed = match["name"].startswith("casadi_") or match["name"] in names
    return f"static {match.group()}" if needed else ""


def _mark_unused_and_init_work(match: re.Match[str]) -> str:
    """A function with its unused parameters marked and its scalar work variables set to 0."""
    head, parameters, body = match.groups()
    used = count_names(body)
    declared = [parameter.split()[-1].lstrip("*") for parameter in parameters.split(",")]
    unused = "".join(f"  (void) {name};\n" for name in declared if name not in used)
    # CasADi sets some of these through pointers only, which static checkers do not follow.
    body = SCALARS.sub(lambda line: re.sub(r"\b(w\d+)(?=[,;])", r"\1=0", line.group()), body)
    return f"{head}({parameters}) {{\n{unused}{body}}}"


def _check_rewritten_c(text: str, names: frozenset[str], real: Real) -> None:
    """Raise `BrushgripError` unless the code is what the rewriting is for."""
    if (exported := re.search(r"^(?!static )\w.*", text, re.M)) is not None:
        raise _unsupported_c_error(f"{exported.group()!r}, which is not static")
    if missing := [name for name in sorted(names) if f"static int {name}(" not in text]:
        raise _unsupported_c_error(f"no function {missing[0]}")
    known = {f"{name}{real.suffix}" for name in MATH_FUNCTIONS - {"fmin", "fmax"}} | _KEYWORDS | names
    called = set(re.findall(r"\b([A-Za-z_]\w*)\(", re.sub(r"/\*.*?\*/", "", text, flags=re.S)))
    if unknown := sorted(name for name in called - known if not name.lower().startswith("casadi_")):
        raise _unsupported_c_error(f"a call of {unknown[0]}")


def _unsupported_c_error(what: str) -> BrushgripError:
    version = ca.CasadiMeta.version()
    return BrushgripError(f"CasADi {version} writes C that cannot be rewritten for a target: {what}")
