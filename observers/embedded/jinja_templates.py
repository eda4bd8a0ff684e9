"""Templates of C: `${name}` stands for a value, a line that begins with %% is a statement of jinja2."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

ENVIRONMENT = Environment(
    loader=PackageLoader("observers.embedded"),
    undefined=StrictUndefined,
    variable_start_string="${",
    variable_end_string="}",
    line_statement_prefix="%%",
    keep_trailing_newline=True,
)


@dataclass(frozen=True, kw_only=True)
class ObserverBody:
    """The part of generated code that differs between observers.

    Attributes:
        core, stepping: C of the computation, and of `begin` and `advance`, which public functions call.
        private_fields, types, bytes: fields of the state, their types in the header, and their size.
        supervised: C acquires friction first, see `observers.embedded.estimators.supervision`.
        scaled: and divides the aligning torque by the stiffness that was found.
        rig_at_run_time: the patch takes the rig at run time, by its `set_geometry`.
    """

    core: str
    stepping: str
    private_fields: str
    bytes: int
    types: str = ""
    rig_at_run_time: bool = False
    supervised: bool = False
    scaled: bool = False


def render(template_name: str, terms: Mapping[str, Any]) -> str:
    """The text of a template of this package; a term that is missing is an error."""
    return ENVIRONMENT.get_template(template_name).render(terms)
