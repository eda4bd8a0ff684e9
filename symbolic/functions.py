"""CasADi Functions whose inputs and outputs are all named."""

from collections.abc import Mapping
from typing import Any

import casadi as ca


def named_function(
    name: str, inputs: Mapping[str, Any], outputs: Mapping[str, Any], **options: Any
) -> ca.Function:
    """A Function from symbols to expressions, each under its name; options are CasADi's."""
    return ca.Function(name, [*inputs.values()], [*outputs.values()], [*inputs], [*outputs], options)
