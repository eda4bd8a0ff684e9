"""k and b_t from free vibrations, by one nonlinear programme over all recordings."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as students_t

from identification.free_decay.consistency import Alone, agree, each_alone
from identification.free_decay.identifiability import sentences
from identification.free_decay.jackknife import Spread, spread_of
from identification.free_decay.likelihood import COMMON, Programme, contact_of
from identification.free_decay.noise_continuation import Solution, solve
from identification.free_decay.onset import release
from identification.free_decay.recording import Decay
from identification.free_decay.results import ContactFound, FreeDecay, Identified, Vibration
from identification.free_decay.vibration import stiffness
from identification.parameter_estimate import ParameterEstimate
from identification.thesis.fft_decrement import source_way
from symbolic import InvalidInputError

Array = NDArray[np.float64]

UNITS = ("N/m^2", "N m s/rad")
_CONFIDENCE = 0.95
_TOLD = 2.0
"""A friction force is told from none when its slip is so many standard deviations from zero."""
_DETUNED = 1.3
"""Largest factor between the frequency a recording shows and its sticking patch's; sliding lowers it."""
_REMEDY = (
    "check that every recording holds one impact and the vibration after it, and that a, e and J_A are"
    " its own, or leave out those that do not"
)


def identify_free_decay(decays: Sequence[Decay], *, sliding: bool = True) -> FreeDecay:
    """Finds k and b_t with their standard deviations, and the source's values beside them.

    Args:
        decays: recordings of free vibrations, at one contact length or at several.
        sliding: whether the outermost bristles slide, as friction has it; False makes the patch the
            linear spring of the source (5.6), which is off by percents wherever a swing is worth a
            reading: sliding softens the spring and takes energy.

    Raises:
        InvalidInputError: there is no recording, in one of them nothing vibrates, or they tell nothing.
    """
    if not decays:
        raise InvalidInputError("no recording of a free vibration; at least one is needed")
    programme = Programme([release(decay) for decay in decays], sliding=sliding)
    try:
        solution = solve(programme)
        spread = spread_of(programme, solution)
    except np.linalg.LinAlgError:
        raise InvalidInputError(f"these recordings do not tell k and b_t at all: {_REMEDY}") from None
    _check_followed(programme, solution)
    scales = programme.scales[: programme.shared]
    covariance = spread.covariance * np.outer(scales, scales)
    k, b_t = (
        _identified(float(solution.x[i] * scales[i]), float(covariance[i, i]), spread, UNITS[i])
        for i in range(COMMON)
    )
    common = covariance[:COMMON, :COMMON]
    alone = each_alone(programme)
    contacts = _contacts(programme, solution, covariance, alone)
    agreed = agree(alone)
    return FreeDecay(
        k=k,
        b_t=b_t,
        covariance=common,
        correlation=float(common[0, 1] / (k.std * b_t.std)),
        contacts=contacts,
        contacts_agree=agreed,
        encoder_step=float(np.median([r.step for r in programme.releases])),
        noise=solution.noise,
        condition=_condition(spread.information),
        identifiability=sentences(programme, k, b_t, contacts, agreed, solution.noise),
        vibrations=_vibrations(programme, solution, k.value, b_t.value),
        converged=solution.converged,
        status=f"{'solved' if solution.converged else 'not solved'} in {solution.steps} steps",
        remedy="" if solution.converged else _REMEDY,
        source=source_way(programme.releases),
    )


def _identified(value: float, variance: float, spread: Spread, unit: str) -> Identified:
    std = float(np.sqrt(variance))
    reach = float(students_t.ppf((1 + _CONFIDENCE) / 2, spread.freedom)) * std
    return Identified(value=value, std=std, interval=(value - reach, value + reach), unit=unit)


def _check_followed(programme: Programme, solution: Solution) -> None:
    """Every recording has to vibrate as the programme has it, in rough outline at least."""
    k = float(solution.x[0] * programme.scales[0])
    for of, swing in zip(programme.releases, solution.look.swings, strict=True):
        omega = float(np.sqrt(stiffness(k, *contact_of(of)) / of.decay.inertia))
        if not 1 / _DETUNED < of.omega / omega < _DETUNED:
            raise InvalidInputError(
                f"{of.decay.name}: psi swings at {of.omega:.3g} rad/s, where its a, e and J_A with the"
                f" k of all recordings make {omega:.3g} rad/s: {_REMEDY}"
            )
        # Wrong readings count as no more than a swing.
        left = np.minimum(np.abs(of.psi - swing.psi), abs(of.reach))
        if not np.mean(left**2) < np.var(swing.psi):
            raise InvalidInputError(
                f"{of.decay.name}: psi does not follow the vibration that was fitted: {_REMEDY}"
            )


def _contacts(
    programme: Programme, solution: Solution, covariance: Array, alone: Sequence[Alone]
) -> tuple[ContactFound, ...]:
    """Of every contact the friction force, where its slip 1/(mu F_N) is told from zero, and its k."""
    by_contact = {
        one.contact: ParameterEstimate(value=one.k, std=one.std, unit=UNITS[0]) for one in alone
    }
    found = []
    for i, contact in enumerate(programme.contacts, start=COMMON):
        slip = float(solution.x[i] * programme.scales[i])
        std = float(np.sqrt(covariance[i, i]))
        told = slip > _TOLD * std
        force = ParameterEstimate(value=1 / slip, std=std / slip**2, unit="N") if told else None
        a, e = contact
        found.append(ContactFound(a=a, e=e, force=force, k=by_contact.get(contact)))
    return tuple(found)


def _condition(information: Array) -> float:
    """Condition number of the information, every unknown in its own unit of information."""
    size = np.sqrt(np.diag(information))
    return float(np.linalg.cond(information / np.outer(size, size)))


def _vibrations(programme: Programme, solution: Solution, k: float, b_t: float) -> tuple[Vibration, ...]:
    values = solution.x * programme.scales
    made = []
    for i, (of, swing) in enumerate(zip(programme.releases, solution.look.swings, strict=True)):
        centre = float(values[programme.columns(i)[-1]])
        residual = of.psi - swing.psi
        omega_n = float(np.sqrt(stiffness(k, *contact_of(of)) / of.decay.inertia))
        made.append(
            Vibration(
                name=of.decay.name,
                a=of.decay.rig.a,
                t=of.t,
                psi=of.psi,
                fitted=swing.psi,
                centre=centre,
                amplitude=float(abs(swing.psi[0] - centre)),
                rms=float(np.sqrt(np.mean(residual**2))),
                rounded=float(np.mean(np.abs(residual) <= of.step / 2)),
                sticking=(omega_n, b_t / (2 * of.decay.inertia * omega_n)),
            )
        )
    return tuple(made)
