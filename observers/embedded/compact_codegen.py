"""An estimator on a patch, each chosen by itself, joined to compact C.

Another kind of sensing is a `MeasurementModel` alone: C takes what it needs from its expressions.
"""

import re
from collections.abc import Callable, Mapping
from typing import Any

from observers.embedded.estimators.acquisition_around_estimator import (
    acquisition_functions,
    verdict_function_and_loop_c,
    with_supervision,
)
from observers.embedded.estimators.compact_ekf import compact_ekf_code
from observers.embedded.estimators.compact_mhe import compact_mhe_code
from observers.embedded.estimators.shared_step_functions import EstimatorCode, clean_and_patch_signals
from observers.embedded.jinja_templates import ObserverBody, render
from observers.embedded.patches.bristles import bristle_patch_code, has_bristles
from observers.embedded.patches.exact_patch import exact_patch_code, has_exact_patch
from observers.embedded.patches.patch_code import PatchCode
from observers.embedded.scalar_expansion import (
    ConstantSubstitution,
    Tunable,
    add_comment_and_own_exp_log,
    estimator_c,
)
from observers.embedded.scalar_type import Real
from observers.estimators.ekf import Ekf
from observers.estimators.mhe import Mhe
from observers.estimators.model_observer import ModelObserver
from observers.measurement.measurement_model import CLEAN
from observers.measurement.motion_and_torque_jacobians import angle_is_state, slope_states
from observers.patch.update import memory_depends_on_tyre
from observers.protocol import OUTPUT, SAMPLE, FunctionObserver
from observers.quality.acquisition import OWN
from observers.quality.friction_change_by_stroke import change_monitor_fields
from observers.quality.hysteresis_branches import TRACK
from observers.quality.mu_and_scale_from_hypotheses import VERDICT
from observers.quality.mu_over_k_hypotheses import SETTINGS, hypothesis_fields
from observers.quality.outlier_or_ground_change import COUNTS
from symbolic import DECLARED
from symbolic.compilation.scalar_c import ELEMENTARY

ESTIMATORS: Mapping[type, Callable[[PatchCode, ConstantSubstitution], EstimatorCode]] = {
    Ekf: compact_ekf_code,
    Mhe: compact_mhe_code,
}
"""Estimators in compact C; a subclass may compute something else."""
ANY = ("any_log", "any_exp")
"""Functions of `templates/elementary_functions.c` that have an answer to any number."""


def compact_patch(observer: FunctionObserver, real: Real, tunable: Tunable = "") -> PatchCode | None:
    """The patch of an observer in compact C; None where CasADi writes all of the observer, as vectors.

    There is one for an `Ekf` of one linearisation and an `Mhe` of one iteration over two samples or
    more, neither a subclass.
    """
    if not isinstance(observer, ModelObserver) or ESTIMATORS.get(type(observer)) is None:
        return None
    if getattr(observer, "iterations", 1) != 1 or getattr(observer, "window", 2) < 2:
        return None
    model = observer.measurement_model
    # C adds a variance of ln mu to one element of a factor U D U', which is right for the first state.
    if model.states[0] != "log_mu":
        return None
    if has_bristles(observer):
        patch = bristle_patch_code(observer, real)
    elif isinstance(observer, Mhe) and memory_depends_on_tyre(observer.model, model):
        return None
    elif has_exact_patch(observer):
        patch = exact_patch_code(observer, real, rig_at_run_time=tunable == "all")
    else:
        return None
    return patch if patch.takes_rig or tunable != "all" else None


def compact_body(patch: PatchCode, terms: Mapping[str, Any]) -> ObserverBody:
    """The part of generated code that differs between observers."""
    observer, real, model = patch.observer, patch.real, patch.observer.measurement_model
    constants = ConstantSubstitution(observer, terms["tunable"], theta=range(len(DECLARED)))
    name = terms["name"]
    estimator = ESTIMATORS[type(observer)](patch, constants)
    values = {
        **terms, **patch.terms, "clean": len(CLEAN), "counts": len(COUNTS),
        "monitor": len(change_monitor_fields(model)), "states": len(model.states),
        "advances_at_corrected_state": angle_is_state(model),
        "follows_mu": patch.follows_mu,
        "slides": patch.torque_model.slides, **estimator.terms,
    }  # fmt: skip
    functions = [*clean_and_patch_signals(observer), *estimator.functions]
    functions += acquisition_functions(observer, constants)
    names = {**_vector_element_names(observer), **estimator.element_names}
    texts = [estimator_c(function, real, names) for function in functions]
    if observer.acquire:
        verdict, text = verdict_function_and_loop_c(observer, real, terms["tunable"])
        texts.append(add_comment_and_own_exp_log(verdict, "verdict_of", text, names))
    written = "\n".join(texts)
    functions_of_patch = re.sub(r"\bexp\(", "any_exp(", patch.functions)
    of_patch = "\n".join([functions_of_patch, *(render(name, values) for name in patch.templates)])
    stepping = render(estimator.template, values)
    used = [name for name in (*ELEMENTARY, *ANY) if f"{name}(" in written + of_patch + stepping]
    if observer.acquire:
        used.append("any_exp")
    elementary = render("elementary_functions.c", {**values, "used": used})
    body = ObserverBody(
        core=elementary + render("patches/torque_places.c", values) + written + of_patch,
        stepping=stepping,
        private_fields=estimator.private_fields.replace("NAME", name),
        bytes=estimator.bytes + patch.bytes,
        types=render(patch.type_template, values) + estimator.types.replace("NAME", name),
        rig_at_run_time=bool(values["rig_at_run_time"]),
    )
    return with_supervision(observer, real, values, body)


def _vector_element_names(observer: ModelObserver) -> dict[str, tuple[str, ...]]:
    """Names of the elements of vectors, by those of the vectors."""
    states, slopes = observer.states, slope_states(observer.measurement_model)
    pairs = [(row, column) for column in states for row in states]
    # Column by column: P = U D U', U being upper triangular with ones on its diagonal.
    order = {state: i for i, state in enumerate(states)}
    factor = tuple(
        f"D of {r}" if r == c else f"U of {r} by {c}" if order[r] < order[c] else "0" for r, c in pairs
    )
    covariance = tuple(f"variance of {r}" if r == c else f"covariance of {r}, {c}" for r, c in pairs)
    return {
        "sample": SAMPLE, "last": CLEAN, "now": CLEAN, "x": states, "mean": states, "newest": states,
        "slopes": slopes, "counts": COUNTS, "output": OUTPUT, "result": OUTPUT,
        "monitor": change_monitor_fields(observer.measurement_model),
        "own": OWN, "track": TRACK, "part": hypothesis_fields("gear" in states), "limits": SETTINGS,
        "verdict": VERDICT, "factor": factor, "P": covariance,
    }  # fmt: skip
