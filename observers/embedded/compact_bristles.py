"""The bristle patch in compact C: `templates/bristles.c`, its tables and the expressions of the effects.

One loop over the bristles advances them, with their derivatives by mu. What the effects change enters
as C of their own expressions (`symbolic.Effect`): once a sample what is the same for all bristles, and
for each bristle its pressure, where the patch grows, and the factors on its limit. An effect of a user's
own needs nothing else. Where nothing depends on the sample, pressure is a table.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from scipy.special import wrightomega

from observers.embedded.bristle_expressions import TERMS, BristleExpressions
from observers.embedded.scalar_type import SINGLE, Real
from observers.embedded.templating import render
from observers.measurement_model import AligningTorque
from observers.model_observer import ModelObserver
from observers.steering_torque import SteeringTorque
from symbolic import Model
from symbolic.bristles import SPAN
from symbolic.compilation.scalar_c import ELEMENTARY, c_function, c_records
from symbolic.compliance import BALANCE_STEPS
from symbolic.deformation import full_slide_arm
from symbolic.slip import REFERENCE_SPEED, REST_SPEED

OMEGA = (-12, 24)
"""Arguments between which Wright's function is a table; it is e^x before and x - ln x ... beyond."""
OMEGA_KNOTS_PER_UNIT = 4


@dataclass(frozen=True, eq=False)
class CompactBristles(BristleExpressions):
    """The bristles of an observer for which `has_bristles` holds, as text of C.

    Attributes:
        real: the type.
    """

    real: Real

    @property
    def bytes(self) -> int:
        """Bytes of the patch in the state."""
        relaxation, compliant = self.patch.traits.relaxation is not None, self.terms["compliant"]
        arrays = (4 if relaxation else 2) + compliant
        numbers = self.own + 6 + compliant * (2 + relaxation)
        return int(self.real.size * (arrays * self.patch.bristles + numbers))

    @property
    def functions(self) -> list[ca.Function]:
        """Functions that C calls by pointers: none."""
        return []

    @cached_property
    def terms(self) -> dict[str, Any]:
        """Values of the placeholders of `templates/bristles.c` that other templates share."""
        traits, deflection = self.patch.traits, self.deflection()
        branched = traits.relaxation is not None
        creep = 0.0 if traits.creep is None else float(traits.creep)
        return {
            "bristles": self.patch.bristles,
            "own": self.own,
            "terms": TERMS,
            "gained": "(1.0 + terms[TERM_GAIN]) * " if branched else "",
            "shared": " * limits->share" if branched else "",
            "branched": " + branch" if branched else "",
            "branched_by_mu": " + branch_by_mu" if branched else "",
            "relaxation": branched,
            "creep": creep,
            "grows": traits.growth is not None,
            "limited": bool(traits.limits),
            "static_limit": traits.growth is None and not traits.limits,
            "compliant": deflection is not None,
            "turned_by_angle": "psi" in self.observer.states,
            "evaluations": (2 if self.real is SINGLE else 7) if deflection is not None else 1,
            "balance_steps": 1 if self._is_linear(deflection) else BALANCE_STEPS,
            "rest_factor": 1 + creep * float(np.log(REST_SPEED / REFERENCE_SPEED)),
            "log_reference": float(np.log(REFERENCE_SPEED)),
            "offset": float(np.log(REFERENCE_SPEED)) - (1 / creep if creep else 0.0),
            "omega_from": float(OMEGA[0]),
            "omega_intervals": (OMEGA[1] - OMEGA[0]) * OMEGA_KNOTS_PER_UNIT,
            "omega_knots_per_unit": float(OMEGA_KNOTS_PER_UNIT),
            "rest_speed": REST_SPEED,
            "single": self.real is SINGLE,
        }

    def text(self, terms: dict[str, Any]) -> str:
        """C of the patch: tables, expressions of the effects, loops."""
        real = self.real.c_type
        geometry = self._tables()
        functions = [c_function("sample_terms", self.sample_terms(), real)]
        functions.append(c_function("initial_memory", self.initial(), real))
        if self.patch.traits.growth is not None:
            functions.append(c_function("pressure_at", self.pressure(), real))
        if self.patch.traits.limits:
            functions.append(c_function("limit_factor", self.limit_factor(), real))
        deflection = self.deflection()
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
        return (
            "\n".join([c_records("bristle", geometry, real), *functions])
            + "\n"
            + render("bristles.c", values)
        )

    def numbers(self, terms: Mapping[str, Any], _beside: str) -> str:
        """C of the elementary functions; the patch needs all of them, whatever the code beside it."""
        table = ""
        if self.terms["creep"] and self.real is SINGLE:
            count = int(self.terms["omega_intervals"]) + 1
            w = wrightomega(np.linspace(*OMEGA, count))
            slopes = w / (1 + w) / OMEGA_KNOTS_PER_UNIT
            rows = "".join(f"    {{{v:.9g}, {s:.9g}}},\n" for v, s in zip(w, slopes, strict=True))
            table = (
                "/* Wright's function: value, and slope times spacing. */\n"
                f"static const float omega_of[{count}][2] = {{\n{rows}}};\n\n"
            )
        return table + render("numbers.c", {**terms, **self.terms, "used": ELEMENTARY})

    def state_type(self, name: str) -> str:
        """The type of the patch, C of a header."""
        n, real = self.patch.bristles, self.real.c_type
        gain = ", gain" if self.patch.traits.relaxation is not None else ""
        compliance = (
            f"    {real} follows[{n}], further, further_by_mu{gain}; /* what the last turn lacked */\n"
        )
        branch = f"    {real} branch[{n}], branch_by_mu[{n}]; /* stress of the Maxwell branches */\n"
        return (
            "/* The contact patch: deformation of the bristles over the half-length, see the code. */\n"
            "typedef struct {\n"
            f"    {real} q[{n}], q_by_mu[{n}];\n"
            f"{branch if self.patch.traits.relaxation is not None else ''}"
            f"{f'    {real} own[{self.own}]; /* of the effects */' + chr(10) if self.own else ''}"
            f"{compliance if self.terms['compliant'] else ''}"
            f"    {real} angle, angle_by_mu, mu, M_z, M_z_by_mu, slope;\n"
            f"}} {name}_patch_t;\n\n"
        )

    def _tables(self) -> dict[str, NDArray[np.float64]]:
        """What of every bristle does not depend on the sample.

        Lever arm over a [1] and moment of q / a [N m]; limit of q / a over mu and load [1/N], or the
        place over a [1] where the patch grows.
        """
        geometry = replace(self.patch, traits=replace(self.patch.traits, limits=()))
        numbers = np.asarray(geometry.coefficients(self.inputs())).ravel()
        n = self.patch.bristles
        tables = {"lever": numbers[:n], "moment": numbers[2 * n : 3 * n]}
        if self.terms["compliant"]:
            tables["moment_lever"] = tables["moment"] * tables["lever"]
        if self.patch.traits.growth is not None:
            return tables | {"place": SPAN * np.asarray(self.patch.nodes()[0]).ravel()}
        tables["pressure"] = pressure = numbers[n : 2 * n]
        if self.terms["creep"] and self.terms["static_limit"]:
            tables |= {"inverse_pressure": 1 / pressure, "log_pressure": np.log(pressure)}
        return tables

    def _slide_constant(self) -> str:
        """Effective friction over mu where the patch has one length, else empty [1]."""
        if self.patch.traits.growth is not None:
            return ""
        inputs = self.inputs(speed=self.observer.rig.slide_rate)
        return repr(float(self.patch.effective_friction(inputs)))

    def _slide_weight(self) -> str:
        """Torque of q / a over the full-slide torque of the declared patch under 1 N."""
        rig = self.observer.rig
        return repr(1.0 / float(full_slide_arm(rig.a, rig.e)))

    def _is_linear(self, deflection: ca.Function | None) -> bool:
        if deflection is None:
            return True
        M_z, F_N = ca.SX.sym("M_z"), ca.SX.sym("F_N")
        return not ca.depends_on(deflection(M_z, F_N)[1], M_z)


def has_bristles(observer: ModelObserver) -> bool:
    """True for a model that needs bristles, under a measurement model of `observers`, k being known.

    C advances the patch by the sample as it comes, which a subclass may clean or use in another way.
    """
    if type(observer.model) is not Model or "stiffness" in observer.states:
        return False
    known = type(observer.measurement_model) in (AligningTorque, SteeringTorque)
    return known and not observer.model.exact
