"""Base class of observers that are made of two casadi Functions; a user's own is one subclass."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from observers.compiled_step import (
    CompiledStep,
    compiled_step,
    compiled_stretch,
    first_sample,
    run_stretches,
)
from observers.layout import Expression, Layout, ObserverState, outputs_of
from observers.measurement.measurement_model import MIN_FIRST_LOAD
from observers.patch.patch_protocol import build_effective_friction, output_vector
from observers.protocol import ESTIMATE, OUTPUT, UNINFORMED, Estimate, Sample, Status, prior_estimate
from observers.quality.sample_screening import (
    SCREEN,
    build_screened_step,
    initial_screen_state,
    is_plausible_first_sample,
)
from observers.quality.wrong_units_or_signs import EVIDENCE, START
from observers.tuning import INFORMED, Tuning
from symbolic import DECLARED, GEOMETRY, InvalidInputError, Model, Rig
from symbolic.effects.asymmetric_friction import weaker_share_below_mean
from symbolic.float_array_type import Array
from symbolic.tables.found_model import units_of

_AT_REST = Sample(psi=0.0, psi_dot=0.0, F_N=1000.0, dt=0.01, M_z=0.0, M=0.0)
"""A wheel that stands, whatever is measured."""


@dataclass(frozen=True, kw_only=True)
class CasadiObserver:
    """A model with its parameters; a subclass defines `layout`, `initial_function` and `step_function`.

    The state is one vector with named parts, see `Layout`; its part `output` is in the order of
    `OUTPUT`, and `output()` makes one. Both Functions take `constants`, which begin with theta and the
    geometry as those of `Model.step` do.

    Attributes:
        model: the model, with the effects that a diagnosis found if there are any.
        values: every parameter of the model but mu, by name (`k`, `effect.parameter`).
        rig: geometry; J_A and b_t too where the steering torque is measured.
    """

    model: Model
    values: Mapping[str, float]
    rig: Rig

    @property
    def name(self) -> str:
        """Name for files and reports."""
        return type(self).__name__.lower()

    @property
    def title(self) -> str:
        """One line about the observer."""
        torque = "steering" if self.channel == "M" else "aligning"
        effects = ", ".join(effect.name for effect in self.model.effects)
        model = f"effects {effects}" if effects else "the declared model"
        return f"{self.kind} on the {torque} torque, {model}"

    @property
    def kind(self) -> str:
        """Kind of the estimator, for its title."""
        return type(self).__name__

    @property
    def channel(self) -> str:
        """The torque that is used: `M_z`, the aligning torque, or `M`, the steering torque."""
        return "M" if "M" in self.channels else "M_z"

    @property
    def prior(self) -> Estimate:
        """The estimate before any sample."""
        return prior_estimate(self)

    @property
    def channels(self) -> tuple[str, ...]:
        """Fields of `Sample` that are used."""
        return ("psi", "psi_dot", "F_N", "M_z")

    @property
    def informed_below(self) -> float:
        """Relative standard deviation of mu below which an estimate is informed [1]."""
        return INFORMED

    @property
    def weaker(self) -> float:
        """Share of mu_eff and M_slide that the weaker direction holds less [1]; 0 if they are alike.

        By an `asymmetric_friction` of the model; effects of the user's own do not count.
        """
        return weaker_share_below_mean(self.values)

    @property
    def sample_limits(self) -> tuple[float, ...]:
        """Limits of what a sensor may give, in the order of `observers.tuning.PLAUSIBLE`."""
        return Tuning().sensor_limits

    @property
    def has_unit_and_sign_check(self) -> bool:
        """Whether units and signs of samples are checked, see `quality.wrong_units_or_signs`."""
        return True

    @cached_property
    def screened_step(self) -> ca.Function:
        """`step_function` of plausible samples alone, see `observers.quality.sample_screening`."""
        # Half-length and caster follow the parameters of the model.
        a_at = len(self.model.parameters) if self.has_unit_and_sign_check else None
        limits = self._sample_limits_index or self.sample_limits
        return build_screened_step(self.step_function, self.layout, limits, self.channel, a_at)

    @property
    def _sample_limits_index(self) -> int | None:
        """Index of the first of the limits among the constants; None where they are not among them."""
        return None

    @property
    def layout(self) -> Layout:
        """The parts of a state, which those of the check of samples follow."""
        raise NotImplementedError

    @property
    def initial_function(self) -> ca.Function:
        """(sample, constants) -> state: the state before a first sample with valid psi and F_N.

        sample (6,) is in the order of `observers.SAMPLE`, constants as in `constants`.
        """
        raise NotImplementedError

    @property
    def step_function(self) -> ca.Function:
        """(state, sample, constants) -> (state_next, output), in the order of these arguments."""
        raise NotImplementedError

    def output(
        self, memory: Expression | None = None, F_N: Expression | None = None, **known: Any
    ) -> ca.MX:
        """An output in the order of `OUTPUT`: what is known, and the effective friction that follows.

        Args:
            memory: of the model after the sample, (m,); None where there is no sample yet.
            F_N: load at the sample, greater than 0 [N]; None there too.
            known: mu, mu_std and, as far as they are known, M_z_predicted, nis and status.
        """
        if memory is None:
            return output_vector(**known)
        slide, tyre = build_effective_friction(self.model), (self._theta, self._geometry)
        given = (known["mu"], known["mu_std"], memory, F_N, *tyre, self.rig.slide_rate)
        return output_vector(**outputs_of(slide, *given), **known)

    @cached_property
    def constants(self) -> Array:
        """Theta at the start value of mu, and the geometry."""
        return np.concatenate([self._theta.full().ravel(), self._geometry])

    @property
    def constant_labels(self) -> tuple[str, ...]:
        """Name and unit of every constant."""
        return (*self._theta_labels, *(f"{name} [m]" for name in GEOMETRY))

    @property
    def settings(self) -> Mapping[str, Any]:
        """The fields of a subclass."""
        own = {field.name for field in fields(CasadiObserver)}
        return {f.name: getattr(self, f.name) for f in fields(self) if f.name not in own}

    def prepare(self) -> None:
        """Build and compile now what the first sample would, so that a control loop waits for nothing.

        A cache keeps what is compiled, in `BRUSHGRIP_CACHE` or the user's cache folder, so that it takes
        seconds once and little more than a moment afterwards.
        """
        state = self.init(_AT_REST)
        self.estimate(self.step(state, _AT_REST))

    def init(self, first: Sample) -> ObserverState:
        """The state before the first sample, at whose angle the patch is at rest.

        Raises:
            InvalidInputError: psi is not finite or F_N is less than 0.001 N.
        """
        if not is_plausible_first_sample(self, first.psi, first.F_N):
            raise InvalidInputError(
                f"the first sample must have a finite psi and F_N >= {MIN_FIRST_LOAD:g} N, both within"
                f" the limits of the tuning, as they say where the patch stands; got psi = {first.psi}"
                f" rad, F_N = {first.F_N} N; wait for one that has"
            )
        state = self.initial_function(np.array(first.numbers), self.constants).full().ravel()
        checks = (initial_screen_state(first.psi), START[: len(START) * self.has_unit_and_sign_check])
        return ObserverState(np.concatenate([state, *checks]), self._checked_layout)

    def step(self, state: ObserverState, sample: Sample) -> ObserverState:
        """The state after one more sample; the state given is not changed.

        Raises:
            InvalidInputError: the state is that of another observer, or NaN.
        """
        return ObserverState(self._step(self._checked_state_values(state), sample), self._checked_layout)

    def estimate(self, state: ObserverState) -> Estimate:
        """The estimate of a state; errors as of `step`."""
        output = self._checked_state_values(state)[self._checked_layout.places["output"][0]]
        mu, std, predicted, mu_eff, mu_eff_std, M_slide, nis, status = output.tolist()
        if mu != mu or status != status:
            raise InvalidInputError("state has NaN in its output; begin anew with init")
        return Estimate(
            mu=mu, mu_std=std, M_z_predicted=predicted,
            informed=std < self.informed_below * mu and not int(status) & UNINFORMED,
            mu_eff=mu_eff, mu_eff_std=mu_eff_std, M_slide=M_slide, nis=nis, status=Status(int(status)),
        )  # fmt: skip

    def run_samples(self, samples: Array) -> Array:
        """A whole recording; see `BatchObserver.run_samples`."""
        start = self.init(first_sample(samples)).values
        rows = run_stretches(compiled_stretch(self.screened_step), start, samples, self.constants)
        output = dict(zip(OUTPUT, rows, strict=True))
        flags = np.nan_to_num(output["status"]).astype(int)
        known = output["mu_std"] < self.informed_below * output["mu"]
        output["informed"] = known & (flags & UNINFORMED == 0)
        output["usable"] = output["informed"] & (output["status"] == 0)
        return np.vstack([output[name] for name in ESTIMATE])

    @property
    def _theta(self) -> ca.DM:
        return self.model.theta({**self.values, "mu": DECLARED[0].start})

    @property
    def _geometry(self) -> Array:
        return np.array([getattr(self.rig, name) for name in GEOMETRY])

    @property
    def _theta_labels(self) -> tuple[str, ...]:
        units = units_of(self.model)
        names = [
            c if c in units else f"{c}, as the model counts it" for c in self.model.coordinate_names
        ]
        return tuple(f"{name} [{unit}]" for name, unit in zip(names, units.values(), strict=True))

    @cached_property
    def _checked_layout(self) -> Layout:
        checks = {"screen": SCREEN.size} | (
            {"evidence": EVIDENCE.size} if self.has_unit_and_sign_check else {}
        )
        return Layout.of(*self.layout.fields, **checks)

    def _checked_state_values(self, state: ObserverState) -> Array:
        """The numbers of a state, where it is one of this observer."""
        if not isinstance(state, ObserverState):
            raise InvalidInputError(
                f"state must be what init or step returned, got {type(state).__name__}"
            )
        values, parts = state.values, self._checked_layout
        if (state.layout is not parts and state.layout != parts) or values.shape != (parts.size,):
            raise InvalidInputError(
                f"state has {values.size} numbers, this observer's has {parts.size}, or others;"
                " it belongs to another observer"
            )
        for at in self._nan_free_slices:
            # The quickest test for a NaN.
            if not values[at].dot(values[at]) >= 0:
                raise InvalidInputError("state has NaN; begin anew with init")
        return values

    @cached_property
    def _nan_free_slices(self) -> list[slice]:
        """Slices of the state that must not hold NaN; adjacent ones are merged."""
        filled: list[slice] = []
        places = self._checked_layout.places
        for at in (places[name][0] for name in ("memory", "x", "factor") if name in places):
            joins = bool(filled) and filled[-1].stop == at.start
            filled.append(slice(filled.pop().start if joins else at.start, at.stop))
        return filled

    @cached_property
    def _step(self) -> CompiledStep:
        return CompiledStep(compiled_step(self.screened_step), self.constants)

    def __getstate__(self) -> dict[str, Any]:
        """The fields; cached properties are computed again."""
        return {field.name: getattr(self, field.name) for field in fields(self)}
