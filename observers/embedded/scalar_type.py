"""The floating-point type of a target, and text of C in that type, with names of its own.

CasADi writes constants as doubles and calls sqrt, not sqrtf, whatever `casadi_real` is; on a target with
a single-precision unit every step would then run through emulated double arithmetic. The templates are
written for double as well.
"""

import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from symbolic import InvalidInputError

MATH_FUNCTIONS = frozenset(
    {
        "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "ceil", "copysign", "cos", "cosh",
        "erf", "exp", "expm1", "fabs", "floor", "fmax", "fmin", "fmod", "hypot", "log", "log1p", "pow",
        "remainder", "sin", "sinh", "sqrt", "tan", "tanh",
    }
)  # fmt: skip
"""The functions of math.h that generated code may call."""
TOKEN = re.compile(
    r"""(?P<comment>/\*.*?\*/|//[^\n]*)
      | (?P<string>"(?:\\.|[^"\\])*"|'(?:\\.|[^'\\])*')
      | (?P<name>[A-Za-z_]\w*)
      | (?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\w*)
      | (?P<newline>\n)
      | (?P<other>.)""",
    re.VERBOSE | re.DOTALL,
)
REAL_LITERAL = re.compile(r"(?:\d+\.\d*|\.\d+)(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+")

_STATIC = re.compile(r"^static [\w \t*]*?\b(\w+)\s*(?:\(|\[|=|;)", re.MULTILINE)
_MACRO = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)", re.MULTILINE)
_TYPE = re.compile(r"^} (\w+);", re.MULTILINE)
_ENUM = re.compile(r"^enum \{(.*?)\};", re.MULTILINE | re.DOTALL)
_CONSTANT = re.compile(r"(?:^|,)\s*(\w+)")


@dataclass(frozen=True, kw_only=True)
class Real:
    """A floating-point type of C."""

    c_type: str  # Its name in C.
    suffix: str  # Of its literals, and of the names of its functions in math.h.
    dtype: type[np.floating]  # The same type in NumPy.
    digits: int  # Significant decimal digits that distinguish any two numbers.
    greatest: float  # Largest finite number.

    def literal(self, value: float) -> str:
        """A number as a literal of C; NAN and INFINITY are those of math.h."""
        # What overflows is infinite, without a warning.
        with np.errstate(over="ignore"):
            rounded = float(self.dtype(value))
        if np.isnan(rounded):
            return f"({self.c_type})NAN"
        if np.isinf(rounded):
            return f"({self.c_type}){'-' * (rounded < 0)}INFINITY"
        return f"{rounded:.{self.digits - 1}e}{self.suffix}"

    @property
    def size(self) -> int:
        """Bytes of a number."""
        return np.dtype(self.dtype).itemsize

    def round(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """The nearest numbers of this type, as float64."""
        return np.asarray(values).astype(self.dtype).astype(float)


SINGLE = Real(
    c_type="float", suffix="f", dtype=np.float32, digits=9, greatest=float(np.finfo(np.float32).max)
)
"""IEEE single precision, what the floating-point unit of a Cortex-M4F computes."""
DOUBLE = Real(
    c_type="double", suffix="", dtype=np.float64, digits=17, greatest=float(np.finfo(np.float64).max)
)
"""IEEE double precision, the same as in Python."""


def code_in_type(code: str, real: Real) -> str:
    """C with its real literals and functions of math.h in one type; a constant beyond it is refused."""
    return "".join(_typed(kind, token, real) for kind, token in tokens(code))


def tokens(code: str) -> Iterator[tuple[str, str]]:
    """Kind and text of every token of C, white space included: joined, the texts are the code."""
    for match in TOKEN.finditer(code):
        yield str(match.lastgroup), match.group()


def count_names(code: str) -> Counter[str]:
    """How often each identifier occurs in C outside comments and strings."""
    return Counter(token for kind, token in tokens(code) if kind == "name")


def _typed(kind: str, token: str, real: Real) -> str:
    if kind == "name" and token in MATH_FUNCTIONS:
        return token + real.suffix
    if kind == "number" and REAL_LITERAL.fullmatch(token):
        if abs(float(token)) > real.greatest:
            raise InvalidInputError(f"the constant {token} is beyond the type {real.c_type}")
        return token + real.suffix
    return token


def defined_names(text: str) -> frozenset[str]:
    """Names that a file of C defines for itself: static functions and tables, types, macros, constants.

    They are found where they are defined at the beginning of a line.
    """
    code = "".join(" " if kind == "comment" else token for kind, token in tokens(text))
    constants = (_CONSTANT.findall(inside) for inside in _ENUM.findall(code))
    found = [_STATIC.findall(code), _MACRO.findall(code), _TYPE.findall(code), *constants]
    return frozenset(name for names in found for name in names)


def prefix_own_c_names(text: str, name: str) -> str:
    """A file of C whose own names begin with `name`, so that several can be one translation unit.

    Names that do so already stay, as do those in comments and strings, behind a dot or an arrow.
    """
    taken = (f"{name}_", f"{name.upper()}_")
    own = {n for n in defined_names(text) if not n.startswith(taken)}

    renamed, before = [], ""
    for kind, token in tokens(text):
        is_own = kind == "name" and token in own and not before.endswith((".", "->"))
        renamed.append(f"{taken[token.isupper()]}{token}" if is_own else token)
        if kind != "comment":
            before = (before + token.strip())[-2:]
    return "".join(renamed)
