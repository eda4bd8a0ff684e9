"""Parameters that a fit leaves at the end of their range."""

from collections.abc import Iterator

from identification.fits.fitting import Fit
from symbolic import parameter_name

AT_BOUND = 1e-3
"""A parameter is at a bound within this share of its scale [1]."""


def effects_at_bounds(fitted: Fit) -> Iterator[tuple[str, str]]:
    """Effects of which a shared parameter ends where its range does, and which one."""
    named = {parameter_name(effect, p): (effect, p) for effect, p in fitted.model.parameters if effect}
    for (owner, name), own in zip(fitted.labels, fitted.own, strict=True):
        if own or name not in named:
            continue
        effect, parameter = named[name]
        value = fitted.values.at((owner, name))
        unit = "" if parameter.unit == "1" else f" {parameter.unit}"
        ground = f" on {owner}" if owner else ""
        for end in (parameter.lower, parameter.upper):
            if end != parameter.neutral and abs(value - end) <= AT_BOUND * parameter.scale:
                yield (
                    effect.name,
                    f"{parameter.name}{ground} is at the end of its range, {end:g}{unit}",
                )


def ends_at_bound(fitted: Fit) -> bool:
    """Whether a shared parameter of the last effect is at the end of its range."""
    last = fitted.model.effects[-1].name if fitted.model.effects else None
    return any(effect == last for effect, _ in effects_at_bounds(fitted))
