"""What an effect of the library does, and how much, for somebody who knows no tyre model."""

from collections.abc import Callable, Mapping, Sequence
from math import degrees

import numpy as np

from identification import Diagnosis, FoundEffect
from symbolic.effects.asymmetric_friction import ASYMMETRY_RATIO, weaker_share_below_mean

OVER_SPEED = "friction over speed"
MECHANISMS = {
    OVER_SPEED: "friction changes with the speed of sliding",
    "friction over time": "friction changes with time or with the angle turned",
    "friction over load": "friction changes with the load",
    "friction over direction": "friction differs by the direction of turning",
    "contact over load": "the length of the contact follows the load",
    "compliance and contact shape": "the tyre's body yields, or its pressure is spread otherwise",
    "sensor and steering": "sensor and steering add to the torque",
}
"""What a model without a mechanism leaves out, for somebody who knows no tyre model."""
STRAIGHT = 0.15
"""Distance of a curve from a line over its change, up to which it is told by its slope [1]."""
MORE_LOAD = 1.1
"""Ratio of loads for which it is told what a law of load does [1]."""
PLAIN = {"backlash": "the linkage between angle sensor and tyre has play"}
"""What an effect does where its summary takes a modeller to read."""


def effect_summary(diagnosis: Diagnosis, effect: FoundEffect) -> str:
    """What an effect does: friction over speed by its curve, others by the library, with their size."""
    if effect.family == OVER_SPEED:
        alone = sum(one.family == OVER_SPEED for one in diagnosis.effects) == 1
        by_c = "(2.3 c μ) for each" if alone and "c" in effect.parameters else "for each"
        return friction_over_speed(diagnosis).replace("for each", by_c)
    summary = PLAIN.get(effect.name, effect.summary)
    if size := effect_size_text(effect):
        summary = f"{summary}: {size}"
    ratios = [one for name, one in effect.parameters.items() if name.partition(" [")[0] == "ratio"]
    if effect.name == "asymmetric_friction" and len(ratios) == 1:
        # Of friction at rising over that at falling angle.
        ratio = ratios[0].value
        less = weaker_share_below_mean({ASYMMETRY_RATIO: ratio})
        way, back = ("rises", "falls")[:: 1 if ratio < 1 else -1]
        summary += f", lower while the angle {way} than while it {back}"
        summary += f" ({100 * less:.0f} % below the mean of both)"
    return f"{'looks like: ' * (effect.grade == 'stands_in')}{summary}"


def friction_over_speed(diagnosis: Diagnosis) -> str:
    """Which way and how much friction changes with speed by the fitted curve, as far as it is simple."""
    curve = next((f.curve for f in diagnosis.families if f.name == OVER_SPEED), None)
    if curve is None or not (curve.y > 0).all():
        return MECHANISMS[OVER_SPEED]
    steps, change = np.diff(curve.y), curve.y[-1] - curve.y[0]
    if not change or (steps * change < 0).any():
        return MECHANISMS[OVER_SPEED]
    verb, decades = "rises" if change > 0 else "falls", np.log10(curve.x / curve.x[0])
    where = f" from {1e3 * curve.x[0]:.2g} to {1e3 * curve.x[-1]:.2g} mm/s, in a typical recording"
    line = curve.y[0] + change * decades / decades[-1]
    if np.abs(curve.y - line).max() > STRAIGHT * abs(change):
        return f"friction {verb} with the speed of sliding{where}"
    slope = abs(change) / decades[-1]
    size = f"{slope:.2f}" if slope >= 0.005 else "less than 0.01"
    return f"friction {verb} by {size} for each tenfold sliding speed{where}"


def effect_size_text(effect: FoundEffect) -> str:
    """How much an effect does, in units that somebody at the rig knows; empty where that is not told."""
    template, figures = _SIZES.get(effect.name, ("", ()))
    values: dict[str, list[float]] = {}
    for label, estimate in effect.parameters.items():
        values.setdefault(label.partition(" [")[0], []).append(estimate.value)
    if not template or any(not np.isfinite(values.get(name, [np.nan])).all() for name, _ in figures):
        return ""
    told = []
    for name, convert in figures:
        span = sorted(convert(value) for value in values[name])
        told.append(" to ".join(dict.fromkeys(_two_digits(value) for value in (span[0], span[-1]))))
    return template.format(*told)


def _two_digits(value: float) -> str:
    """Two significant digits."""
    text = f"{value:.0f}" if abs(value) >= 100 else f"{float(f'{value:.2g}'):g}"
    return text.replace("-", "−")


def _percent_at_more_load(power: float) -> float:
    """Change of what goes with a power of the load, at `MORE_LOAD` [%]."""
    return 100 * (float(MORE_LOAD**power) - 1)


def _per_degree(of_radian: float) -> float:
    return of_radian / degrees(1)


def _degrees_per_torque(stiffness: float) -> float:
    """Angle for a torque of 1 [degree]."""
    return degrees(1 / stiffness)


def _times(factor: float) -> Callable[[float], float]:
    return lambda value: factor * value


_Size = tuple[str, Sequence[tuple[str, Callable[[float], float]]]]
_PLAY: _Size = ("{}° or {} rad from end to end", [("gap", degrees), ("gap", _times(1))])
_TWIST: _Size = ("by {}° for each N m", [("k_t", _degrees_per_torque)])
_VISCOUS: _Size = ("{} N m at 1 rad/s (57°/s)", [("c", _times(1))])
_SPRING: _Size = ("{} N m for each degree", [("stiffness", _per_degree)])
_SIZES: Mapping[str, _Size] = {
    "backlash": _PLAY,
    "play_of_joints": _PLAY,
    "bearing_friction": ("{} N m", [("M_c", _times(1))]),
    "gear_friction": ("{} N m at one wheel", [("M_c", _times(1))]),
    "carcass_torsion": _TWIST,
    "compliance_of_steering": _TWIST,
    "contact_damping": _VISCOUS,
    "damping_of_joints": _VISCOUS,
    "steering_return": _SPRING,
    "jacking": _SPRING,
    "torque_offset": ("{} N m", [("M_0", _times(1))]),
    "zero_of_force": ("{} N m at one wheel", [("M_0", _times(1))]),
    "zero_drift": ("{} N m in a minute", [("rate", _times(60))]),
    "pretwist": ("by {}°", [("psi_0", degrees)]),
    "tared_pretwist": ("{}°", [("psi_0", degrees)]),
    "sensor_delay": ("by {} ms", [("delay", _times(1e3))]),
    "patch_width": ("{} mm", [("half_width", _times(2e3))]),
    "brakes_and_scrub": ("as if it were {} mm wide", [("half_width", _times(2e3))]),
    "pressure_shape": ("exponent {}, which is 2 of a parabola", [("exponent", _times(1))]),
    "pressure_skew": ("by {} % of the half-length", [("skew", lambda skew: 20 * abs(skew))]),
    "contact_length": ("10 % more load makes it {} % longer", [("n", _percent_at_more_load)]),
    "load_dependent_friction": (
        "10 % more load changes it by {} %", [("n", lambda n: _percent_at_more_load(-n))]
    ),
    "friction_drift": (
        "by {} % in the end, most of it within {}° of turning",
        [("gain", _times(100)), ("scale", degrees)],
    ),
    "viscoelastic_relaxation": (
        "{} % of a sudden stress goes within about {} s",
        [("gain", lambda gain: 100 * gain / (1 + gain)), ("time", _times(1))],
    ),
}  # fmt: skip
"""Size of effects by their names; that of friction over speed and direction stands in `effect_summary`.

A skewed parabola has its centre at a fifth of its skew.
"""
