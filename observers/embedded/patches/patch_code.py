"""A contact patch as C for the estimators."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca

from observers.embedded.scalar_type import Real
from observers.estimators.model_observer import ModelObserver
from observers.layout import Layout
from symbolic import DECLARED, GEOMETRY, SIGNALS, Model
from symbolic.patch_moment_by_zones import full_slide_arm


@dataclass(frozen=True)
class LinearisedPatch:
    """A `PatchModel` whose memory, see `memory_layout`, is an input of every step."""

    by_stiffness: bool  # The torque depends on k, which is a state.
    slides: bool  # The effective friction is in the memory too; else it is the declared model's.

    @property
    def memory_layout(self) -> Layout:
        """The memory.

        M_z [N m] and its derivative by mu, at mu [1]; its derivative by k, at k [N/m^2]; effective
        friction over mu, and what is beside it [1].
        """
        stiffness = ("by_k", "k") if self.by_stiffness else ()
        slide = ("slide", "beside") if self.slides else ()
        return Layout.of(**dict.fromkeys(("M_z", "by_mu", "mu", *stiffness, *slide), 1))

    @property
    def memory_size(self) -> int:
        """Length of the memory."""
        return self.memory_layout.size

    @property
    def coordinate_names(self) -> tuple[str, ...]:
        """Those of the declared model."""
        return tuple(parameter.name for parameter in DECLARED)

    @property
    def initial(self) -> ca.Function:
        """(signals, theta, geometry) -> zeros."""
        return ca.Function("start", self._symbols()[1:], [ca.MX(ca.DM.zeros(self.memory_size))])

    @property
    def advance(self) -> ca.Function:
        """The memory as it is: (memory, signals, theta, geometry) -> (memory_next, seen)."""
        memory, signals, *_ = inputs = self._symbols()
        return ca.Function("advance", inputs, [memory, signals])

    @property
    def torque(self) -> ca.Function:
        """The torque to first order: (memory, seen, theta, geometry) -> M_z."""
        memory, _, theta, _ = inputs = self._symbols()
        at = self.memory_layout.split(memory)
        values = dict(zip(self.coordinate_names, ca.vertsplit(theta), strict=True))
        M_z = at["M_z"] + at["by_mu"] * (values["mu"] - at["mu"])
        if self.by_stiffness:
            M_z = M_z + at["by_k"] * (values["k"] - at["k"])
        return ca.Function("torque", inputs, [M_z])

    @property
    def full_slide(self) -> ca.Function:
        """(memory, F_N, theta, geometry, rate) -> (mu_eff, M_slide)."""
        memory, _, theta, geometry = self._symbols()
        F_N, rate = ca.MX.sym("F_N"), ca.MX.sym("rate")
        if self.slides:
            at = self.memory_layout.split(memory)
            mu_eff = theta[self.coordinate_names.index("mu")] * at["slide"] + at["beside"]
            slide = [mu_eff, mu_eff * F_N * full_slide_arm(geometry[0], geometry[1])]
        else:
            declared = Model()
            memoryless = ca.MX(declared.memory_size, 1)
            slide = [*declared.full_slide(memoryless, F_N, theta, geometry, rate)]
        return ca.Function("full_slide", [memory, F_N, theta, geometry, rate], slide)

    def memory_depends_on(self, coordinate: str) -> bool:
        """False: C carries the derivative of the memory."""
        del coordinate
        return False

    def _symbols(self) -> list[ca.MX]:
        sizes = (self.memory_size, len(SIGNALS), len(self.coordinate_names), len(GEOMETRY))
        return [ca.MX.sym(f"in{i}", size) for i, size in enumerate(sizes)]


@dataclass(frozen=True, kw_only=True)
class PatchCode:
    """A contact patch as C.

    Its templates define `begin_patch`; `advance_patch` for a filter; for a window `begin_kept`,
    `follow_sample` and `kept_torque`; and, where the memory depends on mu, `forget_sensitivity`. A
    torque is an array in the order of `templates/patches/torque_places.c`.
    """

    observer: ModelObserver  # Whose patch it is.
    real: Real  # The type.
    torque_model: LinearisedPatch  # The patch as the Functions of an estimator have it.
    functions: str  # C of its tables and of the expressions of the effects.
    templates: tuple[str, ...]  # What uses these.
    type_template: str  # Template of the type of the patch, `NAME_patch_t`.
    terms: Mapping[str, Any]  # Values of the placeholders of its templates.
    k: str  # C of the stiffness of the tyre, beside a state.
    bytes: int  # Of the patch in the state.
    kept: str  # C fields that store patch data for every sample of the window.
    kept_integers: str = ""  # Those that are integers, at the end of the state.
    kept_bytes: int  # Of both, a sample.
    follows_mu: bool  # The memory depends on mu: it is moved to first order when mu is corrected.
    takes_rig: bool  # Model and rig can be taken at run time.


def mhe_window_length(observer: ModelObserver) -> int:
    """Samples of a window, 0 for a filter."""
    return int(getattr(observer, "window", 0))
