"""The moving-horizon estimator on a model with bristles in compact C.

The window is that of `observers.embedded.compact_mhe`. The patch is advanced once a sample; M_z of a
sample is linear in mu, so that the window keeps three numbers of it: M_z, its derivative by mu, and mu.
"""

from collections.abc import Mapping
from typing import Any

import casadi as ca

from observers.embedded.casadi_c import embedded_code
from observers.embedded.compact_bristle_ekf import GivenTorque
from observers.embedded.compact_bristles import CompactBristles, has_bristles
from observers.embedded.compact_mhe import (
    TEST,
    no_torque,
    symbols,
    window_functions,
)
from observers.embedded.compact_window import window_state, window_values
from observers.embedded.constants import Constants, Tunable
from observers.embedded.scalar_type import Real
from observers.embedded.supervision_code import supervised, supervision_functions
from observers.embedded.templating import Body, render
from observers.innovation_monitor import change_variance
from observers.layout import named
from observers.linearisation import build_motion, state_index
from observers.measurement_model import CLEAN
from observers.mhe import Mhe
from observers.mhe_terms import is_unsettled
from observers.model_observer import ModelObserver, friction_output, step_output
from observers.patch_update import reset_retention, sensitivity_retention
from observers.protocol import FunctionObserver
from observers.tuning import TUNING_FIELDS
from symbolic import DECLARED
from symbolic.compilation.scalar_c import c_function


def is_compact_bristle_window(observer: FunctionObserver) -> bool:
    """True for one iteration over two samples or more, on bristles."""
    if type(observer) is not Mhe:
        return False
    return observer.iterations == 1 and observer.window >= 2 and has_bristles(observer)


def bristle_window_body(observer: Mhe, real: Real, terms: Mapping[str, Any]) -> Body:
    """The code of an estimator for which `is_compact_bristle_window` holds."""
    bristles, window = CompactBristles(observer, real), observer.window
    functions = window_functions(observer, output_with_slide, terms["tunable"])
    functions += supervision_functions(observer, terms["tunable"])
    source = embedded_code(functions, real, f"{terms['name']}_core", null_checks=False)
    values = {
        **terms, **window_values(observer), **bristles.terms, "a": repr(float(observer.rig.a)),
    }  # fmt: skip
    kept = f"M_z[{window}], by_mu[{window}], mu[{window}]"
    private, size = window_state(observer, real, terms["name"], kept, 3)
    scalar = c_function("retentions", _build_retentions(observer, terms["tunable"]), real.c_type)
    body = Body(
        core=f"{source.text}\n{bristles.numbers(values, scalar)}\n{scalar}\n{bristles.text(values)}",
        stepping=render("window.c", values),
        private=private,
        bytes=size + bristles.bytes,
        types=bristles.state_type(terms["name"]),
    )
    return supervised(observer, real, values, body, source, None)


def _build_retentions(observer: ModelObserver, tunable: Tunable) -> ca.Function:
    """(P, now) -> shares of the bristles' derivative that a walk of mu leaves, and a new ground."""
    sensing, n = observer.measurement_model, len(observer.states)
    P, now, rig, tuning = symbols(observer, "P", "now", "rig", "tuning")
    x, last = ca.MX.zeros(n), ca.MX.zeros(len(CLEAN))
    _, _, Q, _ = build_motion(sensing)(x, *no_torque(observer), last, now, rig, tuning)
    at = state_index(sensing)
    walk = sensitivity_retention(sensing, P, Q, x)
    change = reset_retention(ca.MX(1), P[at, at], change_variance(named(TUNING_FIELDS, tuning)))
    function = ca.Function(
        "retentions", [ca.vec(P), now, rig, tuning], [ca.vertcat(walk, change)],
        ["P", "now", "rig", "tuning"], ["retention"],
    )  # fmt: skip
    return Constants(observer, tunable).fill("retentions", function)


def output_with_slide(observer: Mhe) -> ca.Function:
    """(x, P, newest, now, test, imputed, slide) -> output."""
    names = ("x", "P", "newest", "now", "test", "imputed", "rig", "tuning")
    x, P, newest, now, test, imputed, rig, tuning = given = symbols(observer, *names)
    slide = ca.MX.sym("slide", 2)
    result, at = named(TEST, test), state_index(observer.measurement_model)
    memory = ca.vertcat(0, 0, 0, slide)
    theta = ca.MX(ca.DM(observer.constants[: len(DECLARED)]))
    friction = friction_output(GivenTorque(), x, P, memory, now, theta, rig, tuning, at=at)
    output = step_output(
        observer.measurement_model, x, friction, result["expected"], tuning, result, held=imputed,
        unsettled=is_unsettled(observer.measurement_model, x, newest, P),
    )  # fmt: skip
    inputs = [*given[:6], slide, rig, tuning]
    return ca.Function(
        "step_output", inputs, [ca.densify(output)], [s.name() for s in inputs], ["output"]
    )
