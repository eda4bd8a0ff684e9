"""The model: a patch and any number of effects, composed into casadi Functions.

`Model().step` is the model of [Györök 2022], section 2.2. `Model(effects=...)` extends it; the hooks of
an effect decide where it enters, and nothing here names any of them.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property

import casadi as ca

from symbolic.bristle_patch import BristlePatch, BristleTraits
from symbolic.effects.base import Effect, Parameter, parameter_name, with_scope
from symbolic.elements_in_series import SEARCH_STEPS, advance_in_series, series_deflection
from symbolic.errors import InvalidInputError
from symbolic.exact_zone_patch import ZonePatch
from symbolic.full_slide_friction import build_full_slide
from symbolic.named_and_buffered_functions import named_function
from symbolic.patch_interface import Expression, Patch, Signals, patch_inputs
from symbolic.rig_and_tyre import FRICTION, STIFFNESS

SIGNALS = ("psi", "psi_dot", "F_N", "dt")
"""Order of one sample's inputs: [rad], [rad/s], [N], [s]."""
MIN_PERIOD = 1e-9
"""Shorter sample periods are clamped to this [s]: patch and effects divide by the period."""
GEOMETRY = ("a", "e")
"""Order of the geometry: contact patch half-length [m], caster length [m]."""
DECLARED = (
    Parameter(
        name="mu", unit="1", neutral=None, start=1.0, lower=FRICTION[0], upper=FRICTION[1], scale=0.5,
        scope="recording",
    ),
    Parameter(
        name="k", unit="N/m^2", neutral=None, start=2e6, lower=STIFFNESS[0], upper=STIFFNESS[1],
        scale=1e6, of="stiffness",
    ),
)  # fmt: skip
"""The parameters of the declared model."""


@dataclass(frozen=True, kw_only=True)
class Model:
    """A contact patch with effects; a value, from which Functions are built on demand.

    Attributes:
        effects: the effects, in order.
        corners: capacity of the exact patch, see `ZonePatch`.
        bristles: over the length of the discretised patch, see `BristlePatch.columns`.
        discretised: True asks for bristles even where the exact patch would do.
        search_steps: Newton steps towards the balance with what is in series with the patch.
    """

    effects: tuple[Effect, ...] = ()
    corners: int = 32
    bristles: int = 80
    discretised: bool = False
    search_steps: int = SEARCH_STEPS

    @cached_property
    def coordinate_names(self) -> tuple[str, ...]:
        """Names of the parameter vector theta: mu, k, then effect.parameter."""
        return tuple(
            f"{effect.name}.{p.coordinate_name}" if effect else p.coordinate_name
            for effect, p in self.parameters
        )

    @cached_property
    def parameters(self) -> tuple[tuple[Effect | None, Parameter], ...]:
        """Every parameter with its effect, None for the declared model's own, in the order of theta."""
        declared = [(None, parameter) for parameter in DECLARED]
        added = [(effect, p) for effect in self.effects for p in effect.parameters]
        return tuple((effect, with_scope(p, self.effects)) for effect, p in (*declared, *added))

    def theta(self, values: Mapping[str, float]) -> ca.DM:
        """The parameter vector of physical values, see `coordinate_values`."""
        return ca.DM(self.coordinate_values(values))

    def coordinate_values(self, values: Mapping[str, float]) -> list[float]:
        """Values of `coordinate_names` of physical values named `mu`, `k`, `effect.parameter`.

        Raises:
            InvalidInputError: a parameter is missing, unknown or out of bounds.
        """
        names = [parameter_name(effect, parameter) for effect, parameter in self.parameters]
        if unknown := sorted(set(values) - set(names)):
            raise InvalidInputError(
                f"unknown parameter {unknown[0]!r}; the model has {', '.join(names)}"
            )
        vector = []
        for name, (_, parameter) in zip(names, self.parameters, strict=True):
            if name not in values:
                raise InvalidInputError(f"parameter {name!r} is missing")
            parameter.require_within(values[name], f"parameter {name}")
            vector.append(parameter.to_coordinate(values[name]))
        return vector

    @property
    def uses_exact_patch(self) -> bool:
        """Whether the patch is the exact one: no effect breaks the parabola."""
        return not (self.discretised or any(effect.needs_bristles for effect in self.effects))

    def patch(self, theta: Expression | None = None) -> Patch:
        """The exact patch, or bristles with the traits that the effects give them.

        Args:
            theta: the parameter vector, casadi; None where only sizes matter.
        """
        if self.uses_exact_patch:
            return ZonePatch(corners=self.corners)
        traits = BristleTraits()
        for effect, values in self.values_by_effect(self.input_symbols()[1] if theta is None else theta):
            traits = effect.traits(traits, values)
        return BristlePatch(traits=traits, columns=self.bristles)

    @property
    def memory_size(self) -> int:
        """Length of the memory: the patch angle, the patch, then each effect's own."""
        return 1 + self.patch().memory_size + sum(effect.memory for effect in self.effects)

    @property
    def initial(self) -> ca.Function:
        """(signals of the first sample, theta, geometry) -> memory before it; named inputs."""
        return _build_initial(self)

    @property
    def step(self) -> ca.Function:
        """(memory, signals, theta, geometry) -> (memory_next, M_z); named inputs and outputs.

        signals as in `SIGNALS`, theta as in `coordinate_names`, geometry as in `GEOMETRY`; M_z is the
        moment of the ground on the wheel [N m], negative for a positive turn from rest.
        """
        return _build_step(self)

    @property
    def advance(self) -> ca.Function:
        """The first half of `step`: (memory, signals, theta, geometry) -> (memory_next, patch_signals).

        patch_signals are those that reach the patch: another angle, rate or load where an effect sits in
        a sensor, and dt at least `MIN_PERIOD`.
        """
        return _build_advance(self)

    @property
    def torque(self) -> ca.Function:
        """The second half of `step`: (memory_next, patch_signals, theta, geometry) -> M_z."""
        return _build_torque(self)

    @property
    def full_slide(self) -> ca.Function:
        """(memory, F_N, theta, geometry, rate) -> (mu_eff, M_slide), by `full_slide_friction`."""
        return build_full_slide(self)

    def memory_depends_on(self, coordinate: str) -> bool:
        """Whether the memory depends on that parameter, so that another value is another history.

        The declared model's memory depends on neither mu nor k (`symbolic.exact_zone_patch`).
        """
        i = self.coordinate_names.index(coordinate)
        depends = (self.step.jac_sparsity(0, 2), self.initial.jac_sparsity(0, 1))
        return any(s.colind()[i + 1] > s.colind()[i] for s in depends)

    def input_symbols(self) -> tuple[ca.MX, ca.MX, ca.MX]:
        """Fresh symbols for signals (4,), theta (p,) and geometry (2,)."""
        theta, geometry = ca.MX.sym("theta", len(self.parameters)), ca.MX.sym("geometry", len(GEOMETRY))
        return ca.MX.sym("signals", len(SIGNALS)), theta, geometry

    def values_by_effect(self, theta: Expression) -> list[tuple[Effect, dict[str, Expression]]]:
        """Each effect with its own part of theta, by coordinate name."""
        split, at = [], len(DECLARED)
        for effect in self.effects:
            values = {p.coordinate_name: theta[i] for i, p in enumerate(effect.parameters, start=at)}
            split.append((effect, values))
            at += len(effect.parameters)
        return split

    def split_angle_patch_effects(
        self, memory: Expression
    ) -> tuple[Expression, Expression, list[Expression]]:
        """Patch angle, patch memory, and each effect's own memory."""
        own = 1 + self.patch().memory_size
        return memory[0], memory[1:own], self.split_effect_memories(memory, own)

    def split_effect_memories(self, memory: Expression, at: int = 0) -> list[Expression]:
        """Each effect's own memory, the first one's from an index on."""
        parts = []
        for effect in self.effects:
            parts.append(memory[at : at + effect.memory])
            at += effect.memory
        return parts


def _step_input_symbols(model: Model) -> dict[str, ca.MX]:
    signals, theta, geometry = model.input_symbols()
    memory = ca.MX.sym("memory", model.memory_size)
    return {"memory": memory, "signals": signals, "theta": theta, "geometry": geometry}


@cache
def _build_initial(model: Model) -> ca.Function:
    signals, theta, geometry = model.input_symbols()
    first = _signals_from_vector(signals)
    angle = first.psi
    for effect, values in model.values_by_effect(theta):
        angle = angle - effect.initial_angle(values)
    memory = [angle, ca.MX(ca.DM(model.patch().virgin_memory()))]
    memory += [effect.initial(first) for effect in model.effects if effect.memory]
    inputs = {"signals": signals, "theta": theta, "geometry": geometry}
    return named_function("initial", inputs, {"memory": ca.vertcat(*memory)})


@cache
def _build_step(model: Model) -> ca.Function:
    inputs = _step_input_symbols(model)
    after, patch_signals, coefficients = _advance_memory(model, **inputs)
    M_z = _torque(model, after, patch_signals, coefficients, inputs["theta"])
    return named_function("step", inputs, {"memory_next": after, "M_z": M_z}, cse=True)


@cache
def _build_advance(model: Model) -> ca.Function:
    inputs = _step_input_symbols(model)
    after, patch_signals, _ = _advance_memory(model, **inputs)
    column = ca.vertcat(*(getattr(patch_signals, name) for name in SIGNALS))
    return named_function("advance", inputs, {"memory_next": after, "patch_signals": column}, cse=True)


@cache
def _build_torque(model: Model) -> ca.Function:
    memory, signals, theta, geometry = _step_input_symbols(model).values()
    patch_signals = _signals_from_vector(signals)
    driven = patch_inputs(patch_signals, ca.MX(1), theta, geometry)
    M_z = _torque(model, memory, patch_signals, model.patch(theta).coefficients(driven), theta)
    inputs = {"memory": memory, "patch_signals": signals, "theta": theta, "geometry": geometry}
    return named_function("torque", inputs, {"M_z": M_z}, cse=True)


def _signals_from_vector(vector: Expression) -> Signals:
    signals = Signals(**dict(zip(SIGNALS, ca.vertsplit(vector), strict=True)))
    return replace(signals, dt=ca.fmax(signals.dt, MIN_PERIOD))


def _advance_memory(
    model: Model, memory: ca.MX, signals: ca.MX, theta: ca.MX, geometry: ca.MX
) -> tuple[ca.MX, Signals, Expression]:
    """The memory after a sample, the sample as the patch saw it, and what drove the patch."""
    angle, before, own = model.split_angle_patch_effects(memory)
    patch_signals, memories, factor = transform_sample_by_effects(model, own, signals, theta)
    patch, turn = model.patch(theta), patch_signals.psi - angle
    coefficients = patch.coefficients(patch_inputs(patch_signals, factor, theta, geometry))
    elements = ca.vertcat(patch_signals.F_N, theta)
    turn, after = advance_in_series(
        patch, before, turn, coefficients, series_deflection(model), elements, model.search_steps
    )
    return ca.vertcat(angle + turn, after, *memories), patch_signals, coefficients


def transform_sample_by_effects(
    model: Model, own: list[Expression], signals: Expression, theta: Expression
) -> tuple[Signals, list[Expression], Expression]:
    """A sample as it reaches the patch, the effects' own memories after it, the factor on the limit."""
    patch_signals, effects, factor = (
        _signals_from_vector(signals),
        model.values_by_effect(theta),
        type(theta)(1),
    )
    memories = list(own)
    # Sensors first, so that the order of the effects does not change the signals of the others.
    for i in sorted(range(len(effects)), key=lambda i: not effects[i][0].sensor):
        effect, values = effects[i]
        patch_signals, memories[i] = effect.transform_inputs(patch_signals, own[i], values)
    for (effect, values), present in zip(effects, memories, strict=True):
        factor = factor * effect.friction(patch_signals, present, values)
    return patch_signals, memories, factor


def _torque(
    model: Model, memory: ca.MX, patch_signals: Signals, coefficients: Expression, theta: ca.MX
) -> Expression:
    """M_z of the memory after a sample [N m]."""
    _, patch, own = model.split_angle_patch_effects(memory)
    M_z = model.patch(theta).torque(patch, coefficients) + effect_memory_torque(own, model, theta)
    return add_effect_torques(M_z, model, patch_signals, theta)


def effect_memory_torque(own: list[Expression], model: Model, theta: Expression) -> Expression:
    """What the effects' own memories after a sample add to the torque [N m]."""
    M_z: Expression = type(theta)(0)
    for (effect, values), memory in zip(model.values_by_effect(theta), own, strict=True):
        M_z = M_z + effect.torque_of_memory(memory, values)
    return M_z


def add_effect_torques(
    M_z: Expression, model: Model, patch_signals: Signals, theta: Expression
) -> Expression:
    """The torque with those of the effects beside the patch [N m]."""
    for effect, values in model.values_by_effect(theta):
        M_z = M_z + effect.torque(patch_signals, values)
    return M_z
