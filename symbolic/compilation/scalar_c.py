"""C of a Function of scalars, statement by statement: no work vector, no pointers to pointers.

The Function is expanded to scalar operations, which are written in the order in which CasADi evaluates
them. What is used once stands where it is used, a condition is a `bool`, a choice is `?:`. Steps between
may have a comment and be no results.
"""

import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from symbolic.errors import BrushgripError
from symbolic.float_array_type import Array

INFIX = {
    ca.OP_ADD: "+", ca.OP_SUB: "-", ca.OP_MUL: "*", ca.OP_DIV: "/", ca.OP_LT: "<", ca.OP_LE: "<=",
    ca.OP_EQ: "==", ca.OP_NE: "!=", ca.OP_AND: "&&", ca.OP_OR: "||",
}  # fmt: skip
CALLS = {
    ca.OP_SQRT: "sqrt", ca.OP_EXP: "exp", ca.OP_LOG: "natural_log", ca.OP_POW: "pow",
    ca.OP_CONSTPOW: "pow", ca.OP_FABS: "fabs", ca.OP_FMIN: "lesser", ca.OP_FMAX: "greater",
    ca.OP_TANH: "tanh", ca.OP_SIN: "sin", ca.OP_COS: "cos", ca.OP_TAN: "tan", ca.OP_SINH: "sinh",
    ca.OP_COSH: "cosh", ca.OP_ASIN: "asin", ca.OP_ACOS: "acos", ca.OP_ATAN: "atan",
    ca.OP_ATAN2: "atan2", ca.OP_ERF: "erf", ca.OP_LOG1P: "log1p", ca.OP_EXPM1: "expm1",
    ca.OP_FLOOR: "floor", ca.OP_CEIL: "ceil", ca.OP_FMOD: "fmod", ca.OP_ASINH: "asinh",
    ca.OP_ACOSH: "acosh", ca.OP_ATANH: "atanh", ca.OP_HYPOT: "hypot", ca.OP_COPYSIGN: "copysign",
}  # fmt: skip
"""Functions of math.h, and those of `templates/elementary_functions.c`."""
ELEMENTARY = ("natural_log", "lesser", "greater")
"""Functions of `templates/elementary_functions.c`."""
COMPARISONS = frozenset({ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE})
LOGIC = frozenset({ca.OP_AND, ca.OP_OR, ca.OP_NOT})
TWICE_USED = frozenset({ca.OP_SQ, ca.OP_TWICE, ca.OP_SIGN})
"""Operations whose C has the operand in it more than once."""
MAX_INLINE_LENGTH = 80
"""Length of a part of an expression that stands where it is used."""


@dataclass(frozen=True)
class CExpression:
    """C of a value."""

    # An expression; an operand of another one as it stands if it is a name, a number or a call.
    text: str
    is_condition: bool = False  # A `bool`, no real.
    # Condition and value of a term that is 0 where the condition does not hold.
    value_if: tuple[str, str] | None = None


@dataclass
class _StatementWriter:
    real: str
    statements: list[str] = field(default_factory=list)

    def store_in_variable(self, term: CExpression, about: str = "") -> CExpression:
        """The term as a variable of its own, unless it is a name or a number already."""
        if re.fullmatch(r"[\w.[\]]+", term.text):
            begin = (f"    const {self.real} {term.text} = ", f"    const bool {term.text} = ")
            for i, statement in enumerate(self.statements):
                if statement.startswith(begin) and about not in statement:
                    self.statements[i] = statement + about
            return term
        name = f"t{len(self.statements)}"
        kind = "bool" if term.is_condition else self.real
        self.statements.append(f"    const {kind} {name} = {unparenthesised(term.text)};{about}")
        return CExpression(name, term.is_condition)


def as_real(term: CExpression) -> str:
    """C of a value as a number."""
    return f"({term.text} ? 1.0 : 0.0)" if term.is_condition else term.text


def c_operation(code: int, terms: Sequence[CExpression]) -> CExpression:
    """C of one operation; BrushgripError where it has none here."""
    if code in LOGIC or (code == ca.OP_IF_ELSE_ZERO):
        conditions = [t.text if t.is_condition else f"({t.text} != 0.0)" for t in terms]
        if code == ca.OP_NOT:
            return CExpression(f"(!{conditions[0]})", True)
        if code == ca.OP_IF_ELSE_ZERO:
            value = as_real(terms[1])
            return CExpression(f"({conditions[0]} ? {value} : 0.0)", value_if=(conditions[0], value))
        return CExpression(f"({conditions[0]} {INFIX[code]} {conditions[1]})", True)
    if code == ca.OP_ADD and all(term.value_if for term in terms):
        # CasADi's if_else adds two choices, of which one is 0.
        (condition, value), (other, otherwise) = (term.value_if for term in terms if term.value_if)
        if other == f"(!{condition})":
            return CExpression(f"({condition} ? {value} : {otherwise})")
    texts = [as_real(term) for term in terms]
    if code in INFIX:
        return CExpression(f"({texts[0]} {INFIX[code]} {texts[1]})", code in COMPARISONS)
    if code in CALLS:
        if code in (ca.OP_FMIN, ca.OP_FMAX) and _is_number_literal(texts[0]):
            # Compilers then know that the second is not NaN.
            texts.reverse()
        return CExpression(f"{CALLS[code]}({', '.join(map(unparenthesised, texts))})")
    simple = {
        ca.OP_ASSIGN: "{0}", ca.OP_NEG: "(-{0})", ca.OP_SQ: "({0} * {0})", ca.OP_INV: "(1.0 / {0})",
        ca.OP_TWICE: "({0} + {0})", ca.OP_SIGN: "({0} > 0.0 ? 1.0 : ({0} < 0.0 ? -1.0 : 0.0))",
    }  # fmt: skip
    if code not in simple:
        raise BrushgripError(f"no C is known for operation {code} of CasADi")
    return CExpression(simple[code].format(*texts))


def needs_variable(code: int, term: CExpression, uses: int) -> bool:
    """Whether a term becomes a variable: used more than once, or longer than `MAX_INLINE_LENGTH`.

    Negations are excepted from the first, choices from the second.
    """
    is_long = len(term.text) > MAX_INLINE_LENGTH and code != ca.OP_IF_ELSE_ZERO
    return is_long or (uses > 1 and code != ca.OP_NOT)


@dataclass(frozen=True, kw_only=True)
class Comments:
    """Comments beside the statements of a function."""

    # For the first of some outputs, what is computed from here on; for an output, what each element is.
    sections: Mapping[str, str] = field(default_factory=dict)
    elements: Mapping[str, Sequence[str]] = field(default_factory=dict)
    # Outputs that are no parameters in C: the statement that computes one gets a comment.
    between: Collection[str] = ()

    def element_comment(self, output: str, element: int) -> str:
        """Comment of an element of an output; empty where none is known."""
        names = self.elements.get(output, ())
        return f" /* {names[element]} */" if element < len(names) else ""


NO_COMMENTS = Comments()


def c_function(
    name: str, function: ca.Function, real: str, vectors: Collection[str] = ("own", "own_by"),
    comments: Comments = NO_COMMENTS,
) -> str:  # fmt: skip
    """A static C function: scalars by value, vectors by pointer, one pointer an output.

    Inputs and outputs of the Function are columns, and their names those of the parameters. `real` is
    the type of every number. Of the inputs, `vectors` are vectors even if they have one element, as an
    effect's own memory may. An operation that has no C here is a BrushgripError.
    """
    function = function.expand()
    writer = _StatementWriter(real)
    codes = [function.instruction_id(k) for k in range(function.n_instructions())]
    operands = _operands_of(function)
    needed = _live_instructions(function, operands, comments)
    uses: Counter[int] = Counter()
    for k, code in enumerate(codes):
        if k in operands and k in needed:
            weight = 2 if code in TWICE_USED else 1
            uses.update(dict.fromkeys(set(operands[k]), weight))
            uses.update(operands[k][1:] if len(set(operands[k])) < len(operands[k]) else [])
    terms: dict[int, CExpression] = {}
    section = _section_titles_by_instruction(function, comments)
    for k, code in enumerate(codes):
        if k in section:
            writer.statements.append(f"    /* {section[k]} */")
        if code == ca.OP_OUTPUT:
            i, j = function.instruction_output(k)
            output, term = function.name_out(i), terms.get(operands[k][0])
            about = comments.element_comment(output, j)
            if term is None:
                continue
            if output in comments.between:
                terms[operands[k][0]] = writer.store_in_variable(term, about)
            else:
                text = unparenthesised(as_real(term))
                writer.statements.append(f"    {output}[{j}] = {text};{about}")
            continue
        if k not in needed:
            continue
        if code == ca.OP_CONST:
            terms[k] = CExpression(number_literal(function.instruction_constant(k), real))
        elif code == ca.OP_INPUT:
            i, j = function.instruction_input(k)
            scalar = _is_scalar_input(function, i, vectors)
            terms[k] = CExpression(function.name_in(i) + ("" if scalar else f"[{j}]"))
        else:
            term = c_operation(code, [terms[source] for source in operands[k]])
            terms[k] = writer.store_in_variable(term) if needs_variable(code, term, uses[k]) else term
    return _function_definition_text(name, function, real, writer.statements, vectors, comments)


def _operands_of(function: ca.Function) -> dict[int, list[int]]:
    """Instructions whose results an instruction takes, by its number."""
    last: dict[int, int] = {}
    operands: dict[int, list[int]] = {}
    for k in range(function.n_instructions()):
        code = function.instruction_id(k)
        if code not in (ca.OP_CONST, ca.OP_INPUT):
            operands[k] = [last[slot] for slot in function.instruction_input(k)]
        if code != ca.OP_OUTPUT:
            last[function.instruction_output(k)[0]] = k
    return operands


def _live_instructions(
    function: ca.Function, operands: Mapping[int, list[int]], comments: Comments
) -> set[int]:
    """Instructions on which an output depends that is a parameter in C."""
    if not comments.between:
        return set(range(function.n_instructions()))
    needed: set[int] = set()
    for k in reversed(range(function.n_instructions())):
        is_output = function.instruction_id(k) == ca.OP_OUTPUT
        if is_output and function.name_out(function.instruction_output(k)[0]) not in comments.between:
            needed.add(k)
        if k in needed:
            needed.update(operands.get(k, ()))
    return needed


def _section_titles_by_instruction(function: ca.Function, comments: Comments) -> dict[int, str]:
    """Titles by the instruction after the last one of the output before."""
    titles, begin, before = dict[int, str](), 0, ""
    for k in range(function.n_instructions() if comments.sections else 0):
        if function.instruction_id(k) == ca.OP_OUTPUT:
            output = function.name_out(function.instruction_output(k)[0])
            if output != before and output in comments.sections:
                titles[begin] = comments.sections[output]
            begin, before = k + 1, output
    return titles


def _is_scalar_input(function: ca.Function, i: int, vectors: Collection[str]) -> bool:
    return bool(function.numel_in(i) == 1) and function.name_in(i) not in vectors


def _function_definition_text(
    name: str, function: ca.Function, real: str, statements: list[str], vectors: Collection[str],
    comments: Comments,
) -> str:  # fmt: skip
    inputs = [
        f"{real} {function.name_in(i)}" if _is_scalar_input(function, i, vectors)
        else f"const {real} *{function.name_in(i)}"
        for i in range(function.n_in()) if function.numel_in(i) > 0
    ]  # fmt: skip
    outputs = [
        f"{real} *{function.name_out(i)}" for i in range(function.n_out())
        if function.numel_out(i) > 0 and function.name_out(i) not in comments.between
    ]  # fmt: skip
    text = re.sub(r"/\*.*?\*/", "", "\n".join(statements))
    unused = [
        f"    (void){function.name_in(i)};"
        for i in range(function.n_in())
        if function.numel_in(i) > 0 and not re.search(rf"\b{function.name_in(i)}\b", text)
    ]
    body = "\n".join([*unused, *statements])
    return f"static void {name}({', '.join([*inputs, *outputs])}) {{\n{body}\n}}\n"


def c_struct_array(name: str, columns: Mapping[str, Array], real: str) -> str:
    """A type with a field a column, and a constant array of it: `name_t` and `name_of`."""
    count = len(next(iter(columns.values())))
    rows = [
        "    {" + ", ".join(number_literal(float(values[i]), real) for values in columns.values()) + "},"
        for i in range(count)
    ]
    return (
        f"typedef struct {{\n    {real} {', '.join(columns)};\n}} {name}_t;\n\n"
        f"static const {name}_t {name}_of[{count}] = {{\n" + "\n".join(rows) + "\n};\n"
    )


def number_literal(value: float, real: str) -> str:
    """C of a number, NaN and infinity too."""
    if np.isnan(value):
        return f"(({real})NAN)"
    if np.isinf(value):
        return f"({'-' if value < 0 else ''}({real})INFINITY)"
    return f"({value!r})" if value < 0 else repr(float(value))


def _is_number_literal(text: str) -> bool:
    return text.lstrip("(-").rstrip(")").replace(".", "").replace("e", "").replace("-", "").isdigit()


def unparenthesised(text: str) -> str:
    """C without the parentheses around all of it."""
    if not (text.startswith("(") and text.endswith(")")):
        return text
    depth = 0
    for i, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0 and i < len(text) - 1:
            return text
    inner = text[1:-1]
    return text if inner.startswith(("float)", "double)")) else inner
