"""Parts of a diagnosis: errors of a stage, an effect found, a candidate tried, curves of a recording."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from identification.experiments.model_separation import Proposal
from identification.fits.values_by_ground_and_recording import ParameterEstimate
from identification.loop_plot import draw_loops
from symbolic import Scope
from symbolic.float_array_type import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Grade = Literal["strong", "weak", "ambiguous", "stands_in"]


@dataclass(frozen=True, kw_only=True)
class TorqueErrors:
    """Free-run torque errors of one stage of the model.

    Attributes:
        rmse: root mean square torque error of each recording [N m].
        nrmse: the same over the recording's torque range [1].
        training: names over which the training figures are averaged.
        holdout: names over which the held-out figures are averaged.
        left_out: rms torque error of each recording, divided by its torque range; the shared parameters
            were refitted without it. Empty where recordings are held out or there is only one.
        unrefitted: the same of each held-out recording, of which nothing was fitted, see
            `identification.diagnosis.unrefitted_prediction`; but for grounds without a training
            recording.
    """

    rmse: Mapping[str, float]
    nrmse: Mapping[str, float]
    training: tuple[str, ...]
    holdout: tuple[str, ...]
    left_out: Mapping[str, float] = field(default_factory=dict)
    unrefitted: Mapping[str, float] = field(default_factory=dict)

    def summary(self) -> dict[str, float | None]:
        """Averages for `diagnosis.json`; None without recordings to average over."""
        return {
            "left_out_torque_nrmse": _mean(self.left_out, tuple(self.left_out)),
            "torque_rmse": _mean(self.rmse, self.training),
            "torque_nrmse": _mean(self.nrmse, self.training),
            "holdout_torque_rmse": _mean(self.rmse, self.holdout),
            "holdout_torque_nrmse": _mean(self.nrmse, self.holdout),
            "holdout_torque_nrmse_unrefitted": _mean(self.unrefitted, tuple(self.unrefitted)),
        }

    def by_recording(self) -> dict[str, dict[str, float]]:
        """The errors of each recording for `diagnosis.json`."""
        return {
            "torque_rmse": dict(self.rmse),
            "torque_nrmse": dict(self.nrmse),
            "left_out_torque_nrmse": dict(self.left_out),
            "torque_nrmse_unrefitted": dict(self.unrefitted),
        }


@dataclass(frozen=True, kw_only=True)
class FoundEffect:
    """An effect that the search added.

    Attributes:
        name: of the effect.
        summary: the effect in plain words.
        family: the mechanism that it is a law of; its own name where it belongs to none.
        scope: what its parameters belong to; "ground" where each ground has its own.
        grade: how sure it is, see `effect_grade`.
        standard_errors: by how many the model found, without it, has a larger judged error; None where
            that is unknown.
        deviations: between its clearest parameter and no effect at all; None where there is none.
        at_bound: whether one of its parameters ends where its range does.
        parameters: its parameters; one that belongs to a recording has a name like "M_0 [fem1]", one
            that is given and never fitted has no deviation.
        holdout_nrmse_after: judged error once it was added [1].
        delta_bic: Bayesian information criterion of the model found less that without it; negative is
            better.
        indistinguishable_from: effects that the judged data cannot distinguish from it; with
            `unrecorded_load` where the recorded load is constant, and a changing one would do as well.
        experiment: the manoeuvre that would distinguish it from the nearest of those; None without any.
    """

    name: str
    summary: str
    family: str = "other"
    scope: Scope = "tyre"
    grade: Grade = "strong"
    standard_errors: float | None = None
    deviations: float | None = None
    at_bound: bool = False
    parameters: Mapping[str, ParameterEstimate]
    holdout_nrmse_after: float
    delta_bic: float
    indistinguishable_from: tuple[str, ...]
    experiment: Proposal | None = None

    def to_dict(self) -> dict[str, Any]:
        """The content of `diagnosis.json`."""
        fields = {name: value for name, value in vars(self).items() if name != "summary"}
        return fields | {
            "parameters": {name: asdict(estimate) for name, estimate in self.parameters.items()},
            "indistinguishable_from": list(self.indistinguishable_from),
            "experiment": None if self.experiment is None else self.experiment.to_dict(),
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class Curve:
    """Course of a mechanism in one recording; arrays of shape (n,).

    Attributes:
        x_name: what is along the axis.
        x_unit: its unit.
        y_name: what depends on it.
        y_unit: its unit.
        x: places along the axis.
        y: with the family's effects.
        declared: the same by the declared model with the parameters of the final one.
        std: standard deviation of y, infinite where the recordings do not determine it.
    """

    x_name: str
    x_unit: str
    y_name: str
    y_unit: str
    x: Array
    y: Array
    declared: Array
    std: Array

    def to_dict(self) -> dict[str, Any]:
        """The content of `diagnosis.json`; a deviation that is unknown is None."""
        arrays = {name: getattr(self, name).tolist() for name in ("x", "y", "declared")}
        std = [value if np.isfinite(value) else None for value in self.std.tolist()]
        return {**vars(self), **arrays, "std": std}


@dataclass(frozen=True, kw_only=True, eq=False)
class FoundFamily:
    """A mechanism that the declared model misses: a family, or an effect that belongs to none.

    Attributes:
        name: of the family, or of the effect.
        effects: those of the final model that are laws of it, in order of selection.
        rivals: effects that cannot be distinguished from one of these.
        curve: what it does; None where it has no curve.
    """

    name: str
    effects: tuple[str, ...]
    rivals: tuple[str, ...]
    curve: Curve | None

    def to_dict(self) -> dict[str, Any]:
        """The content of `diagnosis.json`."""
        curve = None if self.curve is None else self.curve.to_dict()
        return {**vars(self), "effects": list(self.effects), "rivals": list(self.rivals), "curve": curve}


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """An effect tried alone on top of the declared structure, in the first step of the search.

    Attributes:
        name: of the effect.
        summary: what it does.
        holdout_nrmse: the judged error with it over the torque range [1].
        delta_bic: information criterion with it less that without [1].
        parameters: its shared parameters by name, coarsely fitted.
        at_bound: names of those that end where their range does.
    """

    name: str
    summary: str
    holdout_nrmse: float
    delta_bic: float
    parameters: Mapping[str, ParameterEstimate] = field(default_factory=dict)
    at_bound: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """One recording beside the models, for pictures; arrays of shape (n,).

    Attributes:
        name: the recording.
        held_out: True where shared parameters are not fitted to it.
        t: time [s].
        psi: yaw angle [rad].
        F_N: vertical load [N].
        measured: measured aligning torque [N m], NaN where missing.
        before: torque of the declared structure, refitted [N m].
        after: torque with the effects found, refitted [N m].
    """

    name: str
    held_out: bool
    t: Array
    psi: Array
    F_N: Array
    measured: Array
    before: Array
    after: Array

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw torque over angle, measured, before and after, into axes or new ones of pyplot."""
        curves = {
            "measured": self.measured,
            "declared structure, refitted": self.before,
            "with the effects found": self.after,
        }
        return draw_loops(axes, self.psi, curves)


def _mean(figures: Mapping[str, float], names: tuple[str, ...]) -> float | None:
    return float(np.mean([figures[name] for name in names])) if names else None
