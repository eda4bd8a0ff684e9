"""Extended Kalman filter for ln mu and, as measured, torque zero, stiffness, angle and rate.

The memory of the patch is not filtered: `observers.patch_update` propagates it. M_z and its derivatives
are the model's; the filter contains no tyre model.

Source: Jazwinski, Stochastic Processes and Filtering Theory (1970), section 8.3, iterated filter
theorem 8.2; the covariance is kept as a factor, see `observers.udu`.
"""

from dataclasses import dataclass
from functools import cache, partial

import casadi as ca

from observers.innovation_gate import COUNTS, build_innovation, huber_weight
from observers.innovation_monitor import MONITOR, change_variance
from observers.layout import Layout, named, outputs_of
from observers.linearisation import (
    build_clean,
    build_measurement,
    build_motion,
    build_predict_covariance,
    build_update_covariance,
    directions,
    state_index,
)
from observers.measurement_model import CLEAN, MeasurementModel
from observers.model_observer import (
    ModelObserver,
    build_step_function,
    clip_to_bounds,
    friction_output,
    step_output,
    step_symbols,
)
from observers.patch_model import PatchModel, split_constants
from observers.patch_update import (
    build_patch_update,
    memory_depends_on_tyre,
    memory_fields,
    patch_signals,
    reset_retention,
    sensitivity_retention,
    slopes_by_states,
    tyre_parameters,
)
from observers.protocol import OUTPUT
from observers.tuning import TUNING_FIELDS
from observers.udu import covariance
from symbolic import GEOMETRY, InvalidInputError


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
    `observers.innovation_monitor`; `output`.
    """

    iterations: int = 1

    def __post_init__(self) -> None:
        """Check the settings."""
        super().__post_init__()
        if not (isinstance(self.iterations, int) and self.iterations >= 1):
            raise InvalidInputError(
                f"iterations must be a whole number of at least 1, got {self.iterations}"
            )

    @property
    def kind(self) -> str:
        """What sort of estimator it is."""
        return "Extended Kalman filter"

    @property
    def layout(self) -> Layout:
        """The parts of a state."""
        return self.with_supervision(layout(self.model, self.measurement_model))

    @property
    def step_function(self) -> ca.Function:
        """One sample; see `CasadiObserver.step_function`."""
        step = build_step(self.model, self.measurement_model, self.iterations)
        return self.supervised(step, layout(self.model, self.measurement_model))


@cache
def layout(model: PatchModel, measurement_model: MeasurementModel) -> Layout:
    """The parts of the filter's state."""
    n = len(measurement_model.states)
    return Layout(
        (
            *memory_fields(model, measurement_model),
            ("x", n, 1),
            ("factor", n, n),
            ("last", len(CLEAN), 1),
            ("M_z", 1, 1),
            ("slopes", len(directions(measurement_model)), 1),
            ("counts", len(COUNTS), 1),
            ("monitor", len(MONITOR), 1),
            ("output", len(OUTPUT), 1),
        )
    )


@cache
def build_step(
    model: PatchModel, measurement_model: MeasurementModel, iterations: int = 1
) -> ca.Function:
    """One sample of the filter: (state, sample, constants) -> (state_next, output)."""
    parts = layout(model, measurement_model)
    state, sample, constants = symbols = step_symbols(model, parts)
    before = parts.split(state)
    theta, rig, tuning = split_constants(model, constants)
    now, imputed = build_clean(measurement_model)(sample, before["last"])
    x, A, Q, _ = build_motion(measurement_model)(
        before["x"], before["M_z"], before["slopes"], before["last"], now, rig, tuning
    )
    factor = build_predict_covariance(x.numel())(before["factor"], A, Q)
    memory = _predicted_memory(model, measurement_model, before, Q)
    update_patch = partial(_update_patch, model, measurement_model, memory, now, theta, rig)
    patch = measurement_model.patch_before(before, partial(update_patch, x))
    test = outputs_of(
        build_innovation(measurement_model), x, covariance(factor), patch["M_z"], patch["slopes"],
        now, before["counts"], before["monitor"], rig, tuning,
    )  # fmt: skip
    at = state_index(measurement_model)
    variance = covariance(factor)[at, at]
    increment = test["reset"] * change_variance(named(TUNING_FIELDS, tuning))
    factor[at, at] += increment
    spread = test["H_P_H"] + increment * test["H"][at] ** 2
    weight = test["weight"] * test["accepted"]
    weight = weight * huber_weight(test["innovation"], test["huber_scale"], spread)
    correct = partial(_correct, measurement_model, x, factor, weight, tuning)
    corrected, after = correct(test["innovation"], test["H"])
    for _ in range(0 if measurement_model.is_linear else iterations - 1):
        patch = update_patch(corrected)
        residual, H, *_ = build_measurement(measurement_model)(
            corrected, patch["M_z"], patch["slopes"], now, rig, tuning
        )
        corrected, after = correct(residual - ca.dot(H, x - corrected), H)

    def updated() -> tuple[dict[str, ca.MX], ca.MX]:
        followed = update_patch(corrected)
        return followed, followed["M_z"]

    patch, M_z = measurement_model.patch_after((patch, test["expected"]), updated)
    if memory_depends_on_tyre(model, measurement_model):
        retention = reset_retention(test["reset"], variance, increment)
        patch["memory_sensitivity"] = retention * patch["memory_sensitivity"]
    friction = friction_output(
        model, corrected, covariance(after), patch["memory"], now, theta, rig, tuning, at=at
    )
    output = step_output(measurement_model, corrected, friction, M_z, tuning, test, held=imputed)
    state_next = {
        **patch, "x": corrected, "factor": after, "last": now, "counts": test["counts_next"],
        "monitor": test["monitor_next"], "output": output,
    }  # fmt: skip
    return build_step_function("ekf_step", symbols, parts.join(state_next), output)


def _predicted_memory(
    model: PatchModel, measurement_model: MeasurementModel, before: dict[str, ca.MX], Q: ca.MX
) -> dict[str, ca.MX]:
    """The parts of the memory, with the sensitivity that a random walk by Q (n,) leaves."""
    memory = {name: before[name] for name, *_ in memory_fields(model, measurement_model)}
    if memory_depends_on_tyre(model, measurement_model):
        P = covariance(before["factor"])
        retention = sensitivity_retention(measurement_model, P, Q, before["x"])
        memory["memory_sensitivity"] = memory["memory_sensitivity"] @ retention
    return memory


def _update_patch(
    model: PatchModel,
    measurement_model: MeasurementModel,
    memory: dict[str, ca.MX],
    now: ca.MX,
    theta: ca.MX,
    rig: ca.MX,
    x: ca.MX,
) -> dict[str, ca.MX]:
    """Memory, M_z and slopes by the states after the sample `now`, at the states x."""
    update = build_patch_update(model, measurement_model)
    signals = patch_signals(measurement_model, x, now)
    tyre = tyre_parameters(measurement_model, x)
    results = outputs_of(update, *memory.values(), signals, tyre, theta, rig[: len(GEOMETRY)])
    patch = {name.removesuffix("_next"): result for name, result in results.items()}
    return {**patch, "slopes": slopes_by_states(measurement_model, patch["slopes"], x)}


def _correct(
    measurement_model: MeasurementModel,
    x: ca.MX,
    factor: ca.MX,
    weight: ca.MX,
    tuning: ca.MX,
    innovation: ca.MX,
    H: ca.MX,
) -> tuple[ca.MX, ca.MX]:
    """Corrected states within their bounds, and the factor of their covariance."""
    after, K, _ = build_update_covariance(x.numel())(factor, H, weight)
    return clip_to_bounds(measurement_model, x + K * innovation, tuning), after
