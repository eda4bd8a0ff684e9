"""Named parts of one vector: the state of an observer between samples, in Python and in C alike."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import casadi as ca

from symbolic.float_array_type import Array
from symbolic.patch_interface import Expression as Expression

Parts = Mapping[str, Expression]
Symbol = TypeVar("Symbol", ca.SX, ca.MX)


@dataclass(frozen=True)
class Layout:
    """Names and shapes of the parts of a vector, each stored column by column.

    Attributes:
        fields: name, rows and columns of every part, in order.
    """

    fields: tuple[tuple[str, int, int], ...]

    @classmethod
    def of(cls, *first: tuple[str, int, int], **shapes: int | tuple[int, int]) -> "Layout":
        """The layout of some fields and of parts by name behind them, rows of one column or a shape."""
        sizes = {name: (of, 1) if isinstance(of, int) else of for name, of in shapes.items()}
        return cls((*first, *((name, *size) for name, size in sizes.items())))

    @cached_property
    def places(self) -> Mapping[str, tuple[slice, tuple[int, int]]]:
        """Slice and shape of each part."""
        places, at = {}, 0
        for name, rows, columns in self.fields:
            places[name] = (slice(at, at + rows * columns), (rows, columns))
            at += rows * columns
        return places

    @cached_property
    def size(self) -> int:
        """Length of the vector."""
        return sum(rows * columns for _, rows, columns in self.fields)

    def split(self, vector: ca.MX) -> dict[str, ca.MX]:
        """The parts of a casadi vector, each in its shape."""
        return {name: ca.reshape(vector[at], *shape) for name, (at, shape) in self.places.items()}

    def join(self, parts: Mapping[str, ca.MX]) -> ca.MX:
        """The casadi vector of all parts.

        Raises:
            KeyError: a part is missing.
        """
        return ca.vertcat(*(ca.densify(ca.vec(parts[name])) for name, _, _ in self.fields))

    def join_missing_as_zero(self, parts: Mapping[str, Expression]) -> ca.MX:
        """The casadi vector of some parts: one column fills its part, a missing part is 0."""
        full_size = {}
        for name, rows, columns in self.fields:
            part = ca.MX(parts.get(name, ca.DM(rows, columns)))
            full_size[name] = ca.densify(ca.repmat(part, 1, columns // part.shape[1]))
        return self.join(full_size)

    def part(self, vector: Array, name: str) -> Array:
        """A part of a NumPy vector, a view; one column gives shape (rows,)."""
        at, shape = self.places[name]
        return vector[at] if shape[1] == 1 else vector[at].reshape(shape, order="F")


@dataclass(frozen=True, slots=True, eq=False)
class ObserverState:
    """State of an observer after a sample, an immutable value; `state["x"]` is its part x.

    Attributes:
        values: all parts in one vector; it is not written to.
        layout: their names and shapes.
    """

    values: Array
    layout: Layout

    def __getitem__(self, name: str) -> Array:
        """A part by its name, as listed in the observer's documentation."""
        return self.layout.part(self.values, name)


def named(names: Iterable[str], vector: Expression) -> dict[str, Expression]:
    """The elements of a casadi vector by name."""
    return dict(zip(names, ca.vertsplit(vector), strict=True))


def vector_of(names: Iterable[str], parts: Mapping[str, Expression]) -> Expression:
    """The casadi vector of named elements in this order; the inverse of `named`."""
    return ca.vertcat(*(parts[name] for name in names))


def symbols(kind: type[Symbol], **shapes: int | tuple[int, int]) -> dict[str, Symbol]:
    """Symbols by name, in order; kind is casadi.SX or casadi.MX."""
    return {
        name: kind.sym(name, *shape) if isinstance(shape, tuple) else kind.sym(name, shape)
        for name, shape in shapes.items()
    }


def symbols_of_inputs(function: ca.Function) -> dict[str, ca.MX]:
    """Symbols for the inputs of a casadi Function, by name."""
    return {name: ca.MX.sym(name, *function.size_in(name)) for name in function.name_in()}


def outputs_of(function: ca.Function, *arguments: Expression) -> dict[str, Expression]:
    """The outputs of a casadi Function by name."""
    outputs = function.call(list(arguments), False, False)
    return dict(zip(function.name_out(), outputs, strict=True))
