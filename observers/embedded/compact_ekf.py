"""The filter on the declared model in compact C.

The patch is that of `observers.embedded.compact_patch`. The filter is the Function of
`observers.estimators.ekf` on a patch whose torque is an input, with the parameters as numbers and
expanded to scalars.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from observers.embedded.casadi_c import embedded_code
from observers.embedded.compact_patch import (
    build_corner,
    is_declared,
    patch_bytes,
    patch_numbers,
    patch_types,
)
from observers.embedded.constants import Constants
from observers.embedded.scalar_function import with_known_exponentials
from observers.embedded.scalar_type import Real
from observers.embedded.supervision_code import supervised, supervision_functions
from observers.embedded.templating import Body, render
from observers.estimators.ekf import Ekf, build_step, layout
from observers.estimators.initial_state import build_initial_state
from observers.layout import Layout
from observers.measurement.linearisation import angle_is_state, directions
from observers.measurement.measurement_model import LEAST_LOAD
from observers.protocol import OUTPUT, FunctionObserver
from symbolic import DECLARED, GEOMETRY, SIGNALS, Model

MEMORY = Layout.of(M_z=1, by_mu=1, by_k=1, mu=1, k=1)
"""Memory of a `LinearisedPatch`: M_z [N m], its derivatives by mu and k, and mu [1] and k [N/m^2]."""


@dataclass(frozen=True)
class LinearisedPatch:
    """The torque of the declared model, linear about the point in its memory; a `PatchModel`.

    Attributes:
        stiff: k is a state; otherwise the derivative by it does not matter.
    """

    stiff: bool

    @property
    def memory_size(self) -> int:
        """Length of the memory."""
        return MEMORY.size

    @property
    def coordinates(self) -> tuple[str, ...]:
        """Those of the declared model."""
        return tuple(parameter.name for parameter in DECLARED)

    @property
    def initial(self) -> ca.Function:
        """(signals, theta, geometry) -> zeros: the memory is an input of every step."""
        inputs = self._symbols()[1:]
        return ca.Function("start", inputs, [ca.MX(ca.DM.zeros(MEMORY.size))])

    @property
    def advance(self) -> ca.Function:
        """The memory as it is: (memory, signals, theta, geometry) -> (memory_next, seen)."""
        memory, signals, *_ = inputs = self._symbols()
        return ca.Function("advance", inputs, [memory, signals])

    @property
    def torque(self) -> ca.Function:
        """The torque to first order: (memory, seen, theta, geometry) -> M_z."""
        memory, _, theta, _ = inputs = self._symbols()
        at = MEMORY.split(memory)
        values = dict(zip(self.coordinates, ca.vertsplit(theta), strict=True))
        M_z = at["M_z"] + at["by_mu"] * (values["mu"] - at["mu"])
        return ca.Function(
            "torque", inputs, [M_z + at["by_k"] * (values["k"] - at["k"]) if self.stiff else M_z]
        )

    @property
    def full_slide(self) -> ca.Function:
        """That of the declared model: (memory, F_N, theta, geometry, rate) -> (mu_eff, M_slide)."""
        memory, _, theta, geometry = self._symbols()
        F_N, rate = ca.MX.sym("F_N"), ca.MX.sym("rate")
        declared = Model()
        slide = declared.full_slide(ca.MX(declared.memory_size, 1), F_N, theta, geometry, rate)
        return ca.Function("full_slide", [memory, F_N, theta, geometry, rate], [*slide])

    def memory_depends_on(self, coordinate: str) -> bool:
        """False: the memory of the exact patch depends on no parameter."""
        del coordinate
        return False

    def _symbols(self) -> list[ca.MX]:
        sizes = (MEMORY.size, len(SIGNALS), len(self.coordinates), len(GEOMETRY))
        return [ca.MX.sym(f"in{i}", size) for i, size in enumerate(sizes)]


def is_compact(observer: FunctionObserver) -> bool:
    """True for an `Ekf`, not a subclass, that linearises once on the declared model."""
    return type(observer) is Ekf and observer.iterations == 1 and is_declared(observer)


def compact_body(observer: Ekf, real: Real, terms: Mapping[str, Any]) -> Body:
    """The code of a filter for which `is_compact` holds."""
    parts, constants = _layout(observer), Constants(observer, terms["tunable"])
    with_rig = constants.tunable == "all"
    functions = [
        build_corner(observer, with_rig=with_rig),
        _build_begin(observer, constants),
        _build_filter(observer, constants),
        *supervision_functions(observer, terms["tunable"]),
    ]
    source = embedded_code(functions, real, f"{terms['name']}_core", null_checks=False)
    terms = {
        **terms,
        **(patch := patch_numbers(observer, with_rig=with_rig)),
        **_patch_calls(observer, patch["k"]),
        "start_res": functions[1].n_out(),
        "res": functions[2].n_out(),
        "least_load": repr(LEAST_LOAD),
    }
    size = parts.size
    private = f"    {real.c_type} values[2][{size}]; /* of the filter, before and after a sample */\n"
    private += f"    {real.c_type} F_N, least_load;\n    {terms['name']}_patch_t patch;"
    body = Body(
        core=f"{source.text}\n{render('patch.c', terms)}",
        stepping=render("patch_stepping.c", terms),
        private=private,
        bytes=(2 * size + 2) * real.size + patch_bytes(real, with_rig=with_rig),
        types=patch_types(real, terms["name"], with_rig=with_rig),
        with_rig=with_rig,
    )
    return supervised(observer, real, terms, body, source, parts)


def _layout(observer: Ekf) -> Layout:
    return layout(_patch(observer), observer.measurement_model)


def _indices(observer: Ekf) -> dict[str, int]:
    """Index in the filter's state of each part, state, and element of memory and output."""
    indices = {name: at.start for name, (at, _) in _layout(observer).places.items()}
    indices |= {name: indices["x"] + i for i, name in enumerate(observer.states)}
    memory = {f"memory.{name}": at.start for name, (at, _) in MEMORY.places.items()}
    indices |= {name: indices["memory"] + at for name, at in memory.items()}
    return indices | {f"output.{name}": indices["output"] + i for i, name in enumerate(OUTPUT)}


def _patch(observer: Ekf) -> LinearisedPatch:
    return LinearisedPatch(stiff="stiffness" in observer.states)


def _patch_calls(observer: Ekf, k: str) -> dict[str, str]:
    """C that advances the patch and passes its torque on, before the filter's step and after it."""
    if angle_is_state(observer.measurement_model):
        return {"patch_before": "", "patch_after": _lines(_patch_after(observer))}
    return {"patch_before": _lines(_patch_before(observer, k)), "patch_after": ""}


def _patch_before(observer: Ekf, k: str) -> list[str]:
    """The patch at the sample's angle; the states that the torque depends on only walk until then."""
    at = _indices(observer)
    stiffness = f"before[{at['stiffness']}]" if "stiffness" in at else "1.0"
    psi = "is_known(sample[0]) ? sample[0] : state->patch.angle"
    lines = [
        f"advance_patch(state, {psi}, sample[2], state->output[OUT_MU], {stiffness}, torque);",
        f"before[{at['memory.M_z']}] = torque[0];",
        f"before[{at['memory.by_mu']}] = torque[1];",
        f"before[{at['memory.mu']}] = state->output[OUT_MU];",
    ]
    if "stiffness" not in at:
        return lines
    return [
        *lines,
        f"before[{at['memory.by_k']}] = torque[2] / {k};",
        f"before[{at['memory.k']}] = {k} * {stiffness};",
    ]


def _patch_after(observer: Ekf) -> list[str]:
    """The patch at the corrected angle; its torque is for the next sample."""
    at = _indices(observer)
    stiffness = f"after[{at['stiffness']}]" if "stiffness" in at else "1.0"
    by_state = {"psi": "torque[3]", "log_mu": "torque[1] * output[OUT_MU]", "stiffness": "torque[2]"}
    slopes = [by_state[name] for name in directions(observer.measurement_model)]
    return [
        f"advance_patch(state, after[{at['psi']}], sample[2], output[OUT_MU], {stiffness}, torque);",
        f"after[{at['M_z']}] = torque[0];",
        *(f"after[{at['slopes'] + i}] = {slope};" for i, slope in enumerate(slopes)),
        f"after[{at['output.M_z_predicted']}] = torque[0];",
        "output[OUT_M_Z_PREDICTED] = torque[0];",
    ]


def _lines(lines: list[str]) -> str:
    return "".join(f"    {line}\n" for line in lines)


def _build_begin(observer: Ekf, constants: Constants) -> ca.Function:
    """(sample) -> the state before it."""
    start = build_initial_state(_patch(observer), observer.measurement_model, _layout(observer))
    return constants.fill("begin_filter", start)


def _build_filter(observer: Ekf, constants: Constants) -> ca.Function:
    """(state, sample) -> (state_next, output)."""
    step = build_step(_patch(observer), observer.measurement_model, observer.iterations)
    flat = constants.fill("filter", step)
    at = _indices(observer)
    # mu in the memory, and mu in the last output, are exp of the state ln mu.
    mu = at["output.mu" if angle_is_state(observer.measurement_model) else "memory.mu"]
    return with_known_exponentials(flat, {at["log_mu"]: mu})
