"""k and b_t from free vibrations, by one nonlinear programme over all recordings."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as students_t

from identification.decayresults import ContactForce, FreeDecay, Identified, Vibration
from identification.decays import Decay
from identification.decaysource import source_way
from identification.identifiability import sentences
from identification.newton import Solution, solve
from identification.programme import COMMON, Programme, contact_of
from identification.release import release
from identification.results import Estimate
from identification.spread import Spread, spread_of
from identification.vibration import stiffness
from symbolic.errors import InvalidInputError

Array = NDArray[np.float64]

UNITS = ("N/m^2", "N m s/rad")
_CONFIDENCE = 0.95
_TOLD = 2.0
"""A friction force is told from none when its slip is so many standard deviations from zero."""
_REMEDY = (
    "check that every recording holds one impact and the vibration after it, and that a, e and J_A are"
    " its own; leave out the recording whose residual is largest"
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
    scales = programme.scales.shared
    covariance = spread.covariance * np.outer(scales, scales)
    k, b_t = (
        _identified(float(solution.x.shared[i] * scales[i]), float(covariance[i, i]), spread, UNITS[i])
        for i in range(COMMON)
    )
    common = covariance[:COMMON, :COMMON]
    forces = _forces(programme, solution, covariance)
    return FreeDecay(
        k=k,
        b_t=b_t,
        covariance=common,
        correlation=float(common[0, 1] / (k.std * b_t.std)),
        friction_forces=forces,
        encoder_step=float(np.median([r.step for r in programme.releases])),
        noise=solution.noise,
        condition=_condition(spread.information),
        identifiability=sentences(programme, k, b_t, forces, solution.noise),
        vibrations=_vibrations(programme, solution, k.value, b_t.value),
        converged=solution.converged,
        status=f"{'solved' if solution.converged else 'not solved'} in {solution.steps} Newton steps",
        remedy="" if solution.converged else _REMEDY,
        source=source_way(programme.releases),
    )


def _identified(value: float, variance: float, spread: Spread, unit: str) -> Identified:
    std = float(np.sqrt(variance))
    reach = float(students_t.ppf((1 + _CONFIDENCE) / 2, spread.freedom)) * std
    return Identified(value=value, std=std, interval=(value - reach, value + reach), unit=unit)


def _forces(programme: Programme, solution: Solution, covariance: Array) -> tuple[ContactForce, ...]:
    """The friction force mu F_N of every contact whose slip 1/(mu F_N) is told from zero."""
    forces = []
    for i, (a, e) in enumerate(programme.contacts, start=COMMON):
        slip = float(solution.x.shared[i] * programme.scales.shared[i])
        std = float(np.sqrt(covariance[i, i]))
        told = slip > _TOLD * std
        force = Estimate(value=1 / slip, std=std / slip**2, unit="N") if told else None
        forces.append(ContactForce(a=a, e=e, force=force))
    return tuple(forces)


def _condition(information: Array) -> float:
    """Condition number of the information, every unknown in its own unit of information."""
    size = np.sqrt(np.diag(information))
    return float(np.linalg.cond(information / np.outer(size, size)))


def _vibrations(programme: Programme, solution: Solution, k: float, b_t: float) -> tuple[Vibration, ...]:
    centres = solution.x.own[:, -1] * programme.scales.own[:, -1]
    made = []
    for of, swing, centre in zip(programme.releases, solution.look.swings, centres, strict=True):
        residual = of.psi - swing.psi
        omega_n = float(np.sqrt(stiffness(k, *contact_of(of)) / of.decay.inertia))
        made.append(
            Vibration(
                name=of.decay.name,
                a=of.decay.rig.a,
                t=of.t,
                psi=of.psi,
                fitted=swing.psi,
                centre=float(centre),
                amplitude=float(abs(swing.psi[0] - centre)),
                rms=float(np.sqrt(np.mean(residual**2))),
                rounded=float(np.mean(np.abs(residual) <= of.step / 2)),
                sticking=(omega_n, b_t / (2 * of.decay.inertia * omega_n)),
            )
        )
    return tuple(made)
