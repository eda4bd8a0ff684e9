"""The exact patch under effects that leave it exact, in compact C: `templates/patch.c` and `corners.c`.

Effects on the sensors, on the friction of the whole patch and on the torque beside it enter as C of
their own expressions, once a sample.
"""

from dataclasses import dataclass
from typing import Any

import casadi as ca

from observers.embedded.bristle_expressions import TERMS, BristleExpressions
from observers.embedded.compact_patch import build_corner, patch_bytes, patch_numbers, patch_types
from observers.embedded.scalar_type import Real
from observers.embedded.templating import render
from observers.measurement_model import AligningTorque
from observers.mhe import Mhe
from observers.model_observer import ModelObserver
from observers.steering_torque import SteeringTorque
from symbolic import Model
from symbolic.compilation.scalar_c import ELEMENTARY, c_function
from symbolic.compliance import deflection_of


@dataclass(frozen=True, eq=False)
class CompactCorners(BristleExpressions):
    """The patch of an observer for which `has_corners` holds, as text of C.

    Attributes:
        real: the type.
    """

    real: Real

    @property
    def bytes(self) -> int:
        """Bytes of the patch in the state."""
        return patch_bytes(self.real) + self.own * self.real.size

    @property
    def functions(self) -> list[ca.Function]:
        """Functions that C calls by pointers."""
        return [build_corner(self.observer)]

    @property
    def terms(self) -> dict[str, Any]:
        """Values of the placeholders that other templates share."""
        return {"own": self.own, "terms": TERMS, "bristles": 0, "creep": 0.0, "single": False,
                "is_window": isinstance(self.observer, Mhe)}  # fmt: skip

    def text(self, terms: dict[str, Any]) -> str:
        """C of the patch: the polyline, expressions of the effects, a sample."""
        real, values = self.real.c_type, {**terms, **self.terms, **patch_numbers(self.observer)}
        functions = {"sample_terms": self.sample_terms(), "initial_memory": self.initial()}
        effects = "\n".join(c_function(name, f, real) for name, f in functions.items())
        patch, corners = render("patch.c", values), render("corners.c", values)
        return f"{patch}\n{effects}\n{corners}"

    def numbers(self, terms: dict[str, Any], beside: str) -> str:
        """C of the elementary functions that the patch and the code beside it need."""
        text = self.text(terms) + beside
        used = [name for name in ELEMENTARY if f"{name}(" in text]
        return render("numbers.c", {**terms, **self.terms, "used": used})

    def state_type(self, name: str) -> str:
        """The type of the patch, C of a header."""
        return patch_types(self.real, name, own=self.own)


def has_corners(observer: ModelObserver) -> bool:
    """True for effects that leave the patch exact, none of them in series with it, k being known."""
    model = observer.model
    if type(model) is not Model or not model.exact or not model.effects:
        return False
    known = type(observer.measurement_model) in (AligningTorque, SteeringTorque)
    return known and "stiffness" not in observer.states and deflection_of(model) is None
