"""What recordings of free vibrations tell about k and b_t, and what would help, in plain words."""

from collections.abc import Sequence

import casadi as ca
import numpy as np

from identification.free_decay.likelihood import Programme
from identification.free_decay.onset import LEAST_STEPS, Release, without_spikes
from identification.free_decay.results import ContactFound, Identified
from identification.free_decay.vibration import stiffness

GOOD = (0.003, 0.02)
"""Half-widths of the 95 % intervals of k and b_t, as shares of the values, that need no remedy [1]."""
_RIVAL = 0.3
"""A later deflection of this share of the first is another impact [1]."""
_ROUGH = 0.5
"""Noise that is more than this many steps of the encoder is worth a word."""
_STRANGE = 3.0
"""A k that is another one than declared by more than this factor is worth a word."""


def sentences(
    programme: Programme,
    k: Identified,
    b_t: Identified,
    contacts: Sequence[ContactFound],
    agreed: bool | None,
    noise: float,
) -> tuple[str, ...]:
    """How well k and b_t are known, what they rest on, and what would help."""
    releases = programme.releases
    said = [_known(releases, k, b_t), _given(releases, k.value)]
    if agreed is False:
        said.append(_apart(contacts, k.value))
    if len({r.decay.rig.a for r in releases}) == 1:
        said.append(
            "All recordings have one contact length; several would show whether a and e are right."
        )
    unseen = [f"{1000 * contact.a:g}" for contact in contacts if contact.force is None]
    if unseen:
        said.append(
            f"The sliding at the ends of the patch is not told from none at a = {', '.join(unseen)} mm,"
            " and k and b_t bear what it may be; stronger impacts slide further."
        )
    if any(_share(p) > good for p, good in zip((k, b_t), GOOD, strict=True)):
        said.append("More impacts would help, and stronger ones more: they last longer above the noise.")
    step = float(np.median([r.step for r in releases]))
    if noise > _ROUGH * step:
        said.append(
            f"Readings scatter about the fit by {noise * np.pi / np.sqrt(3):.2g} rad, beyond the"
            f" encoder's step of {step:.2g} rad; look whether the residuals are noise."
        )
    return (*said, *_strange(releases, k.value), *_rivals(releases))


def _share(parameter: Identified) -> float:
    """Half-width of the interval over the value."""
    return (parameter.interval[1] - parameter.interval[0]) / 2 / abs(parameter.value)


def _known(releases: Sequence[Release], k: Identified, b_t: Identified) -> str:
    lengths = len({r.decay.rig.a for r in releases})
    return (
        f"{_count(len(releases), 'recording')} at {_count(lengths, 'contact length')} tell k to"
        f" {100 * _share(k):.2g} % and b_t to {100 * _share(b_t):.2g} % (95 %)."
    )


def _given(releases: Sequence[Release], k: float) -> str:
    """By how much k moves with what is taken as known, from the derivatives of (5.7)."""
    a, e = ca.SX.sym("a"), ca.SX.sym("e")
    by = ca.Function("by", [a, e], [ca.gradient(ca.log(stiffness(k, a, e)), ca.vertcat(a, e))])
    slopes = np.array([by(r.decay.rig.a, r.decay.rig.e).full().ravel() for r in releases])
    lengths = np.array([r.decay.rig.a for r in releases])
    by_a, by_e = float(np.mean(slopes[:, 0] * lengths)), float(np.mean(slopes[:, 1]))
    return (
        "They rest on a, e and J_A as given: 1 % more J_A is 1 % more k and b_t, which no free vibration"
        f" shows, 1 % more a is {abs(by_a):.2g} % less k, 1 mm more e is {abs(0.1 * by_e):.2g} %"
        f" {_less(by_e)} k."
    )


def _apart(contacts: Sequence[ContactFound], k: float) -> str:
    """Where k is least and greatest, one contact at a time."""
    told = sorted((c.k.value, c.a) for c in contacts if c.k is not None)
    (least, short), (most, long) = told[0], told[-1]
    return (
        f"One contact at a time, k runs from {100 * (least / k - 1):+.2g} % (a = {1000 * short:g} mm) to"
        f" {100 * (most / k - 1):+.2g} % (a = {1000 * long:g} mm) of this value, more than chance"
        " allows: a, e or J_A is not what it is said to be, and the intervals do not cover that."
    )


def _strange(releases: Sequence[Release], k: float) -> list[str]:
    """A k of another order than declared, as wrong units make it."""
    declared = float(np.median([r.decay.tyre.k for r in releases]))
    if 1 / _STRANGE < k / declared < _STRANGE:
        return []
    return [
        f"k is {k / declared:.2g} times the {declared:.3g} N/m^2 declared; unless that was a wild guess,"
        " check J_A [kg m^2], a and e [m] and t [s]."
    ]


def _less(slope: float) -> str:
    return "less" if slope >= 0 else "more"


def _rivals(releases: Sequence[Release]) -> list[str]:
    """Recordings that go on with another impact after the vibration that was used."""
    said = []
    for r in releases:
        rest = np.abs(without_spikes(r.decay.psi)[r.last :] - r.centre)
        if rest.size and rest.max() > max(_RIVAL * abs(r.reach), LEAST_STEPS * r.step):
            at = float(r.decay.t[r.last + int(np.argmax(rest))])
            said.append(
                f"{r.decay.name} goes on with another deflection at t = {at:.3g} s; only the vibration"
                f" from t = {r.t[0]:.3g} s on was used."
            )
    return said


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"
