"""Templates of C and what fills them, by `symbolic.compilation.bristle_kernel.template_environment`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from symbolic.compilation.bristle_kernel import template_environment


@dataclass(frozen=True, kw_only=True)
class ObserverBody:
    """The part of generated code that differs between observers."""

    core: str  # C of the computation.
    stepping: str  # C of `begin` and `advance`, which public functions call.
    private_fields: str  # Fields of the state.
    bytes: int  # Their size.
    types: str = ""  # Their types in the header.
    rig_at_run_time: bool = False  # The patch takes the rig at run time, by its `set_geometry`.
    supervised: bool = False  # C acquires friction first, see `.estimators.supervision`.
    scaled: bool = False  # And divides the aligning torque by the stiffness that was found.


def render(template_name: str, terms: Mapping[str, Any]) -> str:
    """The text of a template of this package; a term that is missing is an error."""
    return template_environment("observers.embedded").get_template(template_name).render(terms)
