"""C in one floating-point type: no literal and no function of another.

casadi writes its constants as doubles and calls sqrt, not sqrtf, whatever casadi_real is; on a target
with a single-precision unit every step would then run through emulated double arithmetic. Templates are
written for double as well. Here every real literal gets the suffix of the type, and the functions of
math.h their names in it, token by token.
"""

import re
from collections import Counter
from collections.abc import Iterator

from observers.embedded.scalar_type import Real
from symbolic import InvalidInputError

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


def in_type(source: str, real: Real) -> str:
    """C in which every real literal and every function of math.h is of one type.

    Raises:
        InvalidInputError: a constant is beyond the type.
    """
    return "".join(_typed(kind, token, real) for kind, token in tokens(source))


def tokens(source: str) -> Iterator[tuple[str, str]]:
    """Kind and text of every token of C, white space among them, so that joined they are the source."""
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
