"""The axis of a profile: a parameter of the model, or a length of the rig."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from identification.fits.options import Label
from identification.fits.values import Values
from identification.reading.recordings import Recording
from symbolic import InvalidInputError, Model, Rig, units_of

AxisPoint = tuple[list[Recording], Values]
"""Recordings and parameters with a value of the axis in them."""


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
    def fixed_labels(self) -> tuple[Label, ...]:
        """Parameters that the fit has to leave alone."""
        return ((self.recording, self.name),)

    def name_and_unit(self, model: Model) -> tuple[str, str]:
        """Name and unit of the quantity."""
        units = units_of(model)
        if self.name not in units:
            raise InvalidInputError(f"unknown parameter {self.name!r}; the model has {', '.join(units)}")
        owner = f" [{self.recording}]" if self.recording else ""
        return f"{self.name}{owner}", units[self.name]

    def initial(self, values: Values) -> float:
        """The value that belongs to the start of the profile."""
        try:
            return values.at((self.recording, self.name))
        except KeyError:
            owner = "all recordings" if self.recording is None else repr(self.recording)
            raise InvalidInputError(f"{self.name} is no parameter of {owner}") from None

    def point(self, value: float, recordings: Sequence[Recording], values: Values) -> AxisPoint:
        """Recordings and parameters at a value."""
        return list(recordings), values.having({(self.recording, self.name): value})


@dataclass(frozen=True, kw_only=True)
class RigLength:
    """A length of the rig, changed in every recording alike.

    Attributes:
        name: what the value is.
        unit: its unit.
        neutral: the value that leaves the rig as declared.
        lengths_at: function of the rig and a value that gives the lengths changed, by name.
    """

    name: str
    unit: str
    neutral: float
    lengths_at: Callable[[Rig, float], dict[str, float]]
    fixed_labels: tuple[Label, ...] = ()

    def name_and_unit(self, _: Model) -> tuple[str, str]:
        """Name and unit of the quantity."""
        return self.name, self.unit

    def initial(self, _: Values) -> float:
        """The value of the rig as declared."""
        return self.neutral

    def point(self, value: float, recordings: Sequence[Recording], values: Values) -> AxisPoint:
        """Recordings with such a length, which then has no tolerance."""
        return [replace(r, rig=self._rig(r.rig, value)) for r in recordings], values

    def _rig(self, rig: Rig, value: float) -> Rig:
        lengths = self.lengths_at(rig, value)
        exact = replace(rig.tolerances, **dict.fromkeys(lengths, 0.0))
        return replace(rig, **lengths, tolerances=exact)


ProfileAxis = ModelParameter | RigLength
HALF_LENGTH = RigLength(
    name="a over a as declared", unit="1", neutral=1.0, lengths_at=lambda rig, x: {"a": rig.a * x}
)
"""The half-length of the patch, as a factor."""
CASTER = RigLength(
    name="e less e as declared", unit="m", neutral=0.0, lengths_at=lambda rig, x: {"e": rig.e + x}
)
"""The caster length, as a shift [m]."""
