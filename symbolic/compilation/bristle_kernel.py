"""A patch of bristles along a whole recording in C of its own: one loop over the bristles an evaluation.

CasADi's C has one loop per operation and stores every intermediate result for all bristles. Here one
loop goes over the bristles and does all operations of one bristle, derivatives included, in scalars; the
compiler vectorises it. The expressions are those of `symbolic.compilation.single_bristle_functions`, the
balance is that of `symbolic.elements_in_series`. Directions of derivatives are a loop too: one library
serves any number. The search for a sliding speed alone runs in single precision: one differentiated step
of Newton follows, after which the torque is right to 1e-9, its derivatives to 1e-5.
"""

import ctypes
import re
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from symbolic.compilation.compiled_function_cache import compiled_c_library
from symbolic.compilation.scalar_c import c_function
from symbolic.compilation.single_bristle_functions import (
    SHARED,
    bristle_patch_of,
    bristle_step_functions,
    coefficient_functions,
    sample_functions,
    sample_scalar_count,
    series_element_functions,
)
from symbolic.elements_in_series import series_deflection
from symbolic.errors import BrushgripError
from symbolic.float_array_type import Array
from symbolic.model import Model

if TYPE_CHECKING:
    from jinja2 import Environment

_STATEMENT_BEHIND = re.compile(r"^(?!%%)(.*\S) +%% ((if|for) .+)$", re.MULTILINE)
_BLOCK = r"%% \2\n\1\n%% end\3"


class CompiledRecordingRun:
    """The torque over recordings by one model, compiled."""

    def __init__(self, library: ctypes.CDLL) -> None:
        """Take over a library of `kernel_source`."""
        self._run = library.run
        self._run.restype = None

    def run(
        self, signals: Array, theta: Array, geometry: Array, seeds: Array, memory: Array, along: Array
    ) -> tuple[Array, Array]:
        """M_z (n,) [N m], and its derivatives (n, d).

        Signals are rows in the order of `SIGNALS`, (4, n); seeds are directions in theta, a, e and a
        factor on the load, (p + 3, d). `memory` (m,) and its derivatives `along` (m, d) are those
        before the first sample.
        """
        count, d = signals.shape[1], seeds.shape[1]
        torque, derivatives = np.empty(count), np.empty((count, d))
        given = (signals.ravel("F"), theta, geometry, seeds.ravel("F"), memory, along.ravel("F"))
        arrays = [np.array(part, dtype=np.float64) for part in given]
        pointers = [ctypes.c_void_p(part.ctypes.data) for part in (*arrays, torque, derivatives)]
        self._run(ctypes.c_int64(count), ctypes.c_int64(d), *pointers)
        return torque, derivatives


@cache
def bristle_kernel(model: Model) -> CompiledRecordingRun | None:
    """The loops of a model; None for the exact patch, and where there is no compiler or no C for it."""
    if model.uses_exact_patch:
        return None
    try:
        source = kernel_source(model)
    except (RuntimeError, BrushgripError):
        return None  # An effect that has no form in scalars, say a table.
    library = compiled_c_library("bristle_kernel", source)
    return None if library is None else CompiledRecordingRun(library)


def kernel_source(model: Model) -> str:
    """The C of a model with bristles; RuntimeError or BrushgripError where an effect has no C here."""
    patch, deflection = bristle_patch_of(model), series_deflection(model)
    functions = sample_functions(model) | coefficient_functions(model) | bristle_step_functions(model)
    if deflection is not None:
        functions |= series_element_functions(deflection)
    texts = (
        _in_single_precision(c_function(name, function, "float"))
        if name == "seek"
        else c_function(name, function, "double")
        for name, function in functions.items()
    )
    stresses = patch.memory_size // patch.bristle_count
    by_input = [f"stress_by[{s} * BRISTLES + i]" for s in range(stresses)]
    by_input += ["turn_by", "lever_by", "limit_by", *(f"shared_by[{i}]" for i in range(SHARED))]
    return (
        template_environment("symbolic.compilation")
        .get_template("bristle_kernel.c")
        .render(
            bristles=patch.bristle_count,
            stresses=stresses,
            stress_at_i=", ".join(f"stress[{s} * BRISTLES + i]" for s in range(stresses)),
            single_stress_at_i=", ".join(f"(float)stress[{s} * BRISTLES + i]" for s in range(stresses)),
            parameters=len(model.parameters),
            scalars=sample_scalar_count(model),
            own=sum(effect.memory for effect in model.effects),
            memory=model.memory_size,
            shared=SHARED,
            search_steps=model.search_steps,
            creep=patch.traits.creep is not None,
            compliant=deflection is not None,
            nodes={
                n: _c_number_list(np.array(v))
                for n, v in zip("uvw", patch.nodes_and_weights(), strict=True)
            },
            functions="\n".join(texts).replace("static void ", "INLINE void "),
            place_partials=functions["place_partials"].nnz_out("partials"),
            step_partials=functions["advance"].nnz_out("partials"),
            place_sums=_directional_derivative_sums(
                functions["place_partials"].sparsity_out("partials"),
                "place_by",
                [f"scalars_by[{i}]" for i in range(sample_scalar_count(model))],
            ),
            step_sums=_directional_derivative_sums(
                functions["advance"].sparsity_out("partials"), "step_by", by_input
            ),
        )
    )


@cache
def template_environment(package: str) -> "Environment":
    """A package's templates: `${name}` stands for a value, a line that begins with %% is a statement.

    A statement about one line stands behind it, as in `code %% if x` and `code %% for y in z`.
    """
    # Where nothing is compiled the templates' library is not loaded either.
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    def template(name: str) -> str:
        text = files(package).joinpath("templates", name).read_text("utf-8")
        return _STATEMENT_BEHIND.sub(_BLOCK, text)

    return Environment(
        loader=FunctionLoader(template), undefined=StrictUndefined, keep_trailing_newline=True,
        variable_start_string="${", variable_end_string="}", line_statement_prefix="%%",
    )  # fmt: skip


def _in_single_precision(text: str) -> str:
    """C whose literals and functions are floats: eight bristles at a time in place of four."""
    suffixed = re.sub(r"\b(?:\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+)", r"\g<0>f", text)
    return re.sub(r"\b(?:exp|fabs|natural_log|lesser|greater)\b", r"\g<0>f", suffixed)


def _directional_derivative_sums(jacobian: ca.Sparsity, kept: str, by: list[str]) -> list[str]:
    """C of each row's derivative along a direction, from the nonzeros that an array keeps."""
    sums: list[list[str]] = [[] for _ in range(jacobian.size1())]
    for number, (row, column) in enumerate(zip(*jacobian.get_triplet(), strict=True)):
        sums[row].append(f"{kept}[{number}][i] * {by[column]}")
    return [" + ".join(terms) or "0.0" for terms in sums]


def _c_number_list(values: Array) -> str:
    return ", ".join(repr(float(value)) for value in values.ravel())
