"""C of a Function of vectors of one length, as loops: `scalar_c` would write it out for each element.

The Function is one of `MX`: operations element by element, sums and maxima. Operations that wait for
the same sums are computed in one loop.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, field

import casadi as ca

from observers.embedded.vectors_by_c_loop import (
    CHOICE,
    PLACE,
    REDUCTIONS,
    Known,
    LoopValue,
    LoopValueReader,
    assign_loops,
)
from symbolic.compilation.scalar_c import (
    CExpression,
    as_real,
    c_operation,
    needs_variable,
    number_literal,
    unparenthesised,
)


def c_function_with_loops(name: str, function: ca.Function, length: int, real: str, known: Known) -> str:
    """A static C function of a Function of `MX` with one output, a column of scalars.

    Its matrices have `length` columns, one for each round of its loops; known are elements of inputs
    that are numbers, by the input's name and their index. What cannot be rolled is a BrushgripError.
    """
    inputs = [ca.MX.sym(function.name_in(i), *function.size_in(i)) for i in range(function.n_in())]
    results = ca.vertsplit(function.call(inputs, True, False)[0])
    names = [f"y{i}" for i in range(len(results))]
    reader = LoopValueReader(
        ca.Function(name, inputs, results, function.name_in(), names), length, known
    )
    outputs = reader.outputs()
    assign_loops(reader.values, outputs)
    body = LoopWriter(length, real).function_body(reader.values, outputs, function.name_out(0))
    arguments = ", ".join(
        f"{real} {s.name()}" if s.numel() == 1 else f"const {real} *{s.name()}" for s in inputs
    )
    return f"static void {name}({arguments}, {real} *{function.name_out(0)}) {{\n{body}\n}}\n"


@dataclass
class LoopWriter:
    """Writes loops of a given length in a type of number."""

    length: int
    real: str
    tables: list[str] = field(default_factory=list)
    lines: list[str] = field(default_factory=list)
    count: int = 0

    def function_body(
        self, values: Sequence[LoopValue], outputs: Sequence[LoopValue], result: str
    ) -> str:
        """Statements of the function."""
        used = [value for value in values if value.uses > 0]
        last = max(value.level for value in used)
        loops: dict[int, list[LoopValue]] = defaultdict(list)
        for value in used:
            if value.is_vector:
                loops[value.loop].append(value)
            elif value.code in REDUCTIONS:
                loops[value.level - 1].append(value)
        arrays = self._array_declarations(used)
        for level in range(last + 1):
            for value in used:
                if not value.is_vector and value.level == level and value.code not in REDUCTIONS:
                    self._write_value(value, "    ")
            self._loop(loops[level])
        written = [
            f"    {result}[{j}] = {unparenthesised(self._real_expression(o))};"
            for j, o in enumerate(outputs)
        ]
        return "\n".join([*self.tables, *arrays, "    int32_t i;", *self.lines, *written])

    def _array_declarations(self, used: Sequence[LoopValue]) -> list[str]:
        stored = [value for value in used if value.stored]
        for value in stored:
            value.text = f"{self._next_variable_name()}[{{i}}]"
        names = ", ".join(value.text.format(i=self.length) for value in stored)
        return [f"    {self.real} {names};"] if stored else []

    def _loop(self, values: Sequence[LoopValue]) -> None:
        if not values:
            return
        sums = [value for value in values if not value.is_vector]
        for value in sums:
            value.text = self._next_variable_name()
            start = REDUCTIONS[value.code].format(real=self.real)
            self.lines.append(f"    {self.real} {value.text} = {start};")
            if value.is_placed:
                self.lines.append(f"    {self.real} {value.text}_at = 0.0;")
        self.lines.append(f"    for (i = 0; i < {self.length}; ++i) {{")
        for value in values:
            if value.is_vector:
                self._write_value(value, "        ")
                continue
            terms = [self._real_expression(operand) for operand in value.operands]
            if value.code == ca.OP_MMAX:
                most, each = value.text, unparenthesised(terms[0])
                found = f" {most}_at = ({self.real})i;" if value.is_placed else ""
                sign = ">=" if found else ">"
                self.lines.append(f"        if ({each} {sign} {most}) {{ {most} = {each};{found} }}")
            else:
                self.lines.append(f"        {value.text} += {' * '.join(terms)};")
        self.lines.append("    }")

    def _write_value(self, value: LoopValue, indent: str) -> None:
        if value.code == PLACE:
            term = CExpression(f"{value.operands[0].text}_at")
        elif value.code == CHOICE:
            index, vector = value.operands
            term = CExpression(self._indexed_text(vector, f"(int32_t){self._real_expression(index)}"))
        else:
            term = c_operation(value.code, [self._element_term(operand) for operand in value.operands])
        if value.stored:
            self.lines.append(f"{indent}{value.text.format(i='i')} = {unparenthesised(as_real(term))};")
            return
        value.text, value.is_condition, value.value_if = term.text, term.is_condition, term.value_if
        if needs_variable(value.code, term, value.uses) or value.code == CHOICE:
            value.text, value.value_if = self._next_variable_name(), None
            kind = "bool" if term.is_condition else self.real
            self.lines.append(f"{indent}const {kind} {value.text} = {unparenthesised(term.text)};")

    def _element_term(self, value: LoopValue) -> CExpression:
        return CExpression(self._indexed_text(value, "i"), value.is_condition, value.value_if)

    def _real_expression(self, value: LoopValue) -> str:
        return as_real(self._element_term(value))

    def _indexed_text(self, value: LoopValue, index: str) -> str:
        if value.constant is not None and not value.text:
            value.text = number_literal(float(value.constant[0]), self.real)
            if value.is_vector:
                elements = ", ".join(number_literal(float(each), self.real) for each in value.constant)
                table = self._next_variable_name()
                self.tables.append(
                    f"    static const {self.real} {table}[{self.length}] = {{{elements}}};"
                )
                value.text = f"{table}[{{i}}]"
        return value.text.format(i=index)

    def _next_variable_name(self) -> str:
        self.count += 1
        return f"v{self.count}"
