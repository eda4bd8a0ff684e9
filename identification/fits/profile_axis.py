"""The axis of a profile: a parameter of the model, or a length of the rig."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from identification.fits.options import Label
from identification.fits.values import Values
from identification.reading.recordings import Recording
from symbolic import InvalidInputError, Model, Rig, units_of

AxisPoint = tuple[list[Recording], Values]
"""Recordings and parameters with a value of the axis in them."""


class ProfileAxis(Protocol):
    """A quantity that recordings or parameters can be given a value of."""

    @property
    def fixed(self) -> tuple[Label, ...]:
        """Parameters that the fit has to leave alone."""
        ...

    def name_and_unit(self, model: Model) -> tuple[str, str]:
        """Name and unit of the quantity."""
        ...

    def initial(self, values: Values) -> float:
        """The value that belongs to the start of the profile."""
        ...

    def point(self, value: float, recordings: Sequence[Recording], values: Values) -> AxisPoint:
        """Recordings and parameters at a value."""
        ...


@dataclass(frozen=True, kw_only=True)
class ModelParameter:
    """A parameter of the model.

    Attributes:
        name: `k`, `mu` or `effect.parameter`.
        recording: the recording, or the ground, that it belongs to; None for one of the tyre.

    Raises:
        InvalidInputError: when used with a model or recordings that do not have it.
    """

    name: str
    recording: str | None = None

    @property
    def fixed(self) -> tuple[Label, ...]:
        """See `ProfileAxis`."""
        return ((self.recording, self.name),)

    def name_and_unit(self, model: Model) -> tuple[str, str]:
        """See `ProfileAxis`."""
        units = units_of(model)
        if self.name not in units:
            raise InvalidInputError(f"unknown parameter {self.name!r}; the model has {', '.join(units)}")
        owner = f" [{self.recording}]" if self.recording else ""
        return f"{self.name}{owner}", units[self.name]

    def initial(self, values: Values) -> float:
        """See `ProfileAxis`."""
        try:
            return values.at((self.recording, self.name))
        except KeyError:
            owner = "all recordings" if self.recording is None else repr(self.recording)
            raise InvalidInputError(f"{self.name} is no parameter of {owner}") from None

    def point(self, value: float, recordings: Sequence[Recording], values: Values) -> AxisPoint:
        """See `ProfileAxis`."""
        return list(recordings), values.having({(self.recording, self.name): value})


@dataclass(frozen=True, kw_only=True)
class RigLength:
    """A length of the rig, changed in every recording alike.

    Attributes:
        name: what the value is.
        unit: its unit.
        neutral: the value that leaves the rig as declared.
        change: function of the rig and a value that gives the changed rig.
    """

    name: str
    unit: str
    neutral: float
    change: Callable[[Rig, float], Rig]

    @property
    def fixed(self) -> tuple[Label, ...]:
        """See `ProfileAxis`; a length is no parameter of the fit."""
        return ()

    def name_and_unit(self, model: Model) -> tuple[str, str]:
        """See `ProfileAxis`."""
        del model
        return self.name, self.unit

    def initial(self, values: Values) -> float:
        """See `ProfileAxis`."""
        del values
        return self.neutral

    def point(self, value: float, recordings: Sequence[Recording], values: Values) -> AxisPoint:
        """See `ProfileAxis`."""
        return [replace(r, rig=self.change(r.rig, value)) for r in recordings], values


def _exact(rig: Rig, **lengths: float) -> Rig:
    """The rig with these lengths, which then have no tolerance."""
    tolerances = replace(rig.tolerances, **dict.fromkeys(lengths, 0.0))
    return replace(rig, **lengths, tolerances=tolerances)


HALF_LENGTH = RigLength(
    name="a over a as declared", unit="1", neutral=1.0, change=lambda rig, x: _exact(rig, a=rig.a * x)
)
"""The half-length of the patch, as a factor."""
CASTER = RigLength(
    name="e less e as declared", unit="m", neutral=0.0, change=lambda rig, x: _exact(rig, e=rig.e + x)
)
"""The caster length, as a shift [m]."""
