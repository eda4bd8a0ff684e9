"""The result of a diagnosis: frozen values, and the content of `diagnosis.json`."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from identification.diagnosis.found_vs_declared_stiffness import StiffnessComparison
from identification.diagnosis.result_parts import (
    Candidate,
    FoundEffect,
    FoundFamily,
    Series,
    TorqueErrors,
)
from identification.fits.values_by_ground_and_recording import ParameterEstimate, Values
from identification.loop_plot import matplotlib_text
from identification.residuals.full_slide_repeatability import Repeatability
from identification.residuals.partial_correlations import Signatures
from identification.residuals.residual_structure import Unexplained
from identification.selection.criteria import DEFAULT_CRITERIA, SelectionCriteria
from symbolic import Model, ModelBasis, ModelError
from symbolic.tables.notebook_html import html_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

USUAL_LOADS = (0.05, 0.95)
"""Shares of a recording's samples between which its load is usual [1]."""
_ERRORS = {
    "training": "torque_nrmse",
    "held out": "holdout_torque_nrmse",
    "left out in turn": "left_out_torque_nrmse",
}


@dataclass(frozen=True, kw_only=True, eq=False)
class Diagnosis:
    """The whole result of `diagnose`.

    Attributes:
        recordings: names of the training recordings.
        holdout: names of the held-out recordings.
        declared: errors with nominal parameters as given (mu fitted where none is declared).
        before: errors of the declared structure, no effect at all, refitted.
        after: errors with the effects, refitted.
        effects: what was found, in order of selection; empty if nothing is missing.
        candidates: every candidate's first step, best first.
        unexplained: whether the final residual has structure.
        parameters: every parameter of the final model; own ones as "mu [fem1]".
        signatures_before: signals that the residual of the declared structure follows.
        signatures_after: signals that the final residual follows.
        model: the final model.
        values: its values.
        series: every recording with its curves.
        families: mechanisms that these effects are laws of, with curves.
        notes: sentences for the report, such as recordings that got worse.
        criteria: thresholds of the search.
        model_error_before: how wrong the declared structure is on recordings that no shared parameter
            was fitted to, held out or left out in turn; None where there is no such recording.
        model_error: the same of the final model.
        of_car: whether the recordings are of cars, whose mean wheels these are.
        inclination: of a car's kingpins, where a clear return torque asks for another than the declared
            one [rad]; else None.
        stiffness_ratio: k over the declared one where that is farthest off [1]; 1 within tolerance.
        stiffness: k beside the declared one; None where nobody says.
        repeatability: how well recordings of one ground and load repeat; None without replicates.
        without_stand_ins: the model of all effects but the stand-ins, and its values; None without
            stand-ins, or where the search had no such model.
    """

    recordings: tuple[str, ...]
    holdout: tuple[str, ...]
    declared: TorqueErrors
    before: TorqueErrors
    after: TorqueErrors
    effects: tuple[FoundEffect, ...]
    candidates: tuple[Candidate, ...]
    unexplained: Unexplained
    parameters: Mapping[str, ParameterEstimate]
    signatures_before: Signatures
    signatures_after: Signatures
    model: Model
    values: Values
    series: tuple[Series, ...]
    families: tuple[FoundFamily, ...] = ()
    notes: tuple[str, ...] = ()
    criteria: SelectionCriteria = DEFAULT_CRITERIA
    model_error_before: ModelError | None = None
    model_error: ModelError | None = None
    of_car: bool = False
    inclination: float | None = None
    stiffness_ratio: float = 1.0
    stiffness: StiffnessComparison | None = None
    repeatability: Repeatability | None = None
    without_stand_ins: tuple[Model, Values] | None = None

    def __repr__(self) -> str:
        """One line: the recordings, and the effects that were found."""
        names = ", ".join(effect.name for effect in self.effects) or "no effect"
        return f"<Diagnosis of {len(self.recordings)} recordings, {len(self.holdout)} held out: {names}>"

    def _repr_html_(self) -> str:
        """The same as a table: errors before and after, every effect with its figures and grade."""
        before, after = self.before.summary(), self.after.summary()
        errors = [
            (f"torque error, {what}", f"{100 * old:.2f} % → {100 * new:.2f} % of range")
            for what, key in _ERRORS.items()
            if (old := before[key]) is not None and (new := after[key]) is not None
        ]
        effects = [(effect.name, _effect_parameters_text(effect)) for effect in self.effects]
        left = self.unexplained.evidence if self.unexplained.present else "nothing found"
        count = f"{len(self.recordings)} recordings, {len(self.holdout)} held out"
        rows = [*errors, *(effects or [("effects", "none is missing")]), ("unexplained", left)]
        return html_table(f"Diagnosis of {count}", rows)

    @property
    def basis(self) -> ModelBasis:
        """Basis of the final model; loads are of wheels on the ground, without rare ones."""
        loads = [one.F_N[one.F_N > 0] for one in self.series]
        ranges = np.array([np.quantile(own, USUAL_LOADS) for own in loads if own.size])
        return ModelBasis(
            training=len(self.recordings),
            holdout=len(self.holdout),
            grades={effect.name: effect.grade for effect in self.effects},
            unexplained=self.unexplained.present,
            loads=(float(ranges.min()), float(ranges.max())) if ranges.size else None,
        )

    @property
    def median_error_series(self) -> Series:
        """The recording of median final error among the held-out, else of all."""
        held_out = [series for series in self.series if series.held_out]
        ranked = sorted(held_out or self.series, key=lambda series: self.after.nrmse[series.name])
        return ranked[(len(ranked) - 1) // 2]

    def plot(self, axes: "Axes | None" = None) -> "Axes":
        """Draw the representative recording into axes of matplotlib, or new ones of pyplot.

        Torque over angle, measured, before and after; each of `series` has a `plot` of its own.
        """
        shown = self.median_error_series
        axes = shown.plot(axes)
        old, new = self.before.nrmse[shown.name], self.after.nrmse[shown.name]
        role = "held out" if shown.held_out else "training"
        error = f"error {100 * old:.2f} % → {100 * new:.2f} % of range"
        axes.set_title(f"{matplotlib_text(shown.name)} ({role}), {error}")
        return axes

    def to_dict(self) -> dict[str, Any]:
        """The content of `diagnosis.json`."""
        stages = {"declared": self.declared, "before": self.before, "after": self.after}
        error, before = self.model_error, self.model_error_before
        return {
            "recordings": list(self.recordings),
            "holdout": list(self.holdout),
            **{stage: errors.summary() for stage, errors in stages.items()},
            "per_recording": {stage: errors.by_recording() for stage, errors in stages.items()},
            "residual": {
                "before": self.signatures_before.to_dict(),
                "after": self.signatures_after.to_dict(),
            },
            "effects": [effect.to_dict() for effect in self.effects],
            "families": [family.to_dict() for family in self.families],
            "candidates": [
                {name: value for name, value in asdict(c).items() if name != "summary"}
                for c in self.candidates
            ],
            "unexplained": asdict(self.unexplained),
            "parameters": {name: asdict(estimate) for name, estimate in self.parameters.items()},
            "model_error": error and asdict(error) | {"before": before and asdict(before)},
            "repeatability": self.repeatability and asdict(self.repeatability),
            "notes": list(self.notes),
        }


def _effect_parameters_text(effect: FoundEffect) -> str:
    """Parameters of an effect with their deviations, and its grade."""
    values = [
        f"{name} = {p.value:.4g}" + (f" ± {p.std:.2g}" if p.std else "") + (p.unit != "1") * f" {p.unit}"
        for name, p in effect.parameters.items()
    ]
    rivals = f", or {', '.join(effect.indistinguishable_from)}" * bool(effect.indistinguishable_from)
    return f"{', '.join(values)}; {effect.grade.replace('_', ' ')}{rivals}"
