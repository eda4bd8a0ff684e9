"""Values of a Function of vectors of one length, and the loops in which C computes them.

What depends on no input is a number; the choice of an element, `dot(numbers == place, vector)`, is an
index, as is the place of a maximum.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from symbolic import BrushgripError
from symbolic.float_array_type import Array

REDUCTIONS = {ca.OP_DOT: "0.0", ca.OP_MMAX: "-({real})INFINITY"}
"""Operations that make a scalar of vectors, and what they begin with."""
CHOICE = ca.OP_GETNONZEROS
"""Code of the choice of one element: operands index and vector."""
PLACE = -2
"""Code of the last place of a maximum."""
SUM = ca.OP_DOT
Known = Mapping[str, Mapping[int, float]]


@dataclass(eq=False)
class LoopValue:
    """A scalar or a vector of the Function."""

    code: int = -1  # Its operation; -1 for an input or a constant.
    operands: tuple["LoopValue", ...] = ()  # Of that.
    is_vector: bool = False  # One element a round.
    level: int = 0  # A scalar is known before the loop of this number, a vector can be computed in it.
    constant: Array | None = None  # Elements that are numbers.
    text: str = ""  # C of it; `{i}` stands for the index of an element.
    is_condition: bool = False  # The C is a `bool`.
    value_if: tuple[str, str] | None = None
    is_placed: bool = False  # A maximum whose place is used.
    loop: int = 10**6  # Number of the loop that computes a vector.
    stored: bool = False  # A vector that another loop, or an index, reads.
    uses: int = 0  # How often it is an operand.


@dataclass
class LoopValueReader:
    """Values of a Function in the order of its instructions."""

    function: ca.Function
    length: int
    known: Known
    values: list[LoopValue] = field(default_factory=list)

    def outputs(self) -> list[LoopValue]:
        """The scalars that the Function returns."""
        slots: dict[int, list[LoopValue]] = {}
        results: list[LoopValue] = []
        for k in range(self.function.n_instructions()):
            code, given = self.function.instruction_id(k), self.function.instruction_input(k)
            to = self.function.instruction_output(k)
            if code == ca.OP_OUTPUT:
                results += slots[given[0]]
            elif code == ca.OP_INPUT:
                slots[to[0]] = self._input(given[0])
            elif code in (ca.OP_TRANSPOSE, ca.OP_RESHAPE):
                # Vectors are rows of an input, whichever way they lie.
                slots[to[0]] = slots[given[0]]
            elif code in (ca.OP_HORZSPLIT, ca.OP_VERTSPLIT):
                parts = slots[given[0]]
                if len(parts) != len(to):
                    raise _unsupported_operation_error(code)
                slots |= {slot: [part] for slot, part in zip(to, parts, strict=True) if slot >= 0}
            elif code == ca.OP_CONST:
                elements = np.asarray(ca.evalf(self.function.instruction_MX(k)), float).ravel()
                slots[to[0]] = [_constant(elements)]
            elif any(len(slots[slot]) != 1 for slot in given):
                raise _unsupported_operation_error(code)
            else:
                slots[to[0]] = [self._operation(code, [slots[slot][0] for slot in given])]
        return results

    def _input(self, at: int) -> list[LoopValue]:
        """Scalars, or the rows of a matrix."""
        name, (rows, columns) = self.function.name_in(at), self.function.size_in(at)
        if columns == self.length:
            texts = [f"{name}[{rows} * {{i}}{f' + {j}' * (j > 0)}]" for j in range(rows)]
            return [LoopValue(is_vector=True, text=text) for text in texts]
        numbers = self.known.get(name, {})
        texts = [f"{name}[{j}]" for j in range(rows)] if rows > 1 else [name]
        return [
            LoopValue(text=text, constant=np.array([numbers[j]]) if j in numbers else None)
            for j, text in enumerate(texts)
        ]

    def _operation(self, code: int, operands: Sequence[LoopValue]) -> LoopValue:
        if code == ca.OP_MTIMES:
            code, operands = SUM, [_match_vector_sum(operands)]
        is_reduction = code in REDUCTIONS
        known = [o.constant for o in operands]
        if not is_reduction and all(c is not None for c in known):
            elements = [c for c in known if c is not None]
            return _constant(_evaluate_operation(code, elements))
        level = max(o.level + (is_reduction and o.is_vector) for o in operands)
        is_vector = not is_reduction and any(o.is_vector for o in operands)
        value = LoopValue(code, tuple(operands), is_vector, level)
        if choice := _match_indexed_element(value, self.length):
            index, vector = value.operands = choice
            value.code, value.level = CHOICE, max(index.level, vector.level + (vector.code >= 0))
        elif greatest := _match_last_argmax(value, self.length):
            value.code, value.operands, value.level = PLACE, (greatest,), greatest.level
            greatest.is_placed = True
        self.values.append(value)
        return value


def _constant(elements: Array) -> LoopValue:
    # As good as a scalar where all are equal.
    if (elements == elements[0]).all():
        elements = elements[:1]
    return LoopValue(is_vector=elements.size > 1, constant=elements)


def _evaluate_operation(code: int, elements: Sequence[Array]) -> Array:
    """An operation on numbers."""
    operation: Callable[..., ca.MX] = ca.MX.unary if len(elements) == 1 else ca.MX.binary
    result = operation(code, *(ca.MX(ca.DM(each)) for each in elements))
    return np.asarray(ca.evalf(result), float).ravel()


def _match_vector_sum(operands: Sequence[LoopValue]) -> LoopValue:
    """The vector of 0 + ones @ vector."""
    start, ones, vector = operands
    for given, expected in ((start, 0.0), (ones, 1.0)):
        if given.constant is None or not (given.constant == expected).all():
            raise _unsupported_operation_error(ca.OP_MTIMES)
    return vector


def _is_index_range(value: LoopValue, length: int) -> bool:
    """True for 0, 1, 2, ..."""
    return value.constant is not None and np.array_equal(value.constant, np.arange(length))


def _match_indexed_element(value: LoopValue, length: int) -> tuple[LoopValue, LoopValue] | None:
    """Index and vector of dot(numbers == index, vector)."""
    if value.code != ca.OP_DOT or len(value.operands) != 2:
        return None
    for mask, vector in (value.operands, value.operands[::-1]):
        pairs = (mask.operands, mask.operands[::-1]) if mask.code == ca.OP_EQ else ()
        for numbers, index in pairs:
            if _is_index_range(numbers, length) and not index.is_vector:
                return index, vector
    return None


def _match_last_argmax(value: LoopValue, length: int) -> LoopValue | None:
    """The maximum whose last place is mmax(numbers * (maximum <= vector))."""
    if value.code != ca.OP_MMAX or value.operands[0].code != ca.OP_MUL:
        return None
    product = value.operands[0].operands
    pairs = (product, product[::-1])
    for numbers, mask in pairs:
        if mask.code == ca.OP_LE and _is_index_range(numbers, length):
            greatest, vector = mask.operands
            if greatest.code == ca.OP_MMAX and greatest.operands == (vector,):
                return greatest
    return None


def assign_loops(values: Sequence[LoopValue], outputs: Sequence[LoopValue]) -> None:
    """In which loop each vector is computed, as late as possible, and which are stored."""
    for value in outputs:
        value.uses += 1
    for value in reversed(values):
        if value.uses == 0:
            continue
        value.loop = max(value.level, value.loop) if value.loop < 10**6 else value.level
        reads = value.loop if value.is_vector else value.level - 1
        for operand in value.operands:
            operand.uses += 1 + (value.code in (ca.OP_SQ, ca.OP_TWICE))
            if operand.is_vector and operand.code >= 0:
                operand.stored |= value.code == CHOICE or operand.loop not in (10**6, reads)
                operand.loop = min(operand.loop, reads)


def _unsupported_operation_error(code: int) -> BrushgripError:
    return BrushgripError(f"operation {code} of CasADi on these operands cannot be rolled into loops")
