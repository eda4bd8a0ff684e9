"""Functions of a sample that the filter and the window share."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import casadi as ca

from observers.embedded.patches.patch_code import PatchCode
from observers.embedded.scalar_expansion import ConstantSubstitution, inputs_used
from observers.estimators.initial_state import build_initial_state
from observers.estimators.mhe_recursions import build_forward_elimination
from observers.estimators.model_observer import ModelObserver
from observers.layout import Layout, named, outputs_of
from observers.measurement.measurement_model import CLEAN, RIG, ROWS, MeasurementModel
from observers.measurement.motion_and_torque_jacobians import (
    build_clean,
    build_linearised_motion,
    slope_states,
    state_index,
)
from observers.patch.patch_protocol import build_effective_friction
from observers.patch.update import reset_retention, sensitivity_retention, signals_with_states
from observers.protocol import SAMPLE
from observers.quality.slow_change_and_misfit_alarms import log_mu_variance_between_grounds
from observers.tuning import TUNING_FIELDS
from symbolic import DECLARED
from symbolic.named_and_buffered_functions import named_function


@dataclass(frozen=True, kw_only=True)
class EstimatorCode:
    """An estimator on a patch as C; NAME stands for the name of the code."""

    template: str  # Defines `begin` and `advance`, which the public functions call.
    # Functions of scalars that it calls, beside those of every estimator.
    functions: Sequence[ca.Function]
    element_names: Mapping[str, Sequence[str]]  # Names of the elements of its vectors.
    terms: Mapping[str, Any]  # Values of its placeholders.
    types: str = ""  # Types of the state, C of the header.
    private_fields: str  # Fields of the state, the patch among them.
    bytes: int  # Of these without the patch.


TORQUE = {"log_mu": "BY_MU", "stiffness": "BY_STIFFNESS", "psi": "BY_ANGLE"}
"""Index constant in C of the torque's derivative, by the state: mu, k over nominal, the angle."""


def function_of_symbols(name: str, inputs: Sequence[ca.MX], **outputs: ca.MX) -> ca.Function:
    """A Function whose inputs have the names of their symbols."""
    columns = {name: ca.densify(ca.vec(ca.MX(output))) for name, output in outputs.items()}
    return named_function(name, {symbol.name(): symbol for symbol in inputs}, columns)


def initial_state_parts(
    name: str, patch: PatchCode, parts: Layout, names: Mapping[str, str]
) -> ca.Function:
    """(sample, constants) -> parts of the state before a first sample, by their names as outputs."""
    start = build_initial_state(patch.torque_model, patch.observer.measurement_model, parts)
    sample, constants = (ca.MX.sym(start.name_in(i), start.numel_in(i)) for i in range(2))
    first = parts.split(start(sample, constants))
    return function_of_symbols(name, [sample, constants], **{names[part]: first[part] for part in names})


def clean_and_patch_signals(observer: ModelObserver) -> list[ca.Function]:
    """`clean` and `patch_signals`."""
    model = observer.measurement_model
    sample, last = ca.MX.sym("sample", len(SAMPLE)), ca.MX.sym("last", len(CLEAN))
    x, now = ca.MX.sym("x", len(model.states)), ca.MX.sym("now", len(CLEAN))
    cleaned, imputed = build_clean(model)(sample, last)
    return [
        function_of_symbols("clean", [sample, last], now=cleaned, imputed=imputed),
        function_of_symbols("patch_signals", [x, now], signals=signals_with_states(model, x, now)),
    ]


def sensitivity_retentions(
    observer: ModelObserver,
    constants: ConstantSubstitution,
    factor: ca.MX,
    variances: ca.MX,
    *,
    predicted: bool,
) -> ca.Function:
    """Share of the memory's derivative by mu after its walk, and after a reset.

    With k a state too mu is an input, and the first share a matrix, column by column, for derivatives by
    mu and k. factor is the symbol of a covariance in the form that the estimator has, variances that
    covariance; predicted: the variance of ln mu on a new ground adds to that after the walk.
    """
    model, n = observer.measurement_model, len(observer.states)
    last, now = ca.MX.sym("last", len(CLEAN)), ca.MX.sym("now", len(CLEAN))
    rig = ca.MX.sym("rig", len(RIG))
    tuning, x = ca.MX.sym("tuning", len(TUNING_FIELDS)), ca.MX.zeros(n)
    # Neither the states nor the torque matter to the walk of ln mu. At ln mu = 0, d mu / d ln mu is 1.
    slopes = ca.DM.zeros(len(slope_states(model)))
    _, _, Q, _ = build_linearised_motion(model)(x, 0, slopes, last, now, rig, tuning)
    at = state_index(model)
    walk, mu = ca.MX(sensitivity_retention(model, variances, Q, x, now)), []
    if walk.numel() > 1:  # From ln mu to mu.
        mu = [ca.MX.sym("mu")]
        walk[1, 0], walk[0, 1] = walk[1, 0] / mu[0], walk[0, 1] * mu[0]
    variance = variances[at, at] + Q[at] if predicted else variances[at, at]
    change = reset_retention(
        ca.MX(1), variance, log_mu_variance_between_grounds(named(TUNING_FIELDS, tuning))
    )
    function = function_of_symbols(
        "retentions", [factor, last, now, *mu, rig, tuning], retention=ca.vertcat(ca.vec(walk), change)
    )
    return constants.substitute_constants("retentions", function)


def effective_friction(patch: PatchCode) -> ca.Function:
    """(mu, mu_std, F_N, slide) -> (mu_eff, mu_eff_std, M_slide)."""
    model, rig = patch.torque_model, patch.observer.rig
    mu, std, F_N = ca.MX.sym("mu"), ca.MX.sym("mu_std"), ca.MX.sym("F_N")
    slide = ca.MX.sym("slide", 2)
    memory = model.memory_layout.join(memory_with_slide_only(patch, slide))
    given = (mu, std, memory, F_N, ca.DM.ones(len(DECLARED)), ca.DM([rig.a, rig.e]), 0.0)
    friction = outputs_of(build_effective_friction(model), *given)
    return function_of_symbols("effective_friction", [mu, std, F_N, slide], **friction).expand()


def stiffness_ratio_c(model: MeasurementModel, x: str) -> str:
    """C of k over its nominal value at states x."""
    return f"{x}[{state_index(model, 'stiffness')}]" if "stiffness" in model.states else "1.0"


def memory_with_slide_only(patch: PatchCode, slide: ca.MX) -> dict[str, ca.MX]:
    """A memory of the linearised patch of which only the slide is known."""
    known = dict(zip(("slide", "beside"), ca.vertsplit(slide), strict=True))
    return {name: known.get(name, ca.MX(0)) for name, _, _ in patch.torque_model.memory_layout.fields}


@cache
def motion_depends_on_patch_torque(model: MeasurementModel) -> bool:
    """True where the motion of the states depends on the torque of the patch."""
    return not inputs_used(build_linearised_motion(model)).isdisjoint(("M_z", "slopes"))


@cache
def stored_fields(model: MeasurementModel) -> tuple[str, ...]:
    """Those of `ROWS` that the terms of a window depend on: what C stores of a sample."""
    forward = build_forward_elimination(model)
    used = {ROWS.index(name) for name in ("F_N", "dt", "accepted", "jump")}
    for name in ("row", "row_next"):
        at = forward.index_in(name)
        for i in range(forward.n_out()):
            used.update(forward.jac_sparsity(i, at).get_triplet()[1])
    return tuple(name for i, name in enumerate(ROWS) if i in used)
