"""The moving-horizon estimator on an exact patch under effects, or on the steering torque, in compact C.

The window is that of `observers.embedded.compact_mhe`, which keeps the corners of the patch with every
sample; the effects enter as in `observers.embedded.compact_corners`, once a sample.
"""

from collections.abc import Mapping
from typing import Any

from observers.embedded.casadi_c import embedded_code
from observers.embedded.compact_bristle_mhe import output_with_slide
from observers.embedded.compact_corners import CompactCorners, has_corners
from observers.embedded.compact_mhe import window_functions
from observers.embedded.compact_patch import is_declared, patch_numbers
from observers.embedded.compact_window import STORED_CORNERS, corner_state, window_values
from observers.embedded.scalar_type import Real
from observers.embedded.supervision_code import supervised, supervision_functions
from observers.embedded.templating import Body, render
from observers.estimators.mhe import Mhe
from observers.patch.update import memory_depends_on_tyre
from observers.protocol import FunctionObserver


def is_compact_corner_window(observer: FunctionObserver) -> bool:
    """True for one iteration over two samples or more, k being known, on corners.

    The declared model on the aligning torque has code of its own.
    """
    if type(observer) is not Mhe or observer.iterations != 1 or observer.window < 2:
        return False
    if memory_depends_on_tyre(observer.model, observer.measurement_model):
        return False
    return has_corners(observer) or ("stiffness" not in observer.states and is_declared(observer))


def corner_window_body(observer: Mhe, real: Real, terms: Mapping[str, Any]) -> Body:
    """The code of an estimator for which `is_compact_corner_window` holds."""
    corners = CompactCorners(observer, real)
    functions = [*corners.functions, *window_functions(observer, output_with_slide, terms["tunable"])]
    functions += supervision_functions(observer, terms["tunable"])
    source = embedded_code(functions, real, f"{terms['name']}_core", null_checks=False)
    values = {
        **terms, **corners.terms, **patch_numbers(observer), **window_values(observer), "effects": True,
        "stored": str(STORED_CORNERS), "stiffness": "1.0", "stiffness_newest": "1.0",
    }  # fmt: skip
    private, size = corner_state(observer, real, terms["name"])
    body = Body(
        core=f"{source.text}\n{corners.numbers(values, source.text)}\n{corners.text(values)}",
        stepping=render("window.c", values),
        private=private,
        bytes=size + corners.bytes,
        types=corners.state_type(terms["name"]),
    )
    return supervised(observer, real, values, body, source, None)
