"""Terms that the steps of filter and window share: a sample, its test, bounds, and the output."""

from dataclasses import dataclass
from typing import Any

import casadi as ca

from observers.layout import Expression, Layout, Parts, named, outputs_of, symbols
from observers.measurement.directional_friction import CHANGING, EVIDENCE, OTHER
from observers.measurement.measurement_model import CLEAN, MAX_ZERO_DEVIATIONS, RIG, MeasurementModel
from observers.measurement.motion_and_torque_jacobians import build_clean, state_index
from observers.measurement.torque_error import share_of_full_slide
from observers.patch.patch_protocol import (
    PatchModel,
    build_effective_friction,
    observer_constants_size,
    output_vector,
    split_theta_rig_tuning,
)
from observers.protocol import SAMPLE, Status
from observers.quality.outlier_or_ground_change import build_innovation_test
from observers.quality.slow_change_and_misfit_alarms import log_mu_variance_between_grounds
from observers.tuning import TUNING_FIELDS
from symbolic import GEOMETRY, full_slide_torque

DRY_FRICTION = 0.001
"""Dry friction of bearings of which nothing is declared, as a share of 3/8 F_N a [1]."""
STIFFNESS_BOUNDS = (0.1, 10.0)
"""Bounds of k over its nominal value, where it is a state [1]."""
GEAR_BOUNDS = (0.0, 4.0)
"""Bounds of the gear's dry friction over the declared one, where it is a state [1]."""


def step_symbols(model: PatchModel, parts: Layout) -> dict[str, ca.MX]:
    """Symbols for state, sample and constants of a step."""
    return symbols(ca.MX, state=parts.size, sample=len(SAMPLE), constants=observer_constants_size(model))


def clip_to_bounds(measurement_model: MeasurementModel, x: Expression, tuning: Expression) -> Expression:
    """The states (n,) or (n, N) with mu and k within their bounds."""
    limits = named(TUNING_FIELDS, tuning)
    bounds: dict[str, tuple[Any, Any]] = {
        "log_mu": (ca.log(limits["least"]), ca.log(limits["greatest"])),
        "stiffness": STIFFNESS_BOUNDS,
        OTHER: (ca.log(limits["least"]), ca.log(limits["greatest"])),
        "gear": GEAR_BOUNDS,
    }
    rows = [
        ca.fmax(bounds[name][0], ca.fmin(bounds[name][1], x[i, :])) if name in bounds else x[i, :]
        for i, name in enumerate(measurement_model.states)
    ]
    return ca.vertcat(*rows)


@dataclass(frozen=True, kw_only=True)
class StepSample:
    """Inputs of a step: the sample `now`, cleaned, whether a value of it is imputed, and constants.

    theta are the parameters of the model, rig is as in `RIG` and tuning as in `TUNING_FIELDS`.
    """

    model: PatchModel
    measurement_model: MeasurementModel
    now: ca.MX
    imputed: ca.MX
    theta: ca.MX
    rig: ca.MX
    tuning: ca.MX

    @classmethod
    def of(
        cls, model: PatchModel, measurement_model: MeasurementModel, inputs: Parts, last: ca.MX
    ) -> "StepSample":
        """The sample among the inputs of a step, cleaned with the last one."""
        now, imputed = build_clean(measurement_model)(inputs["sample"], last)
        theta, rig, tuning = split_theta_rig_tuning(model, inputs["constants"])
        return cls(
            model=model, measurement_model=measurement_model, now=now, imputed=imputed, theta=theta,
            rig=rig, tuning=tuning,
        )  # fmt: skip

    @property
    def mu_index(self) -> int:
        """Index of ln mu in the states."""
        return state_index(self.measurement_model)

    @property
    def ground_change_variance(self) -> Expression:
        """The variance that a change of the ground adds to ln mu."""
        return log_mu_variance_between_grounds(named(TUNING_FIELDS, self.tuning))

    def test_innovation(self, before: Parts, x: ca.MX, P: ca.MX, M_z: ca.MX, slopes: ca.MX) -> Parts:
        """The outputs of `build_innovation_test` at predicted states x (n,) of covariance P (n, n)."""
        return outputs_of(
            build_innovation_test(self.measurement_model), x, P, M_z, slopes, self.now, before["counts"],
            before["monitor"], self.rig, self.tuning,
        )  # fmt: skip

    def sample_with_test_result(self, test: Parts) -> ca.MX:
        """The sample as the step after it needs it, with the outcome of its test where that matters."""
        now = ca.MX(self.now)
        if OTHER in self.measurement_model.states:
            now[CLEAN.index(EVIDENCE)] = test["evidence"]
        return now

    def output(
        self, x: ca.MX, P: ca.MX, memory: ca.MX, M_z: ca.MX, test: Parts, **conditions: ca.MX
    ) -> ca.MX:
        """The output of a step in the order of `observers.protocol.OUTPUT`.

        At corrected states x (n,) of covariance P (n, n), from the memory after the sample (m,), the
        predicted M_z [N m], outputs of `build_innovation_test`, and further flags of `Status` in small
        letters.
        """
        log_mu, tuning, rig = x[self.mu_index], named(TUNING_FIELDS, self.tuning), named(RIG, self.rig)
        mu, F_N = ca.exp(log_mu), self.now[CLEAN.index("F_N")]
        # Dry friction in the bearings cannot be told from that of the ground.
        slide, zero = full_slide_torque(F_N, rig["a"]), ca.MX(0)
        dry = share_of_full_slide(rig["dry_friction"], slide, DRY_FRICTION)
        if OTHER in self.measurement_model.states and "M_0" not in self.measurement_model.states:
            # A zero that is no state adds to friction one way and takes from it the other way.
            zero = share_of_full_slide(rig["zero_std"], slide, tuning["zero_std"])
        # Of friction that is stated not to walk no lag is believed.
        variance = ca.fmax(P[self.mu_index, self.mu_index], (tuning["mu_walk"] > 0) * test["lag"] ** 2)
        std = ca.sqrt(mu**2 * (variance + tuning["mu_floor"] ** 2) + dry**2 + zero**2)
        given = (mu, std, memory, F_N, self.theta, self.rig[: len(GEOMETRY)], rig["slide_rate"])
        effective = outputs_of(build_effective_friction(self.model), *given)
        bound = ca.logic_or(log_mu <= ca.log(tuning["least"]), log_mu >= ca.log(tuning["greatest"]))
        flags = {
            "missing": test["missing"], "rejected": ca.logic_not(test["accepted"]),
            "reset": test["reset"], "bound": bound, "inconsistent": test["inconsistent"],
            "held": self.imputed, **conditions,
        }  # fmt: skip
        if "M_0" in self.measurement_model.states:
            # A zero so far off is something else, such as friction that differs by direction.
            i = state_index(self.measurement_model, "M_0")
            first = full_slide_torque(self.now[CLEAN.index("F_N_first")], rig["a"])
            zero_std = share_of_full_slide(rig["zero_std"], first, tuning["zero_std"]) * first
            off = ca.fabs(x[i]) - MAX_ZERO_DEVIATIONS * zero_std
            flags["inconsistent"] = ca.logic_or(flags["inconsistent"], off > 2 * ca.sqrt(P[i, i]))
        if OTHER in self.measurement_model.states:
            # Without hypotheses a prior far off is left behind within the first independent samples.
            flags["acquiring"] = test["untested"]
            flags["inconsistent"] = ca.logic_or(flags["inconsistent"], test["evidence"] > CHANGING)
        status = sum(
            (ca.if_else(holds, int(Status[name.upper()]), 0) for name, holds in flags.items()), ca.MX(0)
        )
        return output_vector(
            mu=mu, mu_std=std, M_z_predicted=M_z, **effective, nis=test["nis"], status=status
        )
