"""What a window keeps of the patch, so that M_z at each of its samples can be had for other states.

The memory after each sample is kept as the patch met it, with its derivative by the tyre where it has
one; for other states of the tyre it is moved to first order, and the torque is taken anew. For the
declared patch nothing has to be moved. Where the angle is a state, a sample's torque follows its own
angle by its slope; the angles before it are held as they were when the sample came in, to within what an
encoder leaves open.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import casadi as ca

from observers.measurement_model import MeasurementModel
from observers.patch_update import (
    build_meeting,
    build_torque,
    by_states,
    carries,
    history_fields,
    signals_of,
    tyre_of,
)
from symbolic import SIGNALS, Model

Parts = Mapping[str, ca.MX]
Kept = dict[str, ca.MX]


@dataclass(frozen=True, kw_only=True)
class Recall:
    """How a model's patch is recalled over a window; parts hold one block of columns a sample.

    Attributes:
        model: the model.
        measurement_model: what is measured.
        window: samples kept, N.
    """

    model: Model
    measurement_model: MeasurementModel
    window: int

    @property
    def blocks(self) -> tuple[tuple[str, int, int], ...]:
        """Names, rows and columns of what is kept of one sample."""
        turned = (("turned", 2, 1),) if self.measurement_model.turns else ()
        return (*history_fields(self.model, self.measurement_model), ("seen", len(SIGNALS), 1), *turned)

    @property
    def fields(self) -> tuple[tuple[str, int, int], ...]:
        """Names and shapes of what is kept of all samples, oldest first."""
        return tuple((name, rows, columns * self.window) for name, rows, columns in self.blocks)

    def newest(self, parts: Parts) -> Kept:
        """What is kept of the newest sample alone."""
        return {name: parts[name][:, -columns:] for name, _, columns in self.blocks}

    def without_oldest(self, parts: Parts) -> Kept:
        """What is kept of all samples but the oldest."""
        return {name: parts[name][:, columns:] for name, _, columns in self.blocks}

    def enter(self, parts: Parts, share: ca.MX, now: ca.MX, x: ca.MX, theta: ca.MX, rig: ca.MX) -> Kept:
        """What is kept with one more sample, the oldest dropped.

        Args:
            parts: what is kept.
            share: what a walk of the tyre leaves of the derivative, see `kept_share`.
            now: the sample, cleaned.
            x: the states at which the patch meets it, (n,).
            theta: parameters of the model.
            rig: numbers of the rig, a and e first.
        """
        latest = self.newest(parts)
        history = [latest[name] for name, *_ in history_fields(self.model, self.measurement_model)]
        if carries(self.model, self.measurement_model):
            history[1] = history[1] @ share
        signals = signals_of(self.measurement_model, x, now)
        meeting = build_meeting(self.model, self.measurement_model)
        *met, _, slopes = meeting(*history, signals, tyre_of(self.measurement_model, x), theta, rig[:2])
        if self.measurement_model.turns:
            met.append(ca.vertcat(x[self.measurement_model.states.index("psi")], slopes[0]))
        older = self.without_oldest(parts)
        return {
            name: ca.horzcat(older[name], new) for (name, *_), new in zip(self.blocks, met, strict=True)
        }

    def torques(self, parts: Parts, x: ca.MX, theta: ca.MX, rig: ca.MX) -> tuple[ca.MX, ca.MX]:
        """M_z (1, N) and its slopes (d, N) by the states at x (n, N), for the first N samples kept."""
        count = x.shape[1]
        through = _torques_of(self.model, self.measurement_model, count)
        kept = {name: parts[name][:, : columns * count] for name, _, columns in self.blocks}
        turned = kept.pop("turned", None)
        constant = (ca.repmat(vector, 1, count) for vector in (theta, rig[:2]))
        M_z, slopes = through(*kept.values(), tyre_of(self.measurement_model, x), *constant)
        if turned is not None:
            M_z = M_z + turned[1, :] * (x[self.measurement_model.states.index("psi"), :] - turned[0, :])
            slopes = ca.vertcat(turned[1, :], slopes)
        return M_z, by_states(self.measurement_model, slopes, x)


@cache
def _torques_of(model: Model, measurement_model: MeasurementModel, count: int) -> ca.Function:
    """The torque of so many samples; one Function for all, so that its code is made once."""
    torque = build_torque(model, measurement_model)
    return torque.map(count) if count > 1 else torque
