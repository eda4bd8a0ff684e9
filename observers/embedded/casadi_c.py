"""casadi's C made fit for an embedded target.

casadi exports every helper, describes each Function to itself, serves compilers before C99, and asks for
truth without a comparison. None of that is of use on a target, and some of it draws warnings. No
operation is changed here, and no order of operations; `observers.embedded.literals` puts all of it
into one type.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from observers.embedded.literals import in_type, names_in
from observers.embedded.scalar_type import Real
from symbolic import BrushgripError

EXPORTED = re.compile(
    r"^CASADI_SYMBOL_EXPORT [^\n]*?(\w+)\([^\n]*?\) *\{(?:[^\n]+\}|\n.*?^\})\n+", re.M | re.S
)
VISIBILITY = re.compile(r"^/\* Symbol visibility in DLLs \*/\n#ifndef.*?^#endif\n\n", re.M | re.S)
HELPER = re.compile(r"^(?=(?:casadi_real|void|casadi_int|int) casadi_\w+\()", re.M)
TABLE = re.compile(r"^static const casadi_(?:int|real) (\w+)\[\d+\] = \s*\{[^}]*\};\n", re.M)
ENTRY = re.compile(r"^(static int \w+)\(([^)\n]*)\) ?\{\n(.*?)^\}", re.M | re.S)
_TRUTH = r"(?:[aw]\d+|\(\*c[rs]\+\+\)|\*c[rs]\+\+|c[rs]\[i\])"
ASKED = (
    (re.compile(r"(arg\[\d+\]) ?\? ?(\1\[\d+\]) : 0;"), r"\2;"),
    (re.compile(r"if \((res\[\d+\])(?:!=0)?\) (\1\[\d+\])"), r"\2"),
)
"""Whether an input or output of scalars is given at all."""
FUNCTIONS = (
    (re.compile(r"return fmin\(x, y\);"), "return x < y || y != y ? x : y;"),
    (re.compile(r"return fmax\(x, y\);"), "return x > y || y != y ? x : y;"),
    (re.compile(r"^casadi_real casadi_f(min|max)", re.M), r"static inline casadi_real casadi_f\1"),
)
"""The same as those of math.h, NaN included, which on some targets are calls that classify both."""
SCALARS = re.compile(r"^  casadi_real [^;\n]*\bw\d+[^;\n]*;$", re.M)
PLAINER = (
    (VISIBILITY, ""),
    (re.compile(r"^/\* Configuration this file was compiled with \*/\n", re.M), ""),
    (
        re.compile(
            r"^/\* How to prefix .*?^#else\n *(#define CASADI_PREFIX[^\n]*\n)#endif\n", re.M | re.S
        ),
        r"\1",
    ),
    (re.compile(r"^#ifndef (casadi_\w+)\n *(#define \1 [^\n]*\n)#endif\n", re.M), r"\2"),
    (re.compile(r"^/\* Pre-c99[^\n]*\n#if [^\n]*\n[^\n]*\n#else\n([^\n]*\n)#endif\n", re.M), r"\1"),
    # math.h has NAN and INFINITY as floats; a promotion that is not written is one that was not meant.
    (re.compile(r" (NAN|INFINITY)$", re.M), r" ((casadi_real)\1)"),
    (re.compile(r"#include <math.h>"), "#include <math.h>\n#include <stdint.h>"),
)
"""Conditions of the preprocessor that never vary, and what they leave."""
TRUTHS = (
    (re.compile(rf"\(({_TRUTH})\?"), r"(\1!=0?"),
    (re.compile(rf"\(! ?({_TRUTH}) ?\)"), r"(\1==0)"),
    (re.compile(rf"\(({_TRUTH})(&&|\|\|)({_TRUTH})\)"), r"(\1!=0\2\3!=0)"),
)
"""Numbers that casadi takes for truth values as they are; a compiler may ask whether that was meant."""
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


def embedded_source(
    functions: Sequence[ca.Function], real: Real, prefix: str, *, all_given: bool = False
) -> Source:
    """C99 of Functions in one type.

    Args:
        functions: what is to be called, their names unique.
        real: the type of every number.
        prefix: begins the names of the helpers, which may collide where two files are joined.
        all_given: every input and output is always given, so that nobody need ask.

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
    text = EXPORTED.sub(lambda found: _hidden(found, names), text)
    for pattern, instead in (*PLAINER, *FUNCTIONS, *TRUTHS, *(ASKED if all_given else ())):
        text = pattern.sub(instead, text)
    text = ENTRY.sub(_plain_entry, HELPER.sub("static ", text))
    return Source(text=in_type(_used_tables(text), real), arg=arg, res=res, iw=iw, w=w)


def _work(text: str, name: str) -> tuple[str, ...]:
    found = re.search(WORK.format(re.escape(name)), text, re.S)
    if found is None:
        raise BrushgripError(f"casadi {ca.CasadiMeta.version()} does not say what room {name} needs")
    return found.groups()


def _hidden(found: re.Match[str], kept: Sequence[str]) -> str:
    """A function that casadi exports, kept from the linker; nothing of one that only describes."""
    if found.group(1) not in kept:
        return ""
    return found.group().replace("CASADI_SYMBOL_EXPORT", "static", 1)


def _plain_entry(found: re.Match[str]) -> str:
    """A function that says which of its parameters it does not use, and whose scalars begin as 0.

    casadi sets some of them through pointers, where neither a reader nor a checker sees it.
    """
    head, parameters, body = found.groups()
    used = names_in(body)
    declared = [parameter.split()[-1].lstrip("*") for parameter in parameters.split(",")]
    notes = "".join(f"  (void) {name};\n" for name in declared if name not in used)
    body = SCALARS.sub(lambda line: re.sub(r"\b(w\d+)(?=[,;])", r"\1=0", line.group()), body)
    return f"{head}({parameters}) {{\n{notes}{body}}}"


def _used_tables(text: str) -> str:
    """Without tables that nothing reads any more."""
    count = names_in(text)
    # Each has a macro that gives it its prefix, and its definition.
    return TABLE.sub(lambda found: found.group() if count[found.group(1)] > 2 else "", text)
