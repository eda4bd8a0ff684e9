"""The effects on a patch, by the hooks of `symbolic.Effect`, as Functions of scalars for generated C."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from observers.embedded.scalar_expansion import expand_with_constants
from observers.estimators.model_observer import ModelObserver
from symbolic import SIGNALS, Model
from symbolic.bristle_patch import BristlePatch
from symbolic.compilation.single_bristle_functions import bristle_patch_of
from symbolic.effects.base import Signals
from symbolic.elements_in_series import series_deflection
from symbolic.exact_zone_patch import ZonePatch
from symbolic.full_slide_friction import build_full_slide
from symbolic.model import add_effect_torques, effect_memory_torque, transform_sample_by_effects
from symbolic.named_and_buffered_functions import named_function
from symbolic.patch_interface import PatchInputs

TERMS = ("psi", "F_N", "speed", "base", "growth", "reach", "decay", "gain", "torque", "torque_by_psi",
         "slide", "beside")  # fmt: skip
"""Effects of a sample on all bristles alike, in the order of C."""


@dataclass(frozen=True, eq=False)
class PatchEffects:
    """The effects of an observer's model on its patch."""

    observer: ModelObserver  # The parameters of its model enter as numbers.

    @property
    def model(self) -> Model:
        """The observer's model."""
        return self.observer.model

    @cached_property
    def theta_at_unit_mu(self) -> ca.DM:
        """The parameters with mu = 1."""
        return self.model.theta({**self.observer.values, "mu": 1.0})

    @cached_property
    def numeric_patch(self) -> BristlePatch:
        """The patch with its traits as numbers."""
        return bristle_patch_of(self.model, self.theta_at_unit_mu)

    @property
    def memory_size(self) -> int:
        """Length of the effects' own memories."""
        return sum(effect.memory for effect in self.model.effects)

    def inputs_at_unit_mu(self, **changes: Any) -> PatchInputs:
        """Inputs of the patch for mu = 1, a load of 1 N and no speed, as numbers."""
        rig, k = self.observer.rig, self.observer.values["k"]
        usual = {"speed": 0.0, "dt": 1.0, "F_N": 1.0, "factor": 1.0, "mu": 1.0}
        return PatchInputs(**{**usual, "k": k, "a": rig.a, "e": rig.e, **changes})

    def sample_terms(self) -> ca.Function:
        """(signals, own) -> (terms, own_next): what the effects make of a sample."""
        model, rig = self.model, self.observer.rig
        signals, own = ca.MX.sym("signals", len(SIGNALS)), ca.MX.sym("own", self.memory_size)
        theta = ca.MX.sym("theta", self.theta_at_unit_mu.numel())
        memory = ca.vertcat(ca.MX.zeros(1 + model.patch().memory_size), own)
        at_patch, memories, factor = transform_sample_by_effects(
            model, model.split_angle_patch_effects(memory)[2], signals, theta
        )
        after = ca.vertcat(ca.MX.zeros(1 + model.patch().memory_size), *memories)
        torque = add_effect_torques(effect_memory_torque(memories, model, theta), model, at_patch, theta)
        growth, reach, decay, gain = self._bristle_coefficients(at_patch, factor, theta)
        geometry = ca.DM([rig.a, rig.e])
        # A patch that slides as the declared one.
        sliding = build_full_slide(model, ZonePatch().effective_friction)
        load = signals[SIGNALS.index("F_N")]
        slides = sliding(after, load, theta, geometry, rig.slide_rate)[0]
        zero_mu = theta * ca.DM([0] + [1] * (theta.numel() - 1))
        beside = sliding(after, load, zero_mu, geometry, rig.slide_rate)[0]
        named = {
            "psi": at_patch.psi, "F_N": at_patch.F_N, "speed": ca.fabs(at_patch.psi_dot) * rig.a,
            "base": factor * at_patch.F_N, "growth": growth, "reach": reach,
            "decay": decay, "gain": gain, "torque": torque,
            "torque_by_psi": ca.jacobian(torque, signals)[SIGNALS.index("psi")],
            "slide": slides - beside, "beside": beside,
        }  # fmt: skip
        terms = ca.densify(ca.vertcat(*(named[name] for name in TERMS)))
        outputs = {"terms": terms, "own_next": ca.vertcat(*memories)}
        return self._with_fixed_theta("sample_terms", outputs, signals=signals, own=own, theta=theta)

    def _bristle_coefficients(self, at_patch: Signals, factor: Any, theta: ca.MX) -> tuple[Any, ...]:
        """Growth of the patch, slip of a sample at 1 m/s, decay and gain of the Maxwell branches."""
        patch = self.model.patch(theta)
        if not isinstance(patch, BristlePatch):
            return 1, 0, 0, 0
        growth = patch.traits.relative_length(at_patch.F_N, self.observer.rig.a)
        inputs = self.inputs_at_unit_mu(
            speed=at_patch.psi_dot, dt=at_patch.dt, F_N=at_patch.F_N, factor=factor
        )
        n, coefficients = patch.bristle_count, patch.coefficients(inputs)
        return growth, coefficients[3 * n + 2], coefficients[3 * n], coefficients[3 * n + 1]

    def initial_memory(self) -> ca.Function:
        """(signals) -> (angle, own): the memory before the first sample."""
        initial = self.model.initial
        signals, theta = (
            ca.MX.sym("signals", len(SIGNALS)),
            ca.MX.sym("theta", self.theta_at_unit_mu.numel()),
        )
        memory = initial(signals, theta, ca.DM([self.observer.rig.a, self.observer.rig.e]))
        outputs = {"angle": memory[0], "own": memory[1 + self.model.patch().memory_size :]}
        return self._with_fixed_theta("initial_memory", outputs, signals=signals, theta=theta)

    def pressure(self) -> ca.Function:
        """(place, growth) -> limit over mu and load [1/N], of a patch that grows."""
        place, growth = ca.MX.sym("place"), ca.MX.sym("growth")
        scale = self.observer.values["k"] * self.observer.rig.a**2
        pressure = self.numeric_patch.traits.pressure(place, growth) / scale
        inputs = {"place": place, "growth": growth}
        return named_function("pressure_at", inputs, {"pressure": pressure}).expand()

    def build_friction_factor_by_speed(self) -> ca.Function:
        """(speed) -> factor on the limit of a bristle that the wheel drives at this speed [m/s]."""
        speed, factor = ca.MX.sym("speed"), ca.MX(1)
        for limit in self.numeric_patch.traits.limits:
            factor = factor * limit(speed)
        return named_function("limit_factor", {"speed": speed}, {"factor": factor}).expand()

    def build_series_deflection(self) -> ca.Function | None:
        """(M_z, F_N) -> (turn, by_torque): elements in series with the patch; None for none."""
        deflection = series_deflection(self.model)
        if deflection is None:
            return None
        M_z, F_N, theta = (
            ca.MX.sym("M_z"),
            ca.MX.sym("F_N"),
            ca.MX.sym("theta", self.theta_at_unit_mu.numel()),
        )
        turn = deflection(M_z, ca.vertcat(F_N, theta))
        outputs = {"turn": turn, "by_torque": ca.densify(ca.jacobian(turn, M_z))}
        return self._with_fixed_theta("deflection", outputs, M_z=M_z, F_N=F_N, theta=theta)

    def _with_fixed_theta(self, name: str, outputs: dict[str, ca.MX], **inputs: ca.MX) -> ca.Function:
        """A Function of symbols by their names, of which theta becomes numbers."""
        function = named_function(name, inputs, outputs)
        return expand_with_constants(
            name, function, {"theta": np.asarray(self.theta_at_unit_mu).ravel()}
        )
