"""A parameter's value as results state it."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ParameterEstimate:
    """A parameter's value with its standard deviation and unit; std is None where it was not fitted."""

    value: float
    std: float | None
    unit: str
