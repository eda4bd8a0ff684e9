"""The moving horizon on the declared model, small and quick.

The patch of `observers.embedded.compact_patch` is kept as every sample of the window left it, and C
loops over the samples; what is done at each is casadi's, see `observers.embedded.mhe_kernels`.
"""

from collections.abc import Mapping

from observers.base import ModelObserver
from observers.embedded.casadi_c import embedded_code
from observers.embedded.compact_patch import (
    build_corner,
    is_declared,
    patch_bytes,
    patch_numbers,
    patch_types,
)
from observers.embedded.mhe_kernels import made_size, prior_variance_of, window_functions
from observers.embedded.scalar_type import Real, in_type
from observers.embedded.templating import Body, render
from observers.mhe import Mhe

KEPT = 9
"""Corners kept with a sample: a window of 50 samples takes less than 8 KB in single precision."""
STATE = """\
    {real} mean[{n}], factor[{n} * {n}], P_newest[{n} * {n}], last[7], counts[2];
    {real} x[{window}][{n}], row[{window}][5], made[{window}][{made}];
    {real} slope[{window}], xi[{window}][{kept}], d[{window}][{kept}];
    {name}_patch_t patch;
    int32_t newest;
    int8_t corners[{window}];"""


def is_quick_window(observer: ModelObserver) -> bool:
    """True where the angle is known, for one iteration on the declared model, two samples or more."""
    if not isinstance(observer, Mhe) or observer.measurement_model.turns or observer.window < 2:
        return False
    return observer.iterations == 1 and is_declared(observer)


def quick_window_body(observer: Mhe, real: Real, terms: Mapping[str, str]) -> Body:
    """The code of an estimator for which `is_quick_window` holds."""
    n, made = len(observer.states), made_size(observer)
    functions = [build_corner(observer), *window_functions(observer)]
    source = embedded_code(functions, real, f"{terms['name']}_core", null_checks=False)
    stiff = f"[{observer.states.index('stiffness')}]" if "stiffness" in observer.states else ""
    filling = {
        **terms,
        **patch_numbers(observer),
        "window": str(observer.window),
        "states": str(n),
        "made": str(made),
        "kept": str(KEPT),
        "stiffness": f"x{stiff}" if stiff else "1.0",
        "stiffness_newest": f"newest{stiff}" if stiff else "1.0",
        "prior_variance": repr(prior_variance_of(observer)),
    }
    numbers = {"n": n, "window": observer.window, "made": made, "kept": KEPT}
    a_sample = n + 5 + made + 1 + 2 * KEPT
    size = (n + 2 * n * n + 9 + observer.window * a_sample) * real.size
    return Body(
        core=f"{source.text}\n{in_type(render('patch.c', filling), real)}",
        stepping=in_type(render("window.c", filling), real),
        private=STATE.format(real=real.c_type, name=terms["name"], **numbers),
        bytes=size + patch_bytes(real) + 4 + observer.window,
        types=patch_types(real, terms["name"]),
    )
