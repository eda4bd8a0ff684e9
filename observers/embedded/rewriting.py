"""casadi's C made fit for an embedded target.

casadi's generator knows `casadi_real` and `casadi_int`, but it writes its constants as doubles and calls
sqrt, not sqrtf, whatever casadi_real is; so on a target with a single-precision unit every step would
run through emulated double arithmetic. It also exports every helper and writes functions that describe
the Function to casadi itself. Here all of that is put right, token by token:

- a real literal gets the suffix of the type, and one that the type cannot hold is refused;
- functions of math.h get their names in the type;
- everything is static but nothing else is changed: no operation, and not their order;
- of the functions for casadi's own use nothing is left.
"""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import casadi as ca

from observers.embedded.reals import Real
from symbolic.errors import BrushgripError, InvalidInputError

MATHS = frozenset(
    {
        "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "ceil", "copysign", "cos", "cosh",
        "erf", "exp", "expm1", "fabs", "floor", "fmax", "fmin", "fmod", "hypot", "log", "log1p", "pow",
        "remainder", "sin", "sinh", "sqrt", "tan", "tanh",
    }
)  # fmt: skip
"""What casadi calls of math.h."""
TOKEN = re.compile(
    r"""(?P<comment>/\*.*?\*/|//[^\n]*)
      | (?P<text>"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*')
      | (?P<name>[A-Za-z_]\w*)
      | (?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\w*)
      | (?P<line>\n)
      | (?P<other>.)""",
    re.VERBOSE | re.DOTALL,
)
REAL_NUMBER = re.compile(r"(?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+")
EXPORTED = re.compile(
    r"^CASADI_SYMBOL_EXPORT [^\n]*?(\w+)\([^\n]*?\) *\{(?:[^\n]+\}|\n.*?^\})\n+", re.M | re.S
)
VISIBILITY = re.compile(r"^/\* Symbol visibility in DLLs \*/\n#ifndef.*?^#endif\n\n", re.M | re.S)
HELPER = re.compile(r"^(?=(?:casadi_real|void|casadi_int|int) casadi_\w+\()", re.M)
TABLE = re.compile(r"^static const casadi_(?:int|real) (\w+)\[\d+\] = \s*\{[^}]*\};\n", re.M)
ENTRY = re.compile(r"^(static int \w+)\(([^)\n]*)\) ?\{\n(.*?)^\}", re.M | re.S)
WORK = r"int {}_work\(.*?\*sz_arg = (\d+);.*?\*sz_res = (\d+);.*?\*sz_iw = (\d+);.*?\*sz_w = (\d+);"


@dataclass(frozen=True, kw_only=True)
class Source:
    """C of some Functions, and the room that any of them needs.

    Attributes:
        text: the C, all static; each Function is `int f(arg, res, iw, w, mem)` by its own name.
        arg, res: length of the arrays of pointers to inputs and outputs.
        iw, w: integers and reals of scratch.
    """

    text: str
    arg: int
    res: int
    iw: int
    w: int


def embedded_source(functions: Sequence[ca.Function], real: Real, prefix: str) -> Source:
    """C99 of Functions in one type.

    Args:
        functions: what is to be called, their names unique.
        real: the type of every number.
        prefix: begins the names of the helpers, which may collide where two files are joined.

    Raises:
        InvalidInputError: a constant is beyond the type.
    """
    generator = ca.CodeGenerator(
        f"{prefix}.c",
        {"casadi_real": real.c_type, "casadi_int": "int32_t", "with_header": False},
    )
    for function in functions:
        generator.add(function)
    text = generator.dump()
    names = [function.name() for function in functions]
    room = [[int(size) for size in _work(text, name)] for name in names]
    arg, res, iw, w = (max(sizes) for sizes in zip(*room, strict=True))
    text = VISIBILITY.sub("", EXPORTED.sub(lambda found: _hidden(found, names), text))
    text = text.replace("/* Configuration this file was compiled with */\n", "")
    text = ENTRY.sub(_used_parameters, HELPER.sub("static ", text))
    # math.h has NAN and INFINITY as floats; a promotion that is not written is one that was not meant.
    for macro in ("NAN", "INFINITY"):
        text = text.replace(f" {macro}\n", f" ((casadi_real){macro})\n")
    text = text.replace("#include <math.h>", "#include <math.h>\n#include <stdint.h>", 1)
    return Source(text=in_type(_used_tables(text), real), arg=arg, res=res, iw=iw, w=w)


def in_type(source: str, real: Real) -> str:
    """C in which every real literal and every function of math.h is of one type.

    Raises:
        InvalidInputError: a constant is beyond the type.
    """
    return "".join(_typed(kind, token, real) for kind, token in tokens(source))


def tokens(source: str) -> Iterator[tuple[str, str]]:
    """Kind and text of every token of C, white space and comments included; joined they are the source."""
    for found in TOKEN.finditer(source):
        yield str(found.lastgroup), found.group()


def names_in(source: str) -> Counter[str]:
    """How often each name occurs in C, comments and texts aside."""
    return Counter(token for kind, token in tokens(source) if kind == "name")


def _typed(kind: str, token: str, real: Real) -> str:
    if kind == "name" and token in MATHS:
        return token + real.suffix
    if kind == "number" and REAL_NUMBER.fullmatch(token):
        if abs(float(token)) > real.greatest:
            raise InvalidInputError(f"the constant {token} is beyond the type {real.c_type}")
        return token + real.suffix
    return token


def _work(text: str, name: str) -> tuple[str, ...]:
    found = re.search(WORK.format(re.escape(name)), text, re.S)
    if found is None:
        raise BrushgripError(f"casadi {ca.__version__} does not say what room {name} needs")
    return found.groups()


def _hidden(found: re.Match[str], kept: Sequence[str]) -> str:
    """A function that casadi exports, kept from the linker; nothing of one that only describes."""
    if found.group(1) not in kept:
        return ""
    return found.group().replace("CASADI_SYMBOL_EXPORT", "static", 1)


def _used_parameters(found: re.Match[str]) -> str:
    """A function that says which of its parameters it does not use."""
    head, parameters, body = found.groups()
    used = names_in(body)
    declared = [parameter.split()[-1].lstrip("*") for parameter in parameters.split(",")]
    notes = "".join(f"  (void) {name};\n" for name in declared if name not in used)
    return f"{head}({parameters}) {{\n{notes}{body}}}"


def _used_tables(text: str) -> str:
    """Without tables that nothing reads any more."""
    count = names_in(text)
    # Each has a macro that gives it its prefix, and its definition.
    return TABLE.sub(lambda found: found.group() if count[found.group(1)] > 2 else "", text)
