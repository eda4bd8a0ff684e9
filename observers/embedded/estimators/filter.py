"""The filter in compact C, `templates/estimators/filter.c`.

It is the Function of `observers.ekf` on a patch whose torque is an input, expanded to scalars, with the
parameters as numbers.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import casadi as ca

from observers.ekf import Ekf, build_step, layout
from observers.embedded.constants import Constants
from observers.embedded.estimators.measurement_traits import follows_correction
from observers.embedded.estimators.sample_functions import (
    TORQUE,
    effective_friction,
    named_function,
    retentions,
    sample_functions,
    stiffness_of,
)
from observers.embedded.patches.interface import EmbeddedPatch
from observers.embedded.scalar_function import inputs_used, with_known_exponential, without_inputs
from observers.initial_state import build_initial_state
from observers.layout import Layout
from observers.linearisation import directions, state_index
from observers.measurement_model import CLEAN
from observers.udu import covariance

PATCH = ("M_z", "slopes")
"""Parts of the state that the patch of C sets, not the step."""


@dataclass(frozen=True, eq=False)
class CompactFilter:
    """An `Ekf` on a patch of C; a `CompactEstimator`.

    Attributes:
        patch: the patch, and with it the observer.
        constants: of the observer.
    """

    patch: EmbeddedPatch
    constants: Constants
    template: ClassVar[str] = "estimators/filter.c"

    @property
    def observer(self) -> Ekf:
        """The observer."""
        assert isinstance(self.patch.observer, Ekf)
        return self.patch.observer

    @cached_property
    def layout(self) -> Layout:
        """The parts of the filter's state that C keeps: those that a step depends on."""
        used = inputs_used(self._step)
        return Layout(tuple(f for f in self._parts.fields if f[0] in used and f[0] != "memory"))

    @cached_property
    def functions(self) -> list[ca.Function]:
        """The Functions of a step."""
        step = without_inputs(self._step, {name for name, _, _ in self._unused})
        found = [*sample_functions(self.observer), self._begin(), step]
        if self.patch.follows_mu:
            factor = ca.MX.sym("factor", *self._parts.places["factor"][1])
            variances = covariance(factor)
            found.append(retentions(self.observer, self.constants, factor, variances, predicted=True))
        if follows_correction(self.observer.measurement_model) and self.patch.torque_model.slides:
            found.append(effective_friction(self.patch))
        return found

    @property
    def terms(self) -> Mapping[str, Any]:
        """Values of the placeholders of the templates."""
        model, k = self.observer.measurement_model, self.patch.k
        names = [name for name, _, _ in self.layout.fields]
        stiffness = {when: stiffness_of(model, f"{when}->x") for when in ("before", "after")}
        memory = {
            "M_z": "torque[M_Z]", "by_mu": "torque[BY_MU]", "mu": "mu",
            "by_k": f"torque[BY_STIFFNESS] / {k}", "k": f"{k} * {stiffness['before']}",
            "slide": "slide[0]", "beside": "slide[1]",
        }  # fmt: skip
        return {
            "clean": len(CLEAN), "states": len(model.states), "window": 0,
            "follows_correction": follows_correction(model), "follows_mu": self.patch.follows_mu,
            "slides": self.patch.torque_model.slides,
            "first": [f"first->{name}" for name in names],
            "before": [f"before->{name}{'[0]' * (name == 'M_z')}" for name in names],
            "after": [f"after->{name}" for name in names if name not in PATCH],
            "stiffness_before": stiffness["before"], "stiffness_after": stiffness["after"],
            "memory": [memory[name] for name, _, _ in self.patch.torque_model.layout.fields],
            "slopes": [
                f"torque[{TORQUE[name]}]{' * output[OUT_MU]' if name == 'log_mu' else ''}"
                for name in directions(model)
            ],
            "newest_x": "state->filter[state->now].x", "x": "filter->x", "P": "filter->factor",
            "own_state": "filter->",
        }  # fmt: skip

    def types(self, name: str) -> str:
        """Types of the state, C of the header."""
        fields = "".join(
            f"    {self.patch.real.c_type} {part}[{rows * columns}];\n"
            for part, rows, columns in self.layout.fields
        )
        return f"/* The filter, see the code. */\ntypedef struct {{\n{fields}}} {name}_filter_t;\n\n"

    def private(self, name: str) -> str:
        """Fields of the state."""
        return (
            f"    {name}_filter_t filter[2]; /* before and after a sample */\n    {name}_patch_t patch;"
        )

    @property
    def bytes(self) -> int:
        """Bytes of these fields without the patch."""
        return 2 * self.layout.size * self.patch.real.size

    @cached_property
    def _parts(self) -> Layout:
        return layout(self.patch.torque_model, self.observer.measurement_model)

    @property
    def _unused(self) -> list[tuple[str, int, int]]:
        kept = {*self.layout.fields, *(f for f in self._parts.fields if f[0] == "memory")}
        return [field for field in self._parts.fields if field not in kept]

    def _begin(self) -> ca.Function:
        """(sample) -> the parts before it."""
        model, parts = self.observer.measurement_model, self._parts
        start = build_initial_state(self.patch.torque_model, model, parts)
        sample, constants = (ca.MX.sym(start.name_in(i), start.numel_in(i)) for i in range(2))
        first = parts.split(start(sample, constants))
        outputs = {f"first_{name}": first[name] for name, _, _ in self.layout.fields}
        function = named_function("begin_filter", [sample, constants], **outputs)
        return self.constants.fill("begin_filter", function)

    @cached_property
    def _step(self) -> ca.Function:
        """(parts, memory, sample, mu) -> (parts after, output); mu is exp of ln mu before the sample."""
        step = build_step(
            self.patch.torque_model, self.observer.measurement_model, self.observer.iterations
        )
        parts = {name: ca.MX.sym(name, rows * columns) for name, rows, columns in self._parts.fields}
        sample, constants = (ca.MX.sym(step.name_in(i), step.numel_in(i)) for i in (1, 2))
        state_next, output = step(ca.vertcat(*parts.values()), sample, constants)
        after = self._parts.split(state_next)
        outputs = {f"{n}_next": after[n] for n in parts if n not in (*PATCH, "memory", "output")}
        memory = parts.pop("memory")
        inputs = [*parts.values(), memory, sample, ca.MX.sym("mu"), constants]
        function = named_function("filter", inputs, **outputs, result=output)
        flat = self.constants.fill("filter", function)
        return with_known_exponential(flat, ("x", state_index(self.observer.measurement_model)), "mu")
