"""Patch memory per sample of a window, so that M_z can be evaluated again at new states.

The memory after each sample is stored with its sensitivity to the tyre where it has one; at other states
of the tyre it is taken to first order, and the torque is evaluated anew. Where the angle is a state, M_z
of a sample is linear in its own angle; the angles before it stay as they were estimated when the sample
came in, to within the resolution of an encoder.
"""

from dataclasses import dataclass

import casadi as ca

from observers.layout import Parts
from observers.measurement.measurement_model import MeasurementModel
from observers.measurement.motion_and_torque_jacobians import slope_states, state_index
from observers.patch.patch_protocol import PatchModel
from observers.patch.update import (
    advance_patch,
    build_patch_torque,
    estimated_tyre_parameters,
    memory_fields,
    scale_memory_sensitivity,
    slopes_by_states,
)
from symbolic import GEOMETRY, SIGNALS


@dataclass(frozen=True, kw_only=True)
class PatchWindow:
    """The patch over a window of samples; parts hold one block of columns per sample, oldest first."""

    model: PatchModel
    measurement_model: MeasurementModel
    window: int

    @property
    def sample_fields(self) -> tuple[tuple[str, int, int], ...]:
        """Names, rows and columns of the parts of one sample; `angle_slope` is psi and dM_z/dpsi."""
        angle = [("angle_slope", 2, 1) for name in slope_states(self.measurement_model) if name == "psi"]
        memory = memory_fields(self.model, self.measurement_model)
        return (*memory, ("patch_signals", len(SIGNALS), 1), *angle)

    @property
    def window_fields(self) -> tuple[tuple[str, int, int], ...]:
        """Names and shapes of the parts of all samples."""
        return tuple((name, rows, columns * self.window) for name, rows, columns in self.sample_fields)

    def newest(self, parts: Parts) -> dict[str, ca.MX]:
        """The parts of the newest sample."""
        return {name: parts[name][:, -columns:] for name, _, columns in self.sample_fields}

    def without_oldest(self, parts: Parts) -> dict[str, ca.MX]:
        """The parts of all samples but the oldest."""
        return {name: parts[name][:, columns:] for name, _, columns in self.sample_fields}

    def append(
        self, parts: Parts, retention: ca.MX, now: ca.MX, x: ca.MX, theta: ca.MX, rig: ca.MX
    ) -> dict[str, ca.MX]:
        """The parts with one more cleaned sample `now`, the oldest dropped.

        The patch is updated at the states x (n,); retention is that of `sensitivity_retention`.
        """
        model, measurement_model = self.model, self.measurement_model
        memory = scale_memory_sensitivity(model, measurement_model, self.newest(parts), retention)
        added = advance_patch(model, measurement_model, memory, x, now, theta, rig)
        if "psi" in slope_states(measurement_model):
            slope = added["slopes"][slope_states(measurement_model).index("psi")]
            added["angle_slope"] = ca.vertcat(x[state_index(measurement_model, "psi")], slope)
        older = self.without_oldest(parts)
        return {name: ca.horzcat(older[name], added[name]) for name, *_ in self.sample_fields}

    def scale_newest_sensitivity(self, parts: Parts, retention: ca.MX) -> dict[str, ca.MX]:
        """The parts with the newest memory's sensitivity, if there is one, multiplied by a scalar."""
        name = "memory_sensitivity"
        if name not in parts:
            return dict(parts)
        columns = self.newest(parts)[name].shape[1]
        older, newest = parts[name][:, :-columns], parts[name][:, -columns:]
        return {**parts, name: ca.horzcat(older, retention * newest)}

    def torques_and_slopes(
        self, parts: Parts, x: ca.MX, theta: ca.MX, rig: ca.MX
    ) -> tuple[ca.MX, ca.MX]:
        """M_z (1, N) and its slopes (d, N) by the states at x (n, N), of the first N samples stored.

        Both are 0 where x has more columns than samples are stored.
        """
        count = min(x.shape[1], parts["memory"].shape[1])
        missing = x.shape[1] - count
        slopes_missing = ca.MX.zeros(len(slope_states(self.measurement_model)), missing)
        if count == 0:
            return ca.MX.zeros(1, missing), slopes_missing
        x = x[:, :count]
        stored = {name: parts[name][:, : columns * count] for name, _, columns in self.sample_fields}
        angle_slope = stored.pop("angle_slope", None)
        constant = (ca.repmat(vector, 1, count) for vector in (theta, rig[: len(GEOMETRY)]))
        torques = build_patch_torque(self.model, self.measurement_model).map(count)
        M_z, slopes = torques(
            *stored.values(), estimated_tyre_parameters(self.measurement_model, x), *constant
        )
        if angle_slope is not None:
            psi, slope = x[state_index(self.measurement_model, "psi"), :], angle_slope[1, :]
            M_z = M_z + slope * (psi - angle_slope[0, :])
            slopes = ca.vertcat(slope, slopes)
        slopes = slopes_by_states(self.measurement_model, slopes, x)
        if missing == 0:
            return M_z, slopes
        return ca.horzcat(M_z, ca.MX.zeros(1, missing)), ca.horzcat(slopes, slopes_missing)
