"""How well free vibrations determine k and b_t, whether contacts agree, and what would help.

A wrong a or e distorts the stiffness of [Györök 2022], (5.7), differently for long and short contacts.
A wrong J_A distorts only the contacts that it belongs to. Every recording may then fit well and
every interval be narrow while k is off by percents; but the contacts, each for itself, give different k.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from scipy.special import fdtrc

from identification.free_decay.likelihood import Likelihood
from identification.free_decay.noise_continuation import jackknife_covariance, maximise_likelihood
from identification.free_decay.results import ContactPatchResult, IdentifiedParameter
from identification.free_decay.vibration_detection import (
    MIN_DEFLECTION_STEPS,
    ContactGeometry,
    FreeVibration,
    without_spikes,
)
from identification.free_decay.vibration_model import rotational_stiffness
from symbolic.rig_and_tyre import USUAL

GOOD = (0.003, 0.02)
"""Half-widths of the 95 % intervals of k and b_t, as shares of the values, that need no remedy [1]."""
_RIVAL = 0.3
"""A later deflection of this share of the first is another impact [1]."""
_ROUGH = 0.5
"""Noise of more than this many steps of the encoder is reported."""
_STRANGE = 3.0
"""A k that differs from the declared one by more than this factor is reported."""
_SIGNIFICANCE = 1e-3
"""Probability that contacts with the same k are found to disagree [1]."""


@dataclass(frozen=True, kw_only=True)
class StiffnessOfOneContact:
    """k from the recordings of one contact alone, and the degrees of freedom of its deviation."""

    k: float
    std: float
    degrees_of_freedom: int


def stiffness_by_contact_geometry(
    likelihood: Likelihood,
) -> dict[ContactGeometry, StiffnessOfOneContact]:
    """The k of every contact that determines it alone; empty where there is only one contact."""
    contacts = likelihood.contacts if len(likelihood.contacts) > 1 else ()
    found = ((contact, _stiffness_of(likelihood, contact)) for contact in contacts)
    return {contact: stiffness for contact, stiffness in found if stiffness is not None}


def stiffnesses_agree(stiffnesses: Collection[StiffnessOfOneContact]) -> bool | None:
    """Whether values of k differ by no more than chance allows; None for fewer than two."""
    if len(stiffnesses) < 2:
        return None
    k, std = (np.array([getattr(one, name) for one in stiffnesses]) for name in ("k", "std"))
    mean = np.average(k, weights=std**-2)
    scatter = float((((k - mean) / std) ** 2).sum()) / (k.size - 1)
    # The variances are estimates themselves; the least certain one bounds the freedom of all.
    degrees_of_freedom = min(one.degrees_of_freedom for one in stiffnesses)
    return bool(fdtrc(k.size - 1, degrees_of_freedom, scatter) > _SIGNIFICANCE)


def _stiffness_of(likelihood: Likelihood, contact: ContactGeometry) -> StiffnessOfOneContact | None:
    part = Likelihood([r for r in likelihood.vibrations if r.contact == contact])
    try:
        solution = maximise_likelihood(part)
        uncertainty = jackknife_covariance(part, solution)
    except np.linalg.LinAlgError:
        return None
    k, std = np.array([solution.x[0], np.sqrt(uncertainty.covariance[0, 0])]) * part.scales[0]
    freedom = uncertainty.degrees_of_freedom
    found = StiffnessOfOneContact(k=float(k), std=float(std), degrees_of_freedom=freedom)
    return found if solution.converged else None


def describe_identifiability(
    likelihood: Likelihood,
    k: IdentifiedParameter,
    b_t: IdentifiedParameter,
    contacts: Sequence[ContactPatchResult],
    agreed: bool | None,
    noise: float,
    of_lengths: float,
) -> tuple[str, ...]:
    """Sentences on how well k and b_t are known, on what they rest, and what would help.

    k is as if lengths were exact; by their tolerances it is off by `of_lengths`, a share of it.
    """
    vibrations = likelihood.vibrations
    count, lengths = len(vibrations), len({r.decay.rig.a for r in vibrations})
    sentences = [
        f"{count} recording{'s' * (count != 1)} at {lengths} contact length{'s' * (lengths != 1)} tell k"
        f" to {100 * _relative_half_width(k):.2g} % and b_t to"
        f" {100 * _relative_half_width(b_t):.2g} % (95 %).",
        _assumption_sensitivity_text(vibrations, k, of_lengths),
    ]
    if agreed is False:
        sentences.append(_least_and_greatest_k(contacts, k.value))
    if lengths == 1:
        sentences.append(
            "All recordings have one contact length; several would show whether a and e are right."
        )
    untold = [f"{1000 * contact.a:g}" for contact in contacts if contact.force is None]
    if untold:
        sentences.append(
            f"The sliding at the ends of the patch is not told from none at a = {', '.join(untold)} mm,"
            " and k and b_t bear what it may be; stronger impacts slide further."
        )
    if any(_relative_half_width(p) > good for p, good in zip((k, b_t), GOOD, strict=True)):
        sentences.append(
            "More impacts would help, and stronger ones more: they last longer above the noise."
        )
    step = float(np.median([r.step for r in vibrations]))
    if noise > _ROUGH * step:
        sentences.append(
            f"Readings scatter about the fit by {noise * np.pi / np.sqrt(3):.2g} rad, beyond the"
            f" encoder's step of {step:.2g} rad; look whether the residuals are noise."
        )
    # A k of another order than declared, as wrong units make it.
    declared = float(np.median([r.decay.tyre.k for r in vibrations]))
    if not 1 / _STRANGE < k.value / declared < _STRANGE:
        sentences.append(
            f"k is {k.value / declared:.2g} times the {declared:.3g} N/m^2 declared; unless that was a"
            " wild guess, check J_A [kg m^2], a and e [m] and t [s]."
        )
    return (*sentences, *_later_impacts(vibrations))


def _relative_half_width(parameter: IdentifiedParameter) -> float:
    """Half-width of the interval over the value."""
    return (parameter.interval[1] - parameter.interval[0]) / 2 / abs(parameter.value)


def _assumption_sensitivity_text(
    vibrations: Sequence[FreeVibration], k: IdentifiedParameter, of_lengths: float
) -> str:
    """Change of k with a, e and J_A, from the derivatives of [Györök 2022], (5.7)."""
    a, e = ca.SX.sym("a"), ca.SX.sym("e")
    by = ca.Function(
        "by", [a, e], [ca.gradient(ca.log(rotational_stiffness(k.value, a, e)), ca.vertcat(a, e))]
    )
    slopes = np.array([by(r.decay.rig.a, r.decay.rig.e).full().ravel() for r in vibrations])
    lengths = np.array([r.decay.rig.a for r in vibrations])
    by_a, by_e = float(np.mean(slopes[:, 0] * lengths)), float(np.mean(slopes[:, 1]))
    return (
        "They rest on a, e and J_A as given: 1 % more J_A is 1 % more k and b_t, which no free vibration"
        f" shows, 1 % more a is {abs(by_a):.2g} % less k, 1 mm more e is {abs(0.1 * by_e):.2g} %"
        f" {'less' if by_e >= 0 else 'more'} k. Of the ± of k, tolerances of a and e"
        f" ({1000 * USUAL['a']:g} mm unless stated) make {100 * of_lengths:.2g} %, the recordings"
        f" {100 * k.std / k.value:.2g} %; the squares add up."
    )


def _least_and_greatest_k(contacts: Sequence[ContactPatchResult], k: float) -> str:
    """Least and greatest k, one contact at a time."""
    stiffnesses = sorted((c.k.value, c.a) for c in contacts if c.k is not None)
    (least, short), (most, long) = stiffnesses[0], stiffnesses[-1]
    return (
        f"One contact at a time, k runs from {100 * (least / k - 1):+.2g} % (a = {1000 * short:g} mm) to"
        f" {100 * (most / k - 1):+.2g} % (a = {1000 * long:g} mm) of this value, more than chance"
        " allows: a, e or J_A is not what it is said to be, of which the intervals cover the tolerances"
        " of a and e alone."
    )


def _later_impacts(vibrations: Sequence[FreeVibration]) -> list[str]:
    """Recordings with another impact after the vibration that was used."""
    sentences = []
    for r in vibrations:
        rest = np.abs(without_spikes(r.decay.psi)[r.last :] - r.centre)
        if rest.size and rest.max() > max(
            _RIVAL * abs(r.first_deflection), MIN_DEFLECTION_STEPS * r.step
        ):
            at = float(r.decay.t[r.last + int(np.argmax(rest))])
            sentences.append(
                f"{r.decay.name} goes on with another deflection at t = {at:.3g} s; only the vibration"
                f" from t = {r.t[0]:.3g} s on was used."
            )
    return sentences
