"""A contact patch as C for the estimators."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from observers.embedded.patches.linear_torque import LinearTorque
from observers.embedded.scalar_type import Real
from observers.estimators.model_observer import ModelObserver


@dataclass(frozen=True, kw_only=True)
class PatchCode:
    """A contact patch as C.

    Its templates define `begin_patch`; `advance_patch` for a filter; for a window `begin_kept`,
    `follow_sample` and `kept_torque`; and, where the memory depends on mu, `forget_sensitivity`. A
    torque is an array in the order of `templates/patches/torque_places.c`.

    Attributes:
        observer: whose patch it is.
        real: the type.
        torque_model: the patch as the Functions of an estimator have it.
        functions: C of its tables and of the expressions of the effects.
        templates: what uses these.
        type_template: template of the type of the patch, `NAME_patch_t`.
        terms: values of the placeholders of its templates.
        k: C of the stiffness of the tyre, beside a state.
        bytes: of the patch in the state.
        kept, kept_integers: C fields that store patch data for every sample of the window; the integers
            stand at the end of the state.
        kept_bytes: of both, a sample.
        follows_mu: the memory depends on mu: it is moved to first order when mu is corrected.
        takes_rig: model and rig can be taken at run time.
    """

    observer: ModelObserver
    real: Real
    torque_model: LinearTorque
    functions: str
    templates: tuple[str, ...]
    type_template: str
    terms: Mapping[str, Any]
    k: str
    bytes: int
    kept: str
    kept_integers: str = ""
    kept_bytes: int
    follows_mu: bool
    takes_rig: bool


def angle_is_state(observer: ModelObserver) -> bool:
    """True where the angle is a state, so that the slope of the torque by it matters."""
    return "psi" in observer.states


def window_of(observer: ModelObserver) -> int:
    """Samples of a window, 0 for a filter."""
    return int(getattr(observer, "window", 0))
