"""An estimator on a patch, each chosen by itself, joined to compact C.

Another kind of sensing is a `MeasurementModel` alone: C takes what it needs from its expressions.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar, Protocol

import casadi as ca

from observers.ekf import Ekf
from observers.embedded.constants import Constants, Tunable
from observers.embedded.estimators.filter import CompactFilter
from observers.embedded.estimators.measurement_traits import advances_once
from observers.embedded.estimators.supervision import supervised, supervision_functions
from observers.embedded.estimators.window import CompactWindow
from observers.embedded.patches.bristles import Bristles, has_bristles
from observers.embedded.patches.corners import Corners, has_corners
from observers.embedded.patches.interface import EmbeddedPatch
from observers.embedded.scalar_function import estimator_c
from observers.embedded.scalar_type import Real
from observers.embedded.templating import Body, render
from observers.mhe import Mhe
from observers.model_observer import ModelObserver
from observers.patch_update import memory_depends_on_tyre
from observers.protocol import FunctionObserver
from symbolic import DECLARED
from symbolic.scalar_c import ELEMENTARY

ESTIMATORS: Mapping[type, type[CompactFilter | CompactWindow]] = {
    Ekf: CompactFilter,
    Mhe: CompactWindow,
}
"""Estimators in compact C; a subclass may compute something else."""


class CompactEstimator(Protocol):
    """An estimator on a patch, as Functions of scalars and a template of C that calls them."""

    template: ClassVar[str]

    @property
    def patch(self) -> EmbeddedPatch:
        """The patch, and with it the observer."""

    @property
    def constants(self) -> Constants:
        """Constants of the observer."""

    @property
    def functions(self) -> list[ca.Function]:
        """The Functions of a step."""

    @property
    def terms(self) -> Mapping[str, Any]:
        """Values of the placeholders of the templates."""

    def types(self, name: str) -> str:
        """Types of the state, C of the header."""

    def private(self, name: str) -> str:
        """Fields of the state."""

    @property
    def bytes(self) -> int:
        """Bytes of these fields without the patch."""


def compact_of(observer: FunctionObserver, real: Real, tunable: Tunable = "") -> CompactEstimator | None:
    """The compact code of an observer; None where there is none, and CasADi writes vectors.

    There is some for an `Ekf` of one linearisation and an `Mhe` of one iteration over two samples or
    more, neither a subclass, on a patch that C has.
    """
    if not isinstance(observer, ModelObserver) or (kind := ESTIMATORS.get(type(observer))) is None:
        return None
    if getattr(observer, "iterations", 1) != 1 or getattr(observer, "window", 2) < 2:
        return None
    if not advances_once(observer.measurement_model):
        return None
    patch = _patch_of(observer, real, with_rig=tunable == "all")
    if patch is None or (tunable == "all" and not patch.takes_rig):
        return None
    return kind(patch, Constants(observer, tunable, theta=range(len(DECLARED))))


def _patch_of(observer: ModelObserver, real: Real, *, with_rig: bool) -> EmbeddedPatch | None:
    if has_bristles(observer):
        return Bristles(observer, real)
    if not has_corners(observer):
        return None
    is_window = isinstance(observer, Mhe)
    if is_window and memory_depends_on_tyre(observer.model, observer.measurement_model):
        return None
    return Corners(observer, real, with_rig and not observer.model.effects)


def compact_body(estimator: CompactEstimator, terms: Mapping[str, Any]) -> Body:
    """The part of generated code that differs between observers."""
    patch, name = estimator.patch, str(terms["name"])
    observer, real = patch.observer, patch.real
    values = {**terms, **patch.terms, **estimator.terms}
    functions = [*estimator.functions, *supervision_functions(observer, estimator.constants)]
    written = "\n".join(estimator_c(function, real) for function in functions)
    of_patch = patch.text(values)
    used = [name for name in ELEMENTARY if f"{name}(" in written + of_patch]
    elementary = render("numbers.c", {"creep": 0.0, "single": False, **values, "used": used})
    body = Body(
        core=patch.tables() + elementary + render("patches/interface.c", values) + written + of_patch,
        stepping=render(estimator.template, values),
        private=estimator.private(name),
        bytes=estimator.bytes + patch.bytes,
        types=patch.state_type(name) + estimator.types(name),
    )
    body = replace(body, with_rig=bool(values["with_rig"]))
    return supervised(observer, real, values, body)
