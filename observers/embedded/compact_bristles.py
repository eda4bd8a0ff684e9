"""The bristle patch in compact C: `templates/bristles.c`, its tables and the expressions of the effects.

One loop over the bristles advances them, with their derivatives by mu. What the effects change enters
as C of their own expressions (`symbolic.Effect`): once a sample what is the same for all bristles, and
for each bristle its pressure, where the patch grows, and the factors on its limit. An effect of a user's
own needs nothing else. Where nothing depends on the sample, pressure is a table.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np

from observers.embedded.scalar_c import c_function, c_table
from observers.embedded.scalar_function import scalar_function
from observers.embedded.scalar_type import SINGLE, Real
from observers.embedded.templating import render
from observers.measurement_model import AligningTorque
from observers.model_observer import ModelObserver
from observers.steering_torque import SteeringTorque
from symbolic import SIGNALS, Model
from symbolic.bristles import SPAN, BristlePatch
from symbolic.compliance import BALANCE_STEPS, deflection_of
from symbolic.deformation import full_slide_arm
from symbolic.full_slide import build_full_slide
from symbolic.model import at_the_patch
from symbolic.patch import PatchInputs
from symbolic.slip import REFERENCE_SPEED, REST_SPEED

BRISTLES = 50
"""Bristles over the length of the patch in generated C, see `docs/embedded.md`."""
TERMS = ("psi", "F_N", "speed", "base", "growth", "reach", "decay", "gain", "torque", "torque_by_psi",
         "slide", "beside")  # fmt: skip
"""What a sample does to all bristles alike, in the order of C."""


@dataclass(frozen=True)
class _SlidingPatch:
    """A patch of which only the effective friction is known, per mu and factor."""

    value: float

    def effective_friction(self, inputs: PatchInputs) -> Any:
        return inputs.mu * inputs.factor * self.value


@dataclass(frozen=True)
class _Sliding:
    """The model for `build_full_slide`, on a patch whose effective friction is mu times the factor."""

    model: Model

    @property
    def memory_size(self) -> int:
        return self.model.memory_size

    def patch(self, theta: Any = None) -> _SlidingPatch:
        del theta
        return _SlidingPatch(1.0)

    def symbols(self) -> tuple[ca.MX, ca.MX, ca.MX]:
        return self.model.symbols()

    def values(self, theta: Any) -> Any:
        return self.model.values(theta)

    def split(self, memory: Any) -> Any:
        return self.model.split(memory)


@dataclass(frozen=True, eq=False)
class CompactBristles:
    """The bristles of an observer's model, as text of C.

    Attributes:
        observer: an observer for which `has_bristles` holds.
        real: the type.
    """

    observer: ModelObserver
    real: Real

    @cached_property
    def model(self) -> Model:
        """The observer's model on bristles, no more of them than `BRISTLES`."""
        model = self.observer.model
        return replace(model, discretised=True, lengthways=min(BRISTLES, model.lengthways))

    @cached_property
    def theta(self) -> ca.DM:
        """The parameters with mu = 1."""
        return self.model.theta({**self.observer.values, "mu": 1.0})

    @cached_property
    def patch(self) -> BristlePatch:
        """The patch with its traits as numbers."""
        patch = self.model.patch(self.theta)
        assert isinstance(patch, BristlePatch)
        return patch

    @property
    def own(self) -> int:
        """Length of the effects' own memories."""
        return sum(effect.memory for effect in self.model.effects)

    @property
    def bytes(self) -> int:
        """Bytes of the patch in the state."""
        arrays = 2 if self.patch.traits.relaxation is None else 4
        return self.real.size * (arrays * self.patch.bristles + self.own + 6)

    @cached_property
    def terms(self) -> dict[str, Any]:
        """Values of the placeholders of `templates/bristles.c` that other templates share."""
        traits, deflection = self.patch.traits, self._deflection()
        creep = 0.0 if traits.creep is None else float(traits.creep)
        return {
            "bristles": self.patch.bristles,
            "own": self.own,
            "terms": TERMS,
            "relaxation": traits.relaxation is not None,
            "creep": creep,
            "grows": traits.growth is not None,
            "limited": bool(traits.limits),
            "static_limit": traits.growth is None and not traits.limits,
            "compliant": deflection is not None,
            "turned_by_angle": "psi" in self.observer.states,
            "evaluations": (2 if self.real is SINGLE else 7) if deflection is not None else 1,
            "balance_steps": 1 if self._is_linear(deflection) else BALANCE_STEPS,
            "log_rest": float(np.log(REST_SPEED / REFERENCE_SPEED)),
            "log_reference": float(np.log(REFERENCE_SPEED)),
            "rest_speed": REST_SPEED,
            "single": self.real is SINGLE,
            "own_copies": "own_next" if self.own else "",
        }

    def text(self, terms: dict[str, Any]) -> str:
        """C of the patch: tables, expressions of the effects, loops."""
        real = self.real.c_type
        geometry = self._tables()
        static = self._static_limit()
        tables = [c_table(f"{name}_of", values, real) for name, values in geometry.items()]
        functions = [c_function("sample_terms", self._sample_terms(), real)]
        functions.append(c_function("initial_memory", self._initial(), real))
        if self.patch.traits.growth is None:
            tables.append(c_table("pressure_of", static, real))
        else:
            functions.append(c_function("pressure_at", self._pressure(), real))
        if self.patch.traits.limits:
            functions.append(c_function("limit_factor", self._limit_factor(), real))
        deflection = self._deflection()
        if deflection is not None:
            functions.append(c_function("deflection", deflection, real))
        values = {
            **terms,
            **self.terms,
            "slide": self._slide_constant(),
            "slide_rate": repr(float(self.observer.rig.slide_rate)),
            "slide_weight": self._slide_weight(),
            "stiff": repr(float(-(geometry["moment"] * geometry["lever"]).sum())),
        }
        return "\n".join([*tables, *functions]) + "\n" + render("bristles.c", values)

    def state_type(self, name: str) -> str:
        """The type of the patch, C of a header."""
        n, real = self.patch.bristles, self.real.c_type
        branch = f"    {real} branch[{n}], branch_by_mu[{n}]; /* stress of the Maxwell branches */\n"
        return (
            "/* The contact patch: deformation of the bristles over the half-length, see the code. */\n"
            "typedef struct {\n"
            f"    {real} q[{n}], q_by_mu[{n}];\n"
            f"{branch if self.patch.traits.relaxation is not None else ''}"
            f"{f'    {real} own[{self.own}]; /* of the effects */' + chr(10) if self.own else ''}"
            f"    {real} angle, angle_by_mu, mu, M_z, M_z_by_mu, slope;\n"
            f"}} {name}_patch_t;\n\n"
        )

    def _tables(self) -> dict[str, np.ndarray]:
        """Lever arm over a [1], moment of q / a [N m], of every bristle; its place where it moves."""
        rigid = replace(self.patch, traits=replace(self.patch.traits, limits=(), growth=None))
        geometry = replace(self.patch, traits=replace(self.patch.traits, limits=()))
        numbers = np.asarray(geometry.coefficients(self._inputs())).ravel()
        n = self.patch.bristles
        tables = {"lever": numbers[:n], "moment": numbers[2 * n : 3 * n]}
        if self.patch.traits.growth is not None:
            tables["place"] = SPAN * np.asarray(rigid.nodes()[0]).ravel()
        return tables

    def _static_limit(self) -> np.ndarray:
        """Limit of q / a of every bristle over mu and load [1/N], where the patch has one length."""
        rigid = replace(self.patch, traits=replace(self.patch.traits, limits=(), growth=None))
        n = self.patch.bristles
        return np.asarray(rigid.coefficients(self._inputs())).ravel()[n : 2 * n]

    def _inputs(self, **changes: Any) -> PatchInputs:
        """Inputs of the patch for mu = 1, a load of 1 N and no speed, as numbers."""
        rig, k = self.observer.rig, self.observer.values["k"]
        usual = {"speed": 0.0, "dt": 1.0, "F_N": 1.0, "factor": 1.0, "mu": 1.0}
        return PatchInputs(**{**usual, "k": k, "a": rig.a, "e": rig.e, **changes})

    def _slide_constant(self) -> str:
        """Effective friction over mu where the patch has one length, else empty [1]."""
        if self.patch.traits.growth is not None:
            return ""
        inputs = self._inputs(speed=self.observer.rig.slide_rate)
        return repr(float(self.patch.effective_friction(inputs)))

    def _slide_weight(self) -> str:
        """Torque of q / a over the full-slide torque of the declared patch under 1 N."""
        rig = self.observer.rig
        return repr(1.0 / float(full_slide_arm(rig.a, rig.e)))

    def _sample_terms(self) -> ca.Function:
        """(signals, own) -> (terms, own_next): what the effects make of a sample."""
        model, rig = self.model, self.observer.rig
        signals, own = ca.MX.sym("signals", len(SIGNALS)), ca.MX.sym("own", self.own)
        theta = ca.MX.sym("theta", self.theta.numel())
        memory = ca.vertcat(ca.MX.zeros(1 + self.patch.size), own)
        seen, memories, factor = at_the_patch(model, model.split(memory)[2], signals, theta)
        after = ca.vertcat(ca.MX.zeros(1 + self.patch.size), *memories)
        torque = ca.MX(0)
        for effect, values in model.values(theta):
            torque = torque + effect.torque(seen, values)
        traits = model.patch(theta)
        assert isinstance(traits, BristlePatch)
        growth: Any = ca.MX(1)
        if traits.traits.growth is not None:
            growth = ca.fmin(SPAN, traits.traits.growth(seen.F_N, rig.a))
        inputs = self._inputs(speed=seen.psi_dot, dt=seen.dt, F_N=seen.F_N, factor=factor)
        coefficients = traits.coefficients(inputs)
        n = traits.bristles
        geometry = ca.DM([rig.a, rig.e])
        sliding, load = build_full_slide(_Sliding(model)), signals[SIGNALS.index("F_N")]
        slides = sliding(after, load, theta, geometry, rig.slide_rate)[0]
        zero_mu = theta * ca.DM([0] + [1] * (theta.numel() - 1))
        beside = sliding(after, load, zero_mu, geometry, rig.slide_rate)[0]
        named = {
            "psi": seen.psi, "F_N": seen.F_N, "speed": ca.fabs(seen.psi_dot) * rig.a,
            "base": factor * seen.F_N, "growth": growth, "reach": coefficients[3 * n + 2],
            "decay": coefficients[3 * n], "gain": coefficients[3 * n + 1], "torque": torque,
            "torque_by_psi": ca.jacobian(torque, signals)[SIGNALS.index("psi")],
            "slide": slides - beside, "beside": beside,
        }  # fmt: skip
        outputs = [ca.densify(ca.vertcat(*(named[name] for name in TERMS))), ca.vertcat(*memories)]
        function = ca.Function(
            "sample_terms", [signals, own, theta], outputs, ["signals", "own", "theta"],
            ["terms", "own_next"],
        )  # fmt: skip
        return scalar_function("sample_terms", function, {"theta": self._numbers()})

    def _initial(self) -> ca.Function:
        """(signals) -> (angle, own): the memory before the first sample."""
        initial = self.model.initial
        signals, theta = ca.MX.sym("signals", len(SIGNALS)), ca.MX.sym("theta", self.theta.numel())
        memory = initial(signals, theta, ca.DM([self.observer.rig.a, self.observer.rig.e]))
        outputs = [memory[0], memory[1 + self.patch.size :]]
        function = ca.Function(
            "initial_memory", [signals, theta], outputs, ["signals", "theta"], ["angle", "own"]
        )
        return scalar_function("initial_memory", function, {"theta": self._numbers()})

    def _pressure(self) -> ca.Function:
        """(place, growth) -> limit over mu and load [1/N], of a patch that grows."""
        place, growth = ca.MX.sym("place"), ca.MX.sym("growth")
        scale = self.observer.values["k"] * self.observer.rig.a ** 2
        pressure = self.patch.traits.pressure(place, growth) / scale
        return ca.Function(
            "pressure_at", [place, growth], [pressure], ["place", "growth"], ["pressure"]
        ).expand()

    def _limit_factor(self) -> ca.Function:
        """(speed) -> factor on the limit of a bristle that the wheel drives at this speed [m/s]."""
        speed, factor = ca.MX.sym("speed"), ca.MX(1)
        for limit in self.patch.traits.limits:
            factor = factor * limit(speed)
        return ca.Function("limit_factor", [speed], [factor], ["speed"], ["factor"]).expand()

    def _deflection(self) -> ca.Function | None:
        """(M_z, F_N) -> (turn, by_torque): elements in series with the patch; None for none."""
        deflection = deflection_of(self.model)
        if deflection is None:
            return None
        M_z, F_N, theta = (
            ca.MX.sym("M_z"), ca.MX.sym("F_N"), ca.MX.sym("theta", self.theta.numel()),
        )  # fmt: skip
        turn = deflection(M_z, ca.vertcat(F_N, theta))
        outputs = [turn, ca.densify(ca.jacobian(turn, M_z))]
        function = ca.Function(
            "deflection", [M_z, F_N, theta], outputs, ["M_z", "F_N", "theta"], ["turn", "by_torque"]
        )
        return scalar_function("deflection", function, {"theta": self._numbers()})

    def _is_linear(self, deflection: ca.Function | None) -> bool:
        if deflection is None:
            return True
        M_z, F_N = ca.SX.sym("M_z"), ca.SX.sym("F_N")
        return not ca.depends_on(deflection(M_z, F_N)[1], M_z)

    def _numbers(self) -> np.ndarray:
        return np.asarray(self.theta).ravel()


def has_bristles(observer: ModelObserver) -> bool:
    """True for a model that needs bristles, under a measurement model of `observers`, k being known.

    C advances the patch by the sample as it comes, which a subclass may clean or use in another way.
    """
    if type(observer.model) is not Model or "stiffness" in observer.states:
        return False
    deflects = deflection_of(observer.model) is not None
    known = type(observer.measurement_model) in (AligningTorque, SteeringTorque)
    return known and (not observer.model.exact or deflects)
