"""The filter on the declared model, small and quick.

The patch is that of `observers.embedded.compact_patch`. The filter is that of `observers.ekf`, on a
model whose torque is an input, with the parameters put in as numbers and all of it expanded to
scalars.
"""

from collections.abc import Mapping
from typing import Any

import casadi as ca

from observers.base import ModelObserver
from observers.ekf import Ekf, build_step, layout
from observers.embedded.casadi_c import embedded_code
from observers.embedded.compact_patch import (
    build_corner,
    is_declared,
    patch_bytes,
    patch_numbers,
    patch_types,
)
from observers.embedded.exp_reuse import with_known_exponentials
from observers.embedded.initial_state import build_start
from observers.embedded.linearised_patch import HandedTorque
from observers.embedded.scalar_type import Real, in_type
from observers.embedded.scalarise import scalars
from observers.embedded.templating import Body, render
from observers.layout import Layout

HELD_MU = 3
"""Place of mu in the memory of a `HandedTorque`."""


def is_quick(observer: ModelObserver) -> bool:
    """True for what can be written this way: a filter that linearises once, on the declared model."""
    return isinstance(observer, Ekf) and observer.iterations == 1 and is_declared(observer)


def quick_body(observer: Ekf, real: Real, terms: Mapping[str, str]) -> Body:
    """The code of a filter for which `is_quick` holds."""
    parts = _layout(observer)
    functions = [build_corner(observer), _build_begin(observer), _build_filter(observer)]
    source = embedded_code(functions, real, f"{terms['name']}_core", null_checks=False)
    terms = {**terms, **patch_numbers(observer), **_meeting(observer)}
    patch = in_type(render("patch.c", terms), real)
    size = parts.size
    private = f"    {real.c_type} values[2][{size}]; /* of the filter, before and after a sample */\n"
    private += f"    {real.c_type} F_N;\n    {terms['name']}_patch_t patch;"
    return Body(
        core=f"{source.text}\n{patch}",
        stepping=in_type(render("patch_stepping.c", terms), real),
        private=private,
        bytes=(2 * size + 1) * real.size + patch_bytes(real),
        types=patch_types(real, terms["name"]),
    )


def _layout(observer: Ekf) -> Layout:
    return layout(_handed(observer), observer.measurement_model)


def _places(observer: Ekf) -> dict[str, int]:
    """Where each part of the filter's state begins."""
    return {name: at.start for name, (at, _) in _layout(observer).places.items()}


def _handed(observer: Ekf) -> Any:
    return HandedTorque(stiff="stiffness" in observer.states)


def _meeting(observer: Ekf) -> dict[str, str]:
    """When the patch meets a sample, and where its torque goes."""
    places = _places(observer)
    stiff = "stiffness" in observer.states

    def state(half: str, name: str, default: str) -> str:
        return (
            f"{half}[{places['x'] + observer.states.index(name)}]"
            if name in observer.states
            else default
        )

    if not observer.measurement_model.turns:
        # The states that the torque depends on only walk: the patch meets them as they were.
        stiffness = state("before", "stiffness", "1.0")
        psi = "is_known(sample[0]) ? sample[0] : state->patch.angle"
        lines = [
            f"meet(state, {psi}, sample[2], state->output[0], {stiffness}, torque);",
            *(f"before[{places['memory'] + i}] = torque[{i}];" for i in range(2)),
            f"before[{places['memory'] + HELD_MU}] = state->output[0];",
        ]
        if stiff:
            k = repr(float(observer.values["k"]))
            lines += [
                f"before[{places['memory'] + 2}] = torque[2] / {k};",
                f"before[{places['memory'] + 4}] = {k} * {stiffness};",
            ]
        return {"meeting_before": _lines(lines), "meeting_after": "", **_sizes(observer)}
    # The patch follows the angle that the filter makes of the sample; its torque is for the next one.
    stiffness = state("after", "stiffness", "1.0")
    slopes = ["torque[3]", "torque[1] * said[0]", *(["torque[2]"] if stiff else [])]
    lines = [
        f"meet(state, {state('after', 'psi', '')}, sample[2], said[0], {stiffness}, torque);",
        f"after[{places['M_z']}] = torque[0];",
        *(f"after[{places['slopes'] + i}] = {slope};" for i, slope in enumerate(slopes)),
        f"after[{places['said'] + 2}] = torque[0];",
        "said[2] = torque[0];",
    ]
    return {"meeting_before": "", "meeting_after": _lines(lines), **_sizes(observer)}


def _sizes(observer: Ekf) -> dict[str, str]:
    begin, step = _build_begin(observer), _build_filter(observer)
    return {
        "start_arg": str(begin.n_in()), "start_res": str(begin.n_out()),
        "arg": str(step.n_in()), "res": str(step.n_out()),
    }  # fmt: skip


def _lines(lines: list[str]) -> str:
    return "".join(f"    {line}\n" for line in lines)


def _build_begin(observer: Ekf) -> ca.Function:
    """(sample) -> the state before it."""
    start = build_start(observer, _layout(observer))
    return scalars("begin_filter", start, {"constants": observer.constants})


def _build_filter(observer: Ekf) -> ca.Function:
    """(state, sample) -> (state_next, said), the parameters as numbers."""
    step = build_step(_handed(observer), observer.measurement_model, observer.iterations)
    flat = scalars("filter", step, {"constants": observer.constants})
    places = _places(observer)
    # Where the torque was taken, and what was last said of mu, is exp of the state that stands for it.
    mu = places["said"] if observer.measurement_model.turns else places["memory"] + HELD_MU
    return with_known_exponentials(flat, {places["x"]: mu})
