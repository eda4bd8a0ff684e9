"""Extended Kalman filter for ln mu and, as measured, torque zero, stiffness, angle and rate.

The memory of the patch is not filtered: `observers.patch.update` propagates it. M_z and its derivatives
are the model's; the filter contains no tyre model.

Source: Jazwinski, Stochastic Processes and Filtering Theory (1970), section 8.3, iterated filter
theorem 8.2; the covariance is kept as a factor, see `observers.udu`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import casadi as ca

from observers.estimators.ekf_mhe_step_terms import StepSample, clip_to_bounds, step_symbols
from observers.estimators.model_observer import ModelObserver
from observers.layout import Layout, Parts
from observers.measurement.measurement_model import CLEAN, MeasurementModel
from observers.measurement.motion_and_torque_jacobians import (
    angle_is_state,
    build_linearised_measurement,
    build_linearised_motion,
    slope_states,
)
from observers.patch.patch_protocol import PatchModel
from observers.patch.update import (
    advance_patch,
    memory_depends_on_tyre,
    memory_fields,
    reset_retention,
    scale_memory_sensitivity,
    sensitivity_retention,
    slopes_by_states,
)
from observers.protocol import OUTPUT
from observers.quality.friction_change_by_stroke import change_monitor_fields
from observers.quality.outlier_or_ground_change import COUNTS, huber_weight, innovation_variance
from observers.udu import (
    add_variance,
    build_udu_prediction,
    build_udu_update,
    symbolic_covariance_from_udu,
)
from symbolic.named_and_buffered_functions import named_function


@dataclass(frozen=True, kw_only=True)
class Ekf(ModelObserver):
    """The filter: settings as of `ModelObserver`, and how often it linearises.

    Attributes:
        iterations: linearisations of a measurement; 1 is the plain filter. More pay where one sample
            is very informative: under a clean torque, while little is known of mu.

    Parts of its state: `memory` (m,) of the patch and, where it depends on the tyre,
    `memory_sensitivity` (m, t) and the tyre's parameters `linearisation_point` (t,) that it holds for;
    `x` (n,) in the order of `states` and `factor` (n, n) of its covariance, see `covariance_of`; `last`,
    the last sample; `M_z` and `slopes`; `counts`, streak and changes of the ground; `monitor`, see
    `observers.quality.slow_change_and_misfit_alarms`; `output`.
    """

    iterations: int = 1

    @property
    def kind(self) -> str:
        """Kind of the estimator, for its title."""
        return "Extended Kalman filter"

    @property
    def estimator_layout(self) -> Layout:
        """The parts of a state, less those of the supervision."""
        return ekf_layout(self.model, self.measurement_model)

    @property
    def estimator_step(self) -> ca.Function:
        """One sample, without the supervision."""
        return build_ekf_step(self.model, self.measurement_model, self.iterations)


@cache
def ekf_layout(model: PatchModel, measurement_model: MeasurementModel) -> Layout:
    """The parts of the filter's state."""
    n = len(measurement_model.states)
    return Layout.of(
        *memory_fields(model, measurement_model), x=n, factor=(n, n), last=len(CLEAN), M_z=1,
        slopes=len(slope_states(measurement_model)), counts=len(COUNTS),
        monitor=len(change_monitor_fields(measurement_model)), output=len(OUTPUT),
    )  # fmt: skip


@cache
def build_ekf_step(
    model: PatchModel, measurement_model: MeasurementModel, iterations: int, *, commented: bool = False
) -> ca.Function:
    """One sample of the filter; with comments, what stands between comes before state and output."""
    parts = ekf_layout(model, measurement_model)
    inputs = step_symbols(model, parts)
    before = parts.split(inputs["state"])
    sample = StepSample.of(model, measurement_model, inputs, before["last"])
    predicted, predicted_factor, memory = _predict(sample, before)
    # A measured angle does not depend on the patch at the sample itself; a measured torque does.
    follows_angle = angle_is_state(measurement_model)
    patch = before if follows_angle else _update_patch(sample, memory, predicted)
    P = symbolic_covariance_from_udu(predicted_factor)
    test = sample.test_innovation(before, predicted, P, patch["M_z"], patch["slopes"])
    correct = _build_state_correction(sample, predicted, predicted_factor, test)
    x, factor = correct(test["innovation"], test["H"])
    for _ in range(0 if measurement_model.is_linear else iterations - 1):
        patch = _update_patch(sample, memory, x)
        # Linearised again at the corrected states.
        residual, H, *_ = build_linearised_measurement(measurement_model)(
            x, patch["M_z"], patch["slopes"], sample.now, sample.rig, sample.tuning
        )
        x, factor = correct(residual - ca.dot(H, predicted - x), H)
    M_z = test["expected"]
    if follows_angle:
        patch = _update_patch(sample, memory, x)
        M_z = patch["M_z"]
    if memory_depends_on_tyre(model, measurement_model):
        variance = P[sample.mu_index, sample.mu_index]
        retention = reset_retention(
            test["reset"], variance, test["reset"] * sample.ground_change_variance
        )
        patch = {**patch, "memory_sensitivity": retention * patch["memory_sensitivity"]}
    output = sample.output(x, symbolic_covariance_from_udu(factor), patch["memory"], M_z, test)
    state_next = {
        **patch, "x": x, "factor": factor, "last": sample.sample_with_test_result(test),
        "counts": test["counts_next"], "monitor": test["monitor_next"], "output": output,
    }  # fmt: skip
    between = {
        "predicted_x": predicted, "predicted_factor": predicted_factor, "innovation": test["innovation"],
        "innovation_variance": innovation_variance(test["H_P_H"], test["weight"], test["huber_scale"]),
        "accepted": test["accepted"], "reset": test["reset"],
    }  # fmt: skip
    outputs = {"state_next": parts.join(state_next), "output": output}
    return named_function("ekf_step", inputs, {**between, **outputs} if commented else outputs)


def _predict(sample: StepSample, before: Parts) -> tuple[ca.MX, ca.MX, Parts]:
    """States at the sample before it is measured, the factor of their covariance, and the memory."""
    model, measurement_model = sample.model, sample.measurement_model
    x, A, Q, _ = build_linearised_motion(measurement_model)(
        before["x"], before["M_z"], before["slopes"], before["last"], sample.now, sample.rig,
        sample.tuning,
    )  # fmt: skip
    factor = build_udu_prediction(x.numel())(before["factor"], A, Q)
    P = symbolic_covariance_from_udu(before["factor"])
    retention = sensitivity_retention(measurement_model, P, Q, before["x"], sample.now)
    return x, factor, scale_memory_sensitivity(model, measurement_model, before, retention)


def _update_patch(sample: StepSample, memory: Parts, x: ca.MX) -> Parts:
    """Memory, M_z and slopes by the states after the sample, at the states x."""
    model = sample.measurement_model
    patch = advance_patch(sample.model, model, memory, x, sample.now, sample.theta, sample.rig)
    return {**patch, "slopes": slopes_by_states(model, patch["slopes"], x)}


def _build_state_correction(
    sample: StepSample, x: ca.MX, factor: ca.MX, test: Parts
) -> Callable[[ca.MX, ca.MX], tuple[ca.MX, ca.MX]]:
    """(innovation, H) -> states within their bounds and their factor, from predicted x and factor."""
    increment = test["reset"] * sample.ground_change_variance
    factor = add_variance(factor, sample.mu_index, increment)
    spread = test["H_P_H"] + increment * test["H"][sample.mu_index] ** 2
    weight = test["weight"] * test["accepted"]
    weight = weight * huber_weight(test["innovation"], test["huber_scale"], spread)

    def correct(innovation: ca.MX, H: ca.MX) -> tuple[ca.MX, ca.MX]:
        factor_next, K, _ = build_udu_update(x.numel())(factor, H, weight)
        return clip_to_bounds(sample.measurement_model, x + K * innovation, sample.tuning), factor_next

    return correct
