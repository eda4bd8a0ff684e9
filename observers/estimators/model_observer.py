"""Settings and expressions that the extended Kalman filter and the moving-horizon estimator share."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from observers.estimators.casadi_observer import CasadiObserver
from observers.estimators.initial_state import build_initial_state
from observers.layout import Layout
from observers.measurement.directional_friction import OTHER, DirectionalFriction
from observers.measurement.measurement_model import RIG, AligningTorque, MeasurementModel
from observers.patch.patch_protocol import EQUIVALENT
from observers.quality.acquisition import DECLARED_PATCH, EquivalentPatch
from observers.quality.acquisition_and_tracking import build_step_with_acquisition, supervision_layout
from observers.quality.equivalent_patch import equivalent_patch
from observers.tuning import (
    PLAUSIBLE,
    TUNING_FIELDS,
    Tuning,
    require_positive_ints,
    tuning_with_tolerances,
)
from symbolic import InvalidInputError, Model, Rig
from symbolic.effects.asymmetric_friction import ASYMMETRY_RATIO
from symbolic.effects.base import parameter_name
from symbolic.elements_in_series import series_deflection
from symbolic.float_array_type import Array

RIG_UNITS = ("m", "m", "kg m^2", "N m s/rad", "rad/s", "N m", "N m", "N m")


@dataclass(frozen=True, kw_only=True)
class ModelObserver(CasadiObserver):
    """A model, its fixed parameters, the rig, what is measured, and the tuning.

    Attributes:
        model, values, rig: as of `CasadiObserver`. The model is taken on bristles where something stands
            in series with the patch: the corners of the exact patch then depend on mu, and their
            derivative by mu is useless after a reversal.
        tuning: prior and noises.
        measurement_model: which torque is measured, and which states there are beside mu.
        acquire: friction is acquired among hypotheses before the estimator tracks it, and inputs are
            checked for other units, signs and scales, see `observers.quality.acquisition_and_tracking`.
            False is the estimator alone, from its prior: where another part of a system does all that.
            Friction by direction is not acquired, but its inputs are checked; it takes the place of the
            ratio of an `asymmetric_friction`.

    Raises:
        InvalidInputError: a parameter is missing or out of bounds, or the rig lacks one.
    """

    tuning: Tuning = field(default_factory=Tuning)
    measurement_model: MeasurementModel = field(default_factory=AligningTorque)
    acquire: bool = True

    def __post_init__(self) -> None:
        """Check the parameters, the rig, and that they go together."""
        for name, kind in (("model", Model), ("rig", Rig), ("tuning", Tuning)):
            if not isinstance(getattr(self, name), kind):
                raise InvalidInputError(
                    f"{name} must be a {kind.__name__}, got {type(getattr(self, name)).__name__}"
                )
        if isinstance(self.measurement_model, type) or not hasattr(self.measurement_model, "motion"):
            raise InvalidInputError(
                "measurement_model must be AligningTorque(...), SteeringTorque(...) or another"
                f" observers.MeasurementModel, with brackets, got {self.measurement_model!r}"
            )
        if self._has_directional_friction:
            object.__setattr__(self, "acquire", False)
            self._neutralise_asymmetry()
        if self.model.uses_exact_patch and (
            self._has_directional_friction or series_deflection(self.model) is not None
        ):
            object.__setattr__(self, "model", replace(self.model, discretised=True))
        self.model.theta({**self.values, "mu": self.tuning.mu})
        for effect, p in self.model.parameters:
            if effect is None or not effect.adds_torque_from_memory or p.neutral is None:
                continue
            if self.values[name := parameter_name(effect, p)] != p.neutral:
                raise InvalidInputError(
                    f"{name} must be {p.neutral:g}, as an observer estimates the torque's zero itself,"
                    f" got {self.values[name]:g}; leave {effect.name} out of the model"
                )
        self.measurement_model.check(self.rig, self.model)
        require_positive_ints(
            window=getattr(self, "window", 1), iterations=getattr(self, "iterations", 1)
        )

    def _neutralise_asymmetry(self) -> None:
        """Friction by direction replaces that of the model, and changes where the model's did."""
        model = self.measurement_model
        if isinstance(model, DirectionalFriction) and ASYMMETRY_RATIO in self.values:
            object.__setattr__(self, "measurement_model", replace(model, at_reversal=True))
            object.__setattr__(self, "values", {**self.values, ASYMMETRY_RATIO: 1.0})

    @property
    def _has_directional_friction(self) -> bool:
        return OTHER in self.measurement_model.states

    @property
    def has_unit_and_sign_check(self) -> bool:
        """Whether samples are checked for other units and signs: not where the estimator is alone."""
        return self.acquire or self._has_directional_friction

    @property
    def estimator_layout(self) -> Layout:
        """The parts of a state, less those of the supervision."""
        raise NotImplementedError

    @property
    def estimator_step(self) -> ca.Function:
        """One sample, (state, sample, constants) -> (state_next, output), without the supervision."""
        raise NotImplementedError

    @property
    def layout(self) -> Layout:
        """The parts of a state; those of the supervision follow the estimator's."""
        parts = self.estimator_layout
        if not self.acquire:
            return parts
        return Layout.of(*parts.fields, *supervision_layout(self.measurement_model).fields)

    @property
    def step_function(self) -> ca.Function:
        """One sample; see `CasadiObserver.step_function`."""
        if not self.acquire:
            return self.estimator_step
        # Its numbers are among the constants: one Function serves all rigs and values.
        patch = replace(self.equivalent_patch, **dict.fromkeys(EQUIVALENT, 1.0))
        return build_step_with_acquisition(
            self.estimator_step, self.model, self.measurement_model, self.estimator_layout, patch
        )

    @property
    def equivalent_patch(self) -> EquivalentPatch:
        """The declared patch that stands for the model while friction is acquired."""
        if not self.acquire:
            return DECLARED_PATCH
        return equivalent_patch(self.model, self.values, self.rig)

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states, in the order of `state["x"]`."""
        return self.measurement_model.states

    @property
    def channels(self) -> tuple[str, ...]:
        """Fields of `Sample` that are used."""
        return self.measurement_model.channels

    @property
    def informed_below(self) -> float:
        """Relative standard deviation of mu below which an estimate is informed [1]."""
        return self.tuning.informed_below

    @property
    def weaker(self) -> float:
        """Share that the weaker direction holds less [1]; refused where each has friction of its own."""
        if self._has_directional_friction:
            raise InvalidInputError(
                "no one share: friction has a state for each direction, and mu_eff is that of the one"
                " that loads the patch"
            )
        return super().weaker

    @property
    def sample_limits(self) -> tuple[float, ...]:
        """Limits of what a sensor may give, in the order of `observers.tuning.PLAUSIBLE`."""
        return self.effective_tuning.sensor_limits

    @property
    def _sample_limits_index(self) -> int:
        return len(self.model.parameters) + len(RIG) + TUNING_FIELDS.index(PLAUSIBLE[0])

    @property
    def initial_function(self) -> ca.Function:
        """The state before the first sample; see `CasadiObserver.initial_function`."""
        return build_initial_state(self.model, self.measurement_model, self.layout)

    @property
    def effective_tuning(self) -> Tuning:
        """The tuning with what tolerances add to it, see `observers.tuning`."""
        return tuning_with_tolerances(self.tuning, self.rig, self.values["k"])

    @cached_property
    def constants(self) -> Array:
        """Theta at the prior's mu, the rig, the tuning, and numbers of the equivalent patch."""
        theta = self.model.theta({**self.values, "mu": self.tuning.mu})
        rig = [float("nan") if (v := getattr(self.rig, name)) is None else v for name in RIG]
        patch = [getattr(self.equivalent_patch, name) for name in EQUIVALENT]
        return np.concatenate([theta.full().ravel(), rig, self.effective_tuning.vector, patch])

    @property
    def constant_labels(self) -> tuple[str, ...]:
        """Name and unit of every constant."""
        rig = (f"{name} [{unit}]" for name, unit in zip(RIG, RIG_UNITS, strict=True))
        patch = (f"equivalent patch: {name} [1]" for name in EQUIVALENT)
        return (*self._theta_labels, *rig, *(f"tuning: {name}" for name in TUNING_FIELDS), *patch)

    @property
    def settings(self) -> Mapping[str, Any]:
        """Measurement model, states, acquisition, tuning and, as `settings`, what the observer adds."""
        own = set(ModelObserver.__dataclass_fields__)
        return {
            "sensing": type(self.measurement_model).__name__,
            "states": list(self.states),
            "acquire": self.acquire,
            "beliefs": asdict(self.tuning),
            "settings": {n: getattr(self, n) for n in self.__dataclass_fields__ if n not in own},
        }
