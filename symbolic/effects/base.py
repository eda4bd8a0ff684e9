"""The interface of an effect: a frozen value with its parameters and its hooks in the model."""

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal, Protocol

import casadi as ca

from symbolic.bristle_patch import BristleTraits
from symbolic.errors import InvalidInputError

# Re-exported: a file with an effect imports all its types from here.
from symbolic.patch_interface import Expression as Expression
from symbolic.patch_interface import Patch
from symbolic.patch_interface import Signals as Signals

Scope = Literal["tyre", "ground", "recording"]
_QUOTES = frozenset("\"'<>&\\")
"""Signs that end a text in C, XML or A2L, or begin something else there."""
Family = Literal[
    "friction over speed",
    "friction over time",
    "friction over load",
    "friction over direction",
    "compliance and contact shape",
    "contact over load",
    "sensor and steering",
    "other",
]
"""Mechanisms; the effects of a family are laws of the same one, but for values of each recording, such
as a zero. An "other" is a mechanism of its own.

"friction over time" is friction over time and travel: it changes with time or with the angle turned.
"""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of an effect.

    Attributes:
        name: its name in files and reports.
        unit: its unit, as in "N m/rad".
        neutral: the value at which the effect vanishes; may be infinite. None: the parameter alone does
            not switch the effect, another one of the same effect does.
        start: where a fit begins, off the neutral value so that every derivative is alive.
        lower: least value allowed.
        upper: greatest value allowed.
        scope: what a value belongs to: the "tyre", so that all recordings share it, the "ground" that a
            recording stands on, or the "recording".
        of: "friction" for a parameter of the law of friction of tyre and ground, "stiffness" for one of
            the bristles; None for neither.
        scale: size of a plain change, by which a solver scales it.
        inverse: fit one over the value, for compliances whose neutral value is an infinite stiffness.
        fixed: never fitted; the recordings give its value, see `Effect.fixed_values`.
    """

    name: str
    unit: str
    neutral: float | None
    start: float
    lower: float
    upper: float
    scale: float
    scope: Scope = "tyre"
    of: Literal["friction", "stiffness"] | None = None
    inverse: bool = False
    fixed: bool = False

    @property
    def coordinate_name(self) -> str:
        """Name under which hooks find the value that the solver moves: the name, or "1/name"."""
        return f"1/{self.name}" if self.inverse else self.name

    def require_within(self, value: float, label: str) -> None:
        """Check a value against the bounds; NaN lies in none.

        Raises:
            InvalidInputError: it lies outside; the message begins with the label.
        """
        if not self.lower <= value <= self.upper:
            raise InvalidInputError(
                f"{label} must lie in [{self.lower}, {self.upper}] {self.unit}, got {value}"
            )

    def to_coordinate(self, value: float) -> float:
        """The solver's coordinate of a value; applied twice it gives the value back."""
        if not self.inverse:
            return value
        return math.inf if value == 0 else 1 / value

    def __post_init__(self) -> None:
        """Check that the start lies within the bounds, and what generated files quote."""
        if not self.name.isidentifier():
            raise InvalidInputError(f"a parameter's name must be an identifier, got {self.name!r}")
        if not self.unit.isprintable() or set(self.unit) & _QUOTES or {"*", "/"} <= set(self.unit):
            raise InvalidInputError(
                f"parameter {self.name}: a unit must be a few plain signs, as in 'N m/rad', got"
                f" {self.unit!r}"
            )
        self.require_within(self.start, f"parameter {self.name}: start")
        if self.fixed and self.scope != "tyre":
            raise InvalidInputError(f"parameter {self.name}: a fixed parameter belongs to the tyre")


@dataclass(frozen=True)
class ResidualSignature:
    """A signal that the residual follows where an effect is missing from the model.

    Attributes:
        signal: name of the signal, one of `identification.RESIDUAL_SIGNALS`.
        sign: 1 or -1, the sign of the correlation of simulated minus measured torque with the signal;
            0 where it may be either.
        rank: place among the effects that leave the same signature, 0 for the likeliest.
    """

    signal: str
    sign: Literal[-1, 0, 1] = 0
    rank: int = 0


Values = Mapping[str, Expression]
"""Parameter coordinates of one effect, by name, as casadi expressions."""


@dataclass(frozen=True, kw_only=True)
class Effect:
    """A physical effect beside the declared brush model; every hook is neutral unless overridden.

    Attributes:
        name: the name in files and reports.
        parameters: its part of the parameter vector, in this order.
        summary: one line in plain words.
        family: the mechanism that it is a law of.
        flexible: True for one that stands for whatever law of its family the library lacks.
        memory: length of its own memory from sample to sample.
        sensor: True where `transform_inputs` changes what everything else sees, so that it comes first.
        torque_by_ground: True where `torque` is the ground's, so that the torque of full slide includes
            it. What bearings, springs and the sensor add is not the ground's friction.
        is_gap: True where `deflection` is the turn through a gap, crossed at no torque: its sign tells
            the flank that is touched.
        of_lengths: True where it gives the declared half-length another meaning, so that lengths found
            within their tolerances without it say nothing of those beside it.
        tare: name of the parameter that the effect's torque adds so that the first sample's is zero, as
            on a channel that was tared there; empty for none. `simulate` sees to it whatever its value.
        signatures: what the residual follows where the effect is missing; empty if no signal shows it.
    """

    name: str
    summary: str
    parameters: tuple[Parameter, ...]
    family: ClassVar[Family] = "other"
    flexible: ClassVar[bool] = False
    memory: int = 0
    sensor: bool = False
    torque_by_ground: bool = False
    is_gap: bool = False
    of_lengths: bool = False
    tare: str = ""
    signatures: tuple[ResidualSignature, ...] = ()

    @property
    def needs_bristles(self) -> bool:
        """Whether it breaks the parabola, so that only the bristle patch will do: it has `traits`."""
        return type(self).traits is not Effect.traits

    @property
    def changes_scopes(self) -> bool:
        """Whether it gives parameters of the model another scope: it has `scope_of`."""
        return type(self).scope_of is not Effect.scope_of

    @property
    def is_per_recording(self) -> bool:
        """Whether every recording has values of its own of all its parameters, as of a torque zero."""
        return {parameter.scope for parameter in self.parameters} == {"recording"}

    @property
    def adds_torque_from_memory(self) -> bool:
        """Whether its own memory adds to the torque: it has `torque_of_memory`."""
        return type(self).torque_of_memory is not Effect.torque_of_memory

    def fixed_values(self, a: Sequence[float], F_N: Sequence[float]) -> Mapping[str, float]:
        """Values of the parameters that are never fitted, by name.

        Args:
            a: declared half-lengths of the patch [m], one a recording.
            F_N: mean vertical loads [N], one a recording.
        """
        return {}

    def scope_of(self, parameter: Parameter) -> Scope:
        """Owner of a parameter in a model with this effect."""
        return parameter.scope

    def initial(self, signals: Signals) -> Expression:
        """Memory before the first sample, shape (memory,)."""
        raise NotImplementedError(f"{self.name} has memory but no initial value")

    def transform_inputs(
        self, signals: Signals, memory: Expression, values: Values
    ) -> tuple[Signals, Expression]:
        """Signals at the patch, from the recorded ones, and the next memory."""
        return signals, memory

    def initial_angle(self, values: Values) -> Expression:
        """Angle by which the patch was turned before the first sample [rad]."""
        return 0

    def friction(self, signals: Signals, memory: Expression, values: Values) -> Expression:
        """Factor on the friction limit, the same for every bristle [1]."""
        return 1

    def traits(self, traits: BristleTraits, values: Values) -> BristleTraits:
        """The traits of the bristles with those of this effect added."""
        return traits

    def deflection(self, M_z: Expression, F_N: Expression, values: Values) -> Expression | None:
        """Turn of the patch against the recorded angle [rad], by an element in series with it.

        Args:
            M_z: torque of the patch [N m]; the turn rises with it, is zero at zero, and has its sign.
            F_N: vertical load [N].
            values: parameters of the effect.

        Returns:
            The turn; None where nothing is in series.
        """
        return None

    def torque(self, signals: Signals, values: Values) -> Expression:
        """Torque added to that of the patch [N m]."""
        return 0

    def torque_of_memory(self, memory: Expression, values: Values) -> Expression:
        """Torque that the effect's own memory after the sample adds besides [N m].

        It is not the ground's, and zero at the first sample. Observers, which estimate the zero of the
        torque from sample to sample, take such an effect only at its neutral values.
        """
        return 0


class ModelProtocol(Hashable, Protocol):
    """Members of `symbolic.Model` that an effect needs."""

    @property
    def memory_size(self) -> int:
        """Length of the memory."""

    def patch(self, theta: Expression | None = None) -> Patch:
        """The patch."""

    def input_symbols(self) -> tuple[ca.MX, ca.MX, ca.MX]:
        """Symbols for signals, theta and geometry."""

    def values_by_effect(self, theta: Expression) -> Sequence[tuple[Effect, Values]]:
        """Each effect with its parameters."""

    def split_angle_patch_effects(
        self, memory: Expression
    ) -> tuple[Expression, Expression, list[Expression]]:
        """Patch angle, patch memory, and each effect's own memory."""


def parameter_name(effect: Effect | None, parameter: Parameter) -> str:
    """The name of a parameter in files: `mu`, `k`, or `effect.parameter`."""
    return f"{effect.name}.{parameter.name}" if effect else parameter.name


def with_limit(traits: BristleTraits, factor: Any) -> BristleTraits:
    """The traits with one more factor on the friction limit, a function of sliding speed [m/s]."""
    return replace(traits, limits=(*traits.limits, factor))


def with_shape(traits: BristleTraits, factor: Any) -> BristleTraits:
    """The traits with one more factor on the pressure parabola, a function of u = x / a."""
    return replace(traits, shape=(*traits.shape, factor))


def with_scope(parameter: Parameter, effects: Sequence[Effect]) -> Parameter:
    """The parameter with the scope that these effects give it, see `Effect.scope_of`."""
    for effect in effects:
        if (scope := effect.scope_of(parameter)) != parameter.scope:
            parameter = replace(parameter, scope=scope)
    return parameter
