"""Parameter values: of the tyre, of each ground, of each recording, and of each recording's rig."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from identification.fits.options import OwnerAndName
from identification.reading.car_torques_beside_tyres import declared_vehicle_torques
from identification.reading.recordings import Recording
from symbolic import (
    TOLERATED,
    InvalidInputError,
    Model,
    Parameter,
    Tolerances,
    full_slide_torque,
    parameter_name,
)
from symbolic.tables.found_model import mean_over_grounds

UPPER_QUANTILE = 0.98
"""Quantile of the torque's size from which the first guess of mu is taken: spikes are above it."""
AT_RANGE, START_ABOVE_RANGE, USUAL_FRICTION = 0.8, 1.2, 1.0
"""That quantile over the torque left out, beyond which it is at the range of its sensor [1]; first guess
of mu over that of this torque then, and its least [1]."""
UNNAMED_GROUND = "unnamed ground"
"""The ground of recordings that name none."""


@dataclass(frozen=True, kw_only=True)
class ParameterEstimate:
    """A parameter's value with its standard deviation and unit; std is None where it was not fitted."""

    value: float
    std: float | None
    unit: str


@dataclass(frozen=True, kw_only=True)
class Values:
    """Parameter values by name (`mu`, `k`, `effect.parameter`), physical units.

    Attributes:
        tyre: values that hold in all recordings.
        own: for each recording name, the values that are its own.
        grounds: for each ground, the values that belong to it.
        rig: for each recording name, its `a`, `e` [m], factor `load` [1], `zero` [N m] and shares of
            the torques that a vehicle declares [1], where these were declared with a tolerance.
    """

    tyre: Mapping[str, float]
    own: Mapping[str, Mapping[str, float]]
    grounds: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    rig: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def of(self, recording: Recording) -> dict[str, float]:
        """All values of the model's parameters that hold for one recording."""
        ground = self.grounds.get(ground_of(recording), {})
        return {**self.tyre, **ground, **self.own[recording.name]}

    def at(self, label: OwnerAndName) -> float:
        """The value of a column of a fit."""
        owner, name = label
        if owner is None:
            return self.tyre[name]
        if owner in self.grounds:
            return self.grounds[owner][name]
        return self.rig[owner][name] if name in self.rig.get(owner, {}) else self.own[owner][name]

    def having(self, changes: Mapping[OwnerAndName, float]) -> "Values":
        """These values with others for some columns of a fit."""
        tyre = dict(self.tyre)
        own, grounds, rig = (
            {owner: dict(values) for owner, values in place.items()}
            for place in (self.own, self.grounds, self.rig)
        )
        for (owner, name), value in changes.items():
            if owner is None:
                tyre[name] = value
            elif owner in grounds:
                grounds[owner][name] = value
            else:
                (rig if name in rig.get(owner, {}) else own)[owner][name] = value
        return Values(tyre=tyre, own=own, grounds=grounds, rig=rig)


def ground_of(recording: Recording) -> str:
    """The ground of a recording; `UNNAMED_GROUND` where it names none."""
    return recording.ground or UNNAMED_GROUND


def grounds_of(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """The grounds that these recordings stand on, each once.

    Raises:
        InvalidInputError: a ground has the name of a recording.
    """
    grounds = tuple(dict.fromkeys(ground_of(recording) for recording in recordings))
    names = {recording.name for recording in recordings}
    for ground in grounds:
        if ground in names:
            raise InvalidInputError(
                f"ground {ground!r} has the name of a recording, and results tell their values by it;"
                " give the ground another name (--ground NAME=REC, ground = NAME in the file), or rename"
                " the recording's file"
            )
    return grounds


def initial_guess(model: Model, recordings: Sequence[Recording]) -> Values:
    """The start of a fit: k as declared, mu from the largest torque, (3/8) mu F_N a.

    A torque that reaches the end of its sensor is no full slide: mu starts above it, from where the fit
    finds down, while from below it would settle at next to no friction.
    """
    own = {}
    for recording in recordings:
        slide = full_slide_torque(float(np.median(recording.F_N)), recording.rig.a)
        largest = float(np.nanquantile(np.abs(recording.M_z), UPPER_QUANTILE))
        mu = largest / slide
        if largest > AT_RANGE * recording.rig.sensor_torque_limit:
            mu = max(START_ABOVE_RANGE * mu, USUAL_FRICTION)
        own[recording.name] = {"mu": float(np.clip(mu, 0.05, 5.0))}
    k = float(np.exp(np.mean([np.log(recording.tyre.k) for recording in recordings])))
    return complete_values(model, Values(tyre={"k": k}, own=own), recordings)


def complete_values(model: Model, values: Values, recordings: Sequence[Recording]) -> Values:
    """The values, completed by those of every parameter of the model that they lack.

    A parameter that is never fitted takes the value that the recordings give, any other one its start. A
    ground without values gets the mean of those that have some, see `geometric_or_arithmetic_mean`; so
    does the tyre where a parameter does not belong to the grounds any more.
    """
    lengths, loads = [r.rig.a for r in recordings], [float(r.F_N.mean()) for r in recordings]
    fixed = {
        f"{effect.name}.{name}": value
        for effect in model.effects
        for name, value in effect.fixed_values(lengths, loads).items()
    }
    starts = {**fixed, **values.tyre, **mean_over_grounds(values.grounds)}
    tyre: dict[str, float] = {}
    grounds: dict[str, dict[str, float]] = {ground: {} for ground in grounds_of(recordings)}
    own = {name: dict(v) for name, v in values.own.items()}
    for recording in recordings:
        own.setdefault(recording.name, {})
    for effect, parameter in model.parameters:
        name = parameter_name(effect, parameter)
        if parameter.scope == "tyre":
            tyre[name] = values.tyre.get(name, starts.get(name, parameter.start))
        elif parameter.scope == "ground":
            for ground, place in grounds.items():
                known = values.grounds.get(ground, {})
                place[name] = known.get(name, starts.get(name, parameter.start))
        else:
            for place in own.values():
                place.setdefault(name, values.tyre.get(name, parameter.start))
    return Values(
        tyre=tyre,
        own=own,
        grounds={ground: place for ground, place in grounds.items() if place},
        rig={
            r.name: {
                n: float(np.clip(values.rig.get(r.name, {}).get(n, p.start), p.lower, p.upper))
                for n, p in parameters.items()
            }
            for r in recordings
            if (parameters := rig_parameters(r))
        },
    )


def rig_parameters(recording: Recording) -> dict[str, Parameter]:
    """Values that the recording's rig declares with a tolerance above 0, as parameters of its own.

    Each starts at the declared value and stays within its tolerance. The scale is the standard deviation
    of a value that may be anywhere within it.
    """
    rig = recording.rig
    declared = {"a": rig.a, "e": rig.e, "load": 1.0, "zero": 0.0}
    spans = {name: (value, rig.tolerances.tolerance_or_zero(name)) for name, value in declared.items()}
    spans |= {name: (1.0, one.tolerance) for name, one in declared_vehicle_torques(recording).items()}
    return {
        name: Parameter(
            name=name,
            unit=TOLERATED.get(name, "1"),
            neutral=None,
            start=value,
            lower=value - tolerance,
            upper=value + tolerance,
            scale=((value + tolerance) - (value - tolerance)) / 2 / 3**0.5,
            scope="recording",
        )
        for name, (value, tolerance) in spans.items()
        if tolerance > 0
    }


def replaced_rig(recording: Recording, values: Values) -> Recording:
    """The recording with half-length and caster as found, and with its load corrected."""
    found = values.rig.get(recording.name, {})
    if not found:
        return recording
    lengths = {name: found[name] for name in ("a", "e") if name in found}
    rig = replace(recording.rig, **lengths, tolerances=Tolerances())
    return replace(recording, rig=rig, F_N=recording.F_N * found.get("load", 1.0))
