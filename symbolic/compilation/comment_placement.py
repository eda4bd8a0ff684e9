"""Comments on the C of a Function, and steps between that have one but are no results."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

import casadi as ca


@dataclass(frozen=True, kw_only=True)
class Comments:
    """Comments beside the statements of a function."""

    # For the first of some outputs, what is computed from here on; for an output, what each element is.
    sections: Mapping[str, str] = field(default_factory=dict)
    elements: Mapping[str, Sequence[str]] = field(default_factory=dict)
    # Outputs that are no parameters in C: the statement that computes one gets a comment.
    between: Collection[str] = ()

    def of(self, output: str, element: int) -> str:
        """Comment of an element of an output; empty where none is known."""
        names = self.elements.get(output, ())
        return f" /* {names[element]} */" if element < len(names) else ""


NO_COMMENTS = Comments()


def operands_of(function: ca.Function) -> dict[int, list[int]]:
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


def live_instructions(
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


def section_starts(function: ca.Function, comments: Comments) -> dict[int, str]:
    """Titles by the instruction after the last one of the output before."""
    titles, begin, before = dict[int, str](), 0, ""
    for k in range(function.n_instructions() if comments.sections else 0):
        if function.instruction_id(k) == ca.OP_OUTPUT:
            output = function.name_out(function.instruction_output(k)[0])
            if output != before and output in comments.sections:
                titles[begin] = comments.sections[output]
            begin, before = k + 1, output
    return titles
