"""Friction in words: a value with its band, an estimate in one line, why a sample is not usable."""

import math
from collections.abc import Mapping

import numpy as np

from brushgrip.wording.formatting import band_decimals
from observers import Estimates, Status
from observers.estimates import BAND_STDS
from observers.planning.uncertainty_budget import REST, SLOPE
from observers.protocol import UNCHECKED, uninformed_remedy
from observers.quality.when_usable import (
    last_ground_change_index,
    last_usable,
    on_previous_ground,
    steadily_usable_since,
    unexplained_samples,
)
from observers.tuning import OF_LENGTHS, OF_LOAD, OF_SCALE, OF_TUNING
from symbolic import Rig

SLIPPERY = 0.15
"""Friction below which dry friction and noise of a sensor matter [1]."""
OF_SENSOR = {
    "dry_friction": "dry friction counts as the ground's",
    "noise": "the noise assumed may hide what the model gets wrong",
}
"""What it means on slippery ground that a value of the sensor is not declared, by its name."""
MIN_REPORTED_SHARE = 0.01
"""Least share of the samples for which a suspicion, or a friction on its bound, is reported [1]."""
REASONS = {
    Status.SUSPECT: "an input looks wrong",
    Status.INCONSISTENT: "the model does not explain the torque",
    Status.BOUND: "μ is on its bound",
    Status.ACQUIRING: "it has not slid enough to tell",
    Status.RESET: "the ground has changed",
}
"""Why a sample is not usable, the gravest first; of others the remedy says it."""
OF_ZERO = "zero of the torque"
"""A cause of a band."""
OTHER_STIFFNESS = (
    "measure k otherwise than by this torque (brushgrip identify) and declare it with its tolerance, or"
    " check the torque's scale"
)
AXLE_LOAD = "axle load"
"""A cause of the band of a car."""
TYRES_OF_CAR = (
    "identify the tyres on ground of known friction (brushgrip identify --lock-to-lock), or check the"
    " force's scale"
)
NARROWED_BY = {
    SLOPE: OTHER_STIFFNESS,
    REST: "turn to and fro more often, or find what the model lacks (brushgrip diagnose)",
    OF_LENGTHS: "measure half-length a and caster e, and declare them with their tolerances",
    OF_LOAD: "weigh the load, and declare its tolerance ([rig] load = { tolerance = ... })",
    OF_SCALE: OTHER_STIFFNESS,
    OF_ZERO: "read the torque with the wheel lifted, and declare how far off its zero may"
    " be ([rig] zero = { tolerance = ... } N m)",
    OF_TUNING: "declare the tolerances of a, e and load, then --tune mu_floor=0",
    "dry friction": "declare that of the sensor's bearings ([sensor] dry_friction)",
    AXLE_LOAD: "weigh the axle, and declare front_axle_load with its tolerance: 5 % of load are 6 % of"
    " mu where half_length follows from it",
    "measured torque of full slide": "identify it (--lock-to-lock) where friction is known better",
    "half-length of the contact": "measure it on a print, and declare half_length with its tolerance",
}
"""What narrows a band, by the largest part of it."""
OF_CAR = {
    "declare the torque's noise ([sensor] noise), try --by-direction, or raise error of the tuning to"
    " 0.1: with more, friction is hardly acquired": "or declare a greater force_error or force_noise",
    "a, F_N and k": "front_axle_load, half_length and stiffness",
    **dict.fromkeys(("k, a, F_N", "k, a and F_N"), "front_axle_load, half_length and stiffness"),
    "then k": "then stiffness",
    "correct k": "correct stiffness",
    " (brushgrip identify)": "",
    "(brushgrip diagnose)": "(brushgrip diagnose --vehicle)",
}
"""What a remedy names, as a vehicle file calls it."""
LEAST_PART = 0.1
"""Share of a band below which a part of it is not told [1]."""


def with_95_band(value: float, std: float) -> str:
    """A friction coefficient with its 95 % band, to the hundredth, or the thousandth if narrow."""
    if not math.isfinite(value):
        return "–"
    if not math.isfinite(std):
        return f"{value:.2f}"
    half = BAND_STDS * std
    digits = band_decimals(half)
    return f"{value:.{digits}f} ± {half:.{digits}f}"


def band_composition_text(budget: Mapping[str, float]) -> str:
    """What a band is made of and what narrows it, in one line; empty where that is not known."""
    if not budget:
        return ""
    half = math.hypot(*budget.values())
    digits, largest = band_decimals(half), sorted(budget.items(), key=lambda part: -part[1])
    remedy = how_to_narrow_band(largest[0][0])
    if AXLE_LOAD in budget:
        remedy = TYRES_OF_CAR if remedy == OTHER_STIFFNESS else _with_option_names(remedy, of_car=True)
    parts = (f"{name} {part:.{digits}f}" for name, part in largest if part >= LEAST_PART * half)
    return (
        f"the band ± {half:.{digits}f} is made of (the squares add up): {', '.join(parts)};"
        f" to narrow it, {remedy}"
    )


def slippery_ground_note(mu: float, rig: Rig) -> str:
    """What an estimate on slippery ground rests on, in one line; empty on other ground."""
    lacking = {
        name: text for name, text in OF_SENSOR.items() if mu < SLIPPERY and getattr(rig, name) is None
    }
    if not lacking:
        return ""
    names = " and ".join(name.replace("_", " ") for name in lacking)
    keys = " and ".join(f"{name} = ..." for name in lacking)
    return (
        f"below {SLIPPERY:g}, {names} of the sensor not declared: {' and '.join(lacking.values())},"
        f" which matters there; measure with the wheel lifted, [sensor] {keys} N m"
    )


def how_to_narrow_band(cause: str) -> str:
    """What makes a part of a band smaller."""
    return NARROWED_BY.get(cause, f"measure the {cause}, and declare the tolerance")


WAYS = ("positive", "negative")
"""Directions of turning, by the sign of psi."""
LACKING = "find what the model lacks (brushgrip diagnose), then --model"
LACKING_STILL = "find what --model lacks (brushgrip diagnose with this recording too), else turn on"


def status_in_words(status: Status) -> str:
    """Why a sample is not usable, without the remedy; without a flag the deviation is why."""
    other = status.remedy.partition(":")[0] or "the deviation of mu is too large to act on"
    return next((text for flag, text in REASONS.items() if flag in status), other)


def estimates_summary(
    estimates: Estimates, unusable: tuple[int, str], rates: str = "", way: str = ""
) -> str:
    """Friction by the last usable sample, rejected ones, and the remedy of the most frequent fault.

    Args:
        estimates: of a recording.
        unusable: what `unusable_samples_and_remedy` says of them.
        rates: of torque and angle where they differ.
        way: one of `WAYS`, that of friction; empty where it is of no direction.
    """
    parts = [_last_friction(estimates, way)]
    if rejected := int(np.count_nonzero(estimates.status & Status.REJECTED)):
        parts.append(f"{rejected} {_plural(rejected, 'sample')} rejected")
    changes = int(np.count_nonzero(estimates.status & Status.RESET))
    known, before = last_usable(estimates) is not None, "" if way else friction_before_change(estimates)
    doubted, told = _is_change_doubtful(estimates), f"; before {ground_change_text(estimates)} {before}"
    if changes > 1 or (changes and (doubted or not (known and before))):
        of_model = " or misfits of the model" * doubted
        parts.append(f"{changes} {_plural(changes, 'change')} of the ground{of_model}")
    line, (number, why) = ", ".join(parts) + told * bool(known and before), unusable
    if why == UNCHECKED:
        return f"{line}; {why}"
    line += f"; {rates}" * bool(rates)
    why = why.replace(", try --by-direction" * bool(way), "")
    return f"{line}; {number} {_plural(number, 'sample')} not usable: {why}" if number else line


def unusable_samples_and_remedy(
    estimates: Estimates, noise: str = "", rates: str = "", cause: str = "", *, of_car: bool = False
) -> tuple[int, str]:
    """How many samples the gravest or most frequent fault kept from use, and its remedy.

    Args:
        estimates: of a recording.
        noise: what mends a torque that the model does not explain, before other remedies.
        rates: of torque and angle where they differ; a sample without a torque is then no fault.
        cause: of what looks wrong with an input, or why nothing is usable, in place of all that may.
        of_car: remedies name what a vehicle file declares.
    """
    if np.isnan(estimates.mu_std).all():
        return estimates.t.size, UNCHECKED
    counts = {flag: int(np.count_nonzero(estimates.status & flag)) for flag in Status if flag}
    # What ends in a new ground is of its change, which is told where friction is known on it.
    wrong = unexplained_samples(estimates)
    changing = (estimates.status & (Status.RESET | Status.INCONSISTENT) != 0) & ~wrong
    counts[Status.RESET] = int(changing.sum()) * (last_usable(estimates) is None)
    counts[Status.INCONSISTENT] = int(wrong.sum())
    if rates:
        counts[Status.MISSING] = 0
    if estimates.usable.any():
        # Friction is always acquired first.
        counts[Status.ACQUIRING] = 0
    for flag in (Status.SUSPECT, Status.BOUND):
        # The first small turns of a sound wheel may look like either.
        counts[flag] *= counts[flag] > MIN_REPORTED_SHARE * estimates.t.size
    if estimates.is_too_uncertain.mean() > 0.5 or not estimates.usable.any():
        counts[Status.USED] = int(estimates.is_too_uncertain.sum())
    # Whether the deviation can be believed goes before what happened to samples.
    first = [flag for flag in (Status.SUSPECT, Status.INCONSISTENT) if counts[flag]]
    flag = max(first or counts, key=lambda one: counts[one])
    if cause:
        return counts[flag], cause
    unexplained = counts[Status.INCONSISTENT] + counts[Status.REJECTED]
    mends = noise and not (flag is Status.SUSPECT and noise.startswith((LACKING, LACKING_STILL)))
    if mends and unexplained > MIN_REPORTED_SHARE * estimates.t.size:
        return counts[flag], _with_time_of_suspicion(estimates, f"{status_in_words(flag)}: {noise}")
    wide = estimates.is_too_uncertain if estimates.is_too_uncertain.any() else -1
    share = float(np.median((estimates.mu_std / estimates.mu)[wide]))
    told = _with_option_names(flag.remedy or uninformed_remedy(share), of_car=of_car)
    return counts[flag], _with_time_of_suspicion(estimates, told)


def _with_time_of_suspicion(estimates: Estimates, told: str) -> str:
    """When an input looked wrong, beside a friction that is told: before it, after it or both."""
    at, suspect = REASONS[Status.SUSPECT], estimates.t[estimates.status & Status.SUSPECT != 0]
    last = last_usable(estimates)
    if last is None or not told.startswith(at):
        return told
    sides = {"before": suspect[0] < estimates.t[last], "after": suspect[-1] > estimates.t[last]}
    side = " and ".join(name for name, there in sides.items() if there)
    when = f"{at} from {suspect[0]:.3g} to {suspect[-1]:.3g} s, {side} the value told"
    return told.replace(at, when + "," * told.startswith(f"{at} "), 1)


def _with_option_names(remedy: str, *, of_car: bool) -> str:
    """A remedy that names options where it names values of a tuning, and keys of a vehicle file."""
    for name, key in OF_CAR.items() if of_car else ():
        remedy = remedy.replace(name, key)
    remedy = remedy.replace("tuning to 0.1:", "tuning to 0.1 (--tune error=0.1):")
    return remedy.replace("noise of the tuning", "noise of the tuning (--tune noise=...)")


def _last_friction(estimates: Estimates, way: str) -> str:
    at = last_usable(estimates)
    measured = int(estimates.has_measured_torque.sum())
    share = f"in {100 * estimates.usable_share:.0f} % of {measured} samples"
    share += " with a torque" * (measured < estimates.t.size)
    if at is None:
        return f"{_unknown_friction_text(estimates, way)}, usable {share}"
    mu, std = float(estimates.mu_eff[at]), float(estimates.mu_eff_std[at])
    friction = f"mu_eff = {with_95_band(mu, std)} (95 % band)" + f" turning to {way} psi" * bool(way)
    where = "at the end" if at == estimates.t.size - 1 else f"at {estimates.t[at]:.4g} s, last usable"
    after = (estimates.status & Status.INCONSISTENT != 0)[at + 1 :]
    if after.sum() > MIN_REPORTED_SHARE * estimates.t.size:
        seconds = after.mean() * (estimates.t[-1] - estimates.t[at])
        where += f", then not explained for {seconds:.2g} s"
    since, gaps = steadily_usable_since(estimates)
    line = f"{friction} {where}, usable {'steadily ' * gaps}from {since:.3g} s, {share}"
    # On the declared model the two are the same.
    if abs(mu - estimates.mu[at]) > 5e-4:
        line += f" (mu = {estimates.mu[at]:.2f} in the model's own law, which compares with no other)"
    return line


def _unknown_friction_text(estimates: Estimates, way: str) -> str:
    """That friction is not known at the end, since when, and what it was before."""
    told, known = "friction is not known", np.flatnonzero(estimates.usable)
    if not known.size:
        return told
    begin = last_ground_change_index(estimates)
    if not begin:
        last = estimates.t[known[-1]]
        return f"{told}: what was usable up to {last:.4g} s does not explain the torque that follows"
    at_change = f"{estimates.t[begin]:.4g} s"
    either = f"{told} since {at_change}: either the ground changed, or the model does not fit"
    noticed = f"{told} since a new ground was noticed at {at_change}"
    told = either if _is_change_doubtful(estimates) else noticed
    before = "" if way else friction_before_change(estimates)
    return f"{told}; before, {before}" if before else told


def friction_before_change(estimates: Estimates) -> str:
    """What friction was before the last change of the ground; empty where it never changed."""
    if (before := on_previous_ground(estimates)) is None:
        return ""
    band = with_95_band(float(before.mu_eff[-1]), float(before.mu_eff_std[-1]))
    return f"it was {band} (usable from {steadily_usable_since(before)[0]:.3g} s)"


def ground_change_text(estimates: Estimates) -> str:
    """That the ground changed, and when last; empty where it never did."""
    if not (begin := last_ground_change_index(estimates)):
        return ""
    fits = " or the model ceased to fit" * _is_change_doubtful(estimates)
    return f"the ground changed{fits} at {estimates.t[begin]:.3g} s"


def _is_change_doubtful(estimates: Estimates) -> bool:
    """Whether the model fails to explain so many samples that a change of the ground is in doubt."""
    return bool(np.mean(unexplained_samples(estimates)) > MIN_REPORTED_SHARE)


def _plural(count: int, noun: str) -> str:
    return noun if count == 1 else f"{noun}s"
