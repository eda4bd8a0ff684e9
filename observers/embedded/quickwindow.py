"""The moving horizon on the declared model, quicker: the patch by hand, the window as casadi has it.

The patch of `observers.embedded.patchcode` is kept as every sample of the window left it. The window is
that of `observers.window`, on a model whose torque is handed to it.
"""

from collections.abc import Mapping
from typing import Any

from observers.embedded.filling import Body, filled
from observers.embedded.handed import HandedTorque
from observers.embedded.patchcode import (
    build_corner,
    is_declared,
    patch_bytes,
    patch_numbers,
    patch_types,
)
from observers.embedded.reals import Real
from observers.embedded.source import embedded_source
from observers.embedded.start import build_start
from observers.embedded.typed import in_type
from observers.mhe import Mhe
from observers.settings import ModelObserver
from observers.window import build_window_step, layout


def is_quick_window(observer: ModelObserver) -> bool:
    """True where the angle is known, for one iteration on the declared model."""
    if not isinstance(observer, Mhe) or observer.sensing.turns:
        return False
    return observer.iterations == 1 and is_declared(observer)


def quick_window_body(observer: Mhe, real: Real, terms: Mapping[str, str]) -> Body:
    """The code of an estimator for which `is_quick_window` holds."""
    handed: Any = HandedTorque(stiff="stiffness" in observer.states, kept=True)
    parts = layout(handed, observer.sensing, observer.window)
    step = build_window_step(handed, observer.sensing, observer.window, observer.iterations)
    functions = [build_corner(observer), build_start(observer, parts), step]
    source = embedded_source(functions, real, f"{terms['name']}_core")
    x = "" if not handed.stiff else f"        stiffness = x[{observer.states.index('stiffness')}];\n"
    numbers = {
        "window": observer.window, "x_at": parts.places["x"][0].start, "states": len(observer.states),
        "memory_at": parts.places["memory"][0].start, "memory_size": handed.memory_size,
        "arg": source.arg, "res": source.res, "step": step.name(), "stiffness_of_x": x,
    }  # fmt: skip
    filling = {**terms, **patch_numbers(observer), **{n: str(v) for n, v in numbers.items()}}
    private = f"""\
    {real.c_type} values[2][{parts.size}]; /* of the window, before and after a sample */
    {real.c_type} scratch[{source.w}];
    int32_t integers[{max(source.iw, 1)}];
    {real.c_type} F_N;
    int32_t newest;
    {terms["name"]}_patch_t patches[{observer.window}];"""
    return Body(
        core=f"{source.text}\n{in_type(filled('patch.c', filling), real)}",
        stepping=in_type(filled("window_stepping.c", filling), real),
        private=private,
        bytes=(2 * parts.size + source.w + 1) * real.size
        + 4 * max(source.iw, 1)
        + 4
        + observer.window * patch_bytes(real),
        types=patch_types(real, terms["name"]),
    )
