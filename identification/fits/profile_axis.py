"""What a profile holds along its grid: a parameter of the model, or a length of the rig."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from identification.fits.fitting import Label, Values
from identification.reading.recordings import Recording
from symbolic import InvalidInputError, Model, Rig, units_of

Placed = tuple[list[Recording], Values]


class Along(Protocol):
    """A value that can be put into recordings or parameters."""

    @property
    def held(self) -> tuple[Label, ...]:
        """Parameters that the fit has to leave alone."""
        ...

    def described(self, model: Model) -> tuple[str, str]:
        """Its name and unit."""
        ...

    def begin(self, values: Values) -> float:
        """The value before anything is held."""
        ...

    def placed(self, value: float, recordings: Sequence[Recording], values: Values) -> Placed:
        """Recordings and parameters with the value in them."""
        ...


@dataclass(frozen=True, kw_only=True)
class ModelParameter:
    """A parameter of the model.

    Attributes:
        name: `k`, `mu` or `effect.parameter`.
        recording: the recording that it belongs to; None for a shared one.

    Raises:
        InvalidInputError: when used with a model or recordings that do not have it.
    """

    name: str
    recording: str | None = None

    @property
    def held(self) -> tuple[Label, ...]:
        """See `Along`."""
        return ((self.recording, self.name),)

    def described(self, model: Model) -> tuple[str, str]:
        """See `Along`."""
        units = units_of(model)
        if self.name not in units:
            raise InvalidInputError(f"unknown parameter {self.name!r}; the model has {', '.join(units)}")
        owner = f" [{self.recording}]" if self.recording else ""
        return f"{self.name}{owner}", units[self.name]

    def begin(self, values: Values) -> float:
        """See `Along`."""
        place = values.shared if self.recording is None else values.own.get(self.recording, {})
        if self.name not in place:
            owner = "all recordings" if self.recording is None else repr(self.recording)
            raise InvalidInputError(f"{self.name} is no parameter of {owner}")
        return place[self.name]

    def placed(self, value: float, recordings: Sequence[Recording], values: Values) -> Placed:
        """See `Along`."""
        if self.recording is None:
            return list(recordings), replace(values, shared={**values.shared, self.name: value})
        own = {**values.own[self.recording], self.name: value}
        return list(recordings), replace(values, own={**values.own, self.recording: own})


@dataclass(frozen=True, kw_only=True)
class RigLength:
    """A length of the rig, changed in every recording alike.

    Attributes:
        name: what the value is.
        unit: its unit.
        neutral: the value that leaves the rig as declared.
        put: the rig with a value.
    """

    name: str
    unit: str
    neutral: float
    put: Callable[[Rig, float], Rig]

    @property
    def held(self) -> tuple[Label, ...]:
        """See `Along`; a length is no parameter of the fit."""
        return ()

    def described(self, model: Model) -> tuple[str, str]:
        """See `Along`."""
        del model
        return self.name, self.unit

    def begin(self, values: Values) -> float:
        """See `Along`."""
        del values
        return self.neutral

    def placed(self, value: float, recordings: Sequence[Recording], values: Values) -> Placed:
        """See `Along`."""
        return [replace(r, rig=self.put(r.rig, value)) for r in recordings], values


HALF_LENGTH = RigLength(
    name="a over a as declared", unit="1", neutral=1.0, put=lambda rig, x: replace(rig, a=rig.a * x)
)
"""The half-length of the patch, as a factor."""
CASTER = RigLength(
    name="e less e as declared", unit="m", neutral=0.0, put=lambda rig, x: replace(rig, e=rig.e + x)
)
"""The caster length, as a shift [m]."""
