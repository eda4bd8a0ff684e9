"""Values declared with a tolerance that recordings want otherwise: all alike, or one at its end."""

from collections.abc import Mapping, Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from identification.fits.fitting import AT_BOUND, Fit
from identification.fits.values_by_ground_and_recording import ParameterEstimate
from identification.reading.car_torques_beside_tyres import SHARES
from symbolic import TOLERATED

FEWEST_ALIKE = 3
"""Fewest recordings that together speak for a declared value that is wrong."""
AT_END, WANTED = "is at the end of its tolerance", "recordings want"
"""What the notes on declared values say."""


class _FittedDeclaredValue(NamedTuple):
    """What a recording wants in place of a declared value."""

    owner: str | None
    name: str
    value: float
    off: float  # From the declared value.
    std: float
    at_end: bool

    @property
    def declared(self) -> float:
        """The declared value; rounding leaves a zero one."""
        return round(self.value - self.off, 9) + 0.0


def notes_on_wrong_declared_values(
    fits: Sequence[Fit], estimates: Mapping[str, ParameterEstimate]
) -> list[str]:
    """Once what all recordings want, else each that a tolerance stops; `estimates` give deviations."""
    wanted = [one for fitted in fits for one in _fitted_declared_values(fitted, estimates)]
    count = len({name for fitted in fits for name in fitted.residuals})
    common = {}
    for name in dict.fromkeys(one.name for one in wanted):
        of_all = [one for one in wanted if one.name == name]
        # Shares of a car's torques are no values that anybody declares.
        if name in TOLERATED and len(of_all) == count >= FEWEST_ALIKE and _all_deviate_alike(of_all):
            common[name] = _common_deviation_note(of_all)
    ended = [one for one in wanted if one.at_end and one.name not in common]
    first = {one.name: one for one in reversed(ended)}
    single = [
        f"{one.owner}: {one.name}{_meaning(one.name) * (one is first[one.name])} {AT_END},"
        f" {one.value:g}{_unit(one.name)}"
        for one in ended
    ]
    return [*common.values(), *single]


def says_declared_value_is_off(note: str) -> bool:
    """Whether a note is one of these."""
    return AT_END in note or f" {WANTED} " in note


def _fitted_declared_values(
    fitted: Fit, estimates: Mapping[str, ParameterEstimate]
) -> list[_FittedDeclaredValue]:
    distances = np.abs(fitted.bound_distances).min(axis=0)
    columns = zip(
        fitted.labels, fitted.prior_weights, fitted.prior_steps * fitted.scales, distances, strict=True
    )
    return [
        _FittedDeclaredValue(
            owner=owner,
            name=name,
            value=fitted.values.at((owner, name)),
            off=float(off),
            std=one.std if (one := estimates.get(f"{name} [{owner}]")) and one.std is not None else inf,
            at_end=bool(distance <= AT_BOUND),
        )
        for (owner, name), weight, off, distance in columns
        if weight > 0
    ]


def _all_deviate_alike(wanted: Sequence[_FittedDeclaredValue]) -> bool:
    """Whether all are off one declared value the same way, each clearly, and agree on how far.

    The deviation of a recording that was left out of the fit does not count that of shared values.
    """
    off, std = np.array([(one.off, one.std) for one in wanted]).T
    one_declared = len({one.declared for one in wanted}) == 1
    one_way = len(set(np.sign(off))) == 1
    return bool(one_declared and one_way and (np.abs(off) > std).all() and np.ptp(off) <= 2 * std.max())


def _common_deviation_note(wanted: Sequence[_FittedDeclaredValue]) -> str:
    one, value = wanted[0], float(np.mean([each.value for each in wanted]))
    unit, than = _unit(one.name), "more" if one.off > 0 else "less"
    # The tolerance draws what is found to what is declared.
    return (
        f"all {len(wanted)} {WANTED} {one.name} {than} than the declared"
        f" {one.declared:g}{unit}, {value:.3g}{unit} or beyond: measure it"
    )


def _meaning(name: str) -> str:
    return f" ({SHARES[name]})" if name in SHARES else ""


def _unit(name: str) -> str:
    return f" {TOLERATED.get(name, '1')}".removesuffix(" 1")
