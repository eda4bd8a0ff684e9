"""k and b_t from free vibrations, by maximum likelihood over all recordings."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.special import ndtri, stdtrit

from identification.fits.values_by_ground_and_recording import ParameterEstimate
from identification.free_decay.identifiability import (
    StiffnessOfOneContact,
    describe_identifiability,
    stiffness_by_contact_geometry,
    stiffnesses_agree,
)
from identification.free_decay.likelihood import COMMON, Likelihood
from identification.free_decay.noise_continuation import jackknife_covariance, maximise_likelihood
from identification.free_decay.recording import Decay
from identification.free_decay.results import (
    ContactPatchResult,
    FreeDecay,
    IdentifiedParameter,
    VibrationFit,
)
from identification.free_decay.vibration_detection import ContactGeometry, FreeVibration, find_vibration
from identification.free_decay.vibration_model import VibrationTrajectory, rotational_stiffness
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.rig_and_tyre import relative_std_by_lengths

UNITS = ("N/m^2", "N m s/rad")
_CONFIDENCE = 0.95
_SIGNIFICANT = 2.0
"""Standard deviations of its slip from zero from which on a friction force is reported."""
_DETUNED = 1.3
"""Largest ratio of a recording's frequency and that of its sticking patch, which sliding lowers [1]."""
_REMEDY = (
    "check that every recording holds one impact and the vibration after it, and that a, e and J_A are"
    " its own, or leave out those that do not"
)


def identify_free_decay(decays: Sequence[Decay], *, sliding: bool = True) -> FreeDecay:
    """Find k and b_t with their standard deviations, that of k with what a and e may be off.

    Args:
        decays: recordings of free vibrations, at one contact length or at several.
        sliding: whether the outermost bristles slide, as friction requires; False makes the patch the
            linear spring of [Györök 2022], (5.6). It is off by percents wherever a swing exceeds the
            encoder's step: sliding softens the spring and dissipates energy.

    Raises:
        InvalidInputError: there is no recording, nothing vibrates in one of them, or they do not
            determine k and b_t.
    """
    if not decays:
        raise InvalidInputError("no recording of a free vibration; at least one is needed")
    likelihood = Likelihood([find_vibration(decay) for decay in decays], sliding=sliding)
    try:
        solution = maximise_likelihood(likelihood)
        uncertainty = jackknife_covariance(likelihood, solution)
    except np.linalg.LinAlgError:
        raise InvalidInputError(f"these recordings do not tell k and b_t at all: {_REMEDY}") from None
    values = solution.x * likelihood.scales
    responses = tuple(zip(likelihood.vibrations, solution.evaluation.responses, strict=True))
    for vibration, response in responses:
        _check_follows_fit(vibration, response, values[0])
    scales = likelihood.scales[: likelihood.shared]
    size = np.sqrt(np.diag(uncertainty.information))
    covariance = uncertainty.covariance * np.outer(scales, scales)
    quantile = float(stdtrit(uncertainty.degrees_of_freedom, (1 + _CONFIDENCE) / 2))
    k, b_t = (
        _parameter(float(values[i]), float(covariance[i, i]), quantile, UNITS[i]) for i in range(COMMON)
    )
    lengths = float(
        np.mean([relative_std_by_lengths(partial(rotational_stiffness, 1.0), d.rig) for d in decays])
    )
    stiffnesses = stiffness_by_contact_geometry(likelihood)
    agreed = stiffnesses_agree(stiffnesses.values())
    contacts = _force_and_k_by_contact(likelihood.contacts, values, covariance, stiffnesses)
    covariance[0, 0] += (lengths * k.value) ** 2
    return FreeDecay(
        k=_add_length_uncertainty(k, lengths),
        b_t=b_t,
        covariance=covariance[:COMMON, :COMMON],
        contacts=contacts,
        contacts_agree=agreed,
        noise=solution.noise,
        # Of the information, every unknown in its own unit of information.
        condition=float(np.linalg.cond(uncertainty.information / np.outer(size, size))),
        identifiability=describe_identifiability(
            likelihood, k, b_t, contacts, agreed, solution.noise, lengths
        ),
        vibrations=tuple(
            _vibration_fit(vibration, response, values[likelihood.columns(i)])
            for i, (vibration, response) in enumerate(responses)
        ),
        converged=solution.converged,
        status=f"{'solved' if solution.converged else 'not solved'} in {solution.steps} steps",
        remedy="" if solution.converged else _REMEDY,
    )


def _parameter(value: float, variance: float, quantile: float, unit: str) -> IdentifiedParameter:
    std = float(np.sqrt(variance))
    interval = (value - quantile * std, value + quantile * std)
    return IdentifiedParameter(value=value, std=std, interval=interval, unit=unit)


def _add_length_uncertainty(k: IdentifiedParameter, lengths: float) -> IdentifiedParameter:
    """The stiffness with what lengths may be off, a deviation as a share of it, added in quadrature."""
    std = lengths * k.value
    half = float(np.hypot(k.interval[1] - k.value, ndtri((1 + _CONFIDENCE) / 2) * std))
    return replace(k, std=float(np.hypot(k.std, std)), interval=(k.value - half, k.value + half))


def _natural_frequency(vibration: FreeVibration, k: float) -> float:
    """That of the sticking patch without damping [rad/s]."""
    return float(np.sqrt(rotational_stiffness(k, *vibration.contact) / vibration.decay.inertia))


def _check_follows_fit(vibration: FreeVibration, response: VibrationTrajectory, k: float) -> None:
    """Check that a recording follows the fitted vibration roughly."""
    name, omega = vibration.decay.name, _natural_frequency(vibration, k)
    if not 1 / _DETUNED < vibration.omega / omega < _DETUNED:
        raise InvalidInputError(
            f"{name}: psi swings at {vibration.omega:.3g} rad/s, where its a, e and J_A with the"
            f" k of all recordings make {omega:.3g} rad/s: {_REMEDY}"
        )
    # Wrong readings count as no more than a swing.
    residual = np.minimum(np.abs(vibration.psi - response.psi), abs(vibration.first_deflection))
    if not np.mean(residual**2) < np.var(response.psi):
        raise InvalidInputError(f"{name}: psi does not follow the vibration that was fitted: {_REMEDY}")


def _force_and_k_by_contact(
    contacts: Sequence[ContactGeometry],
    values: Array,
    covariance: Array,
    stiffnesses: Mapping[ContactGeometry, StiffnessOfOneContact],
) -> tuple[ContactPatchResult, ...]:
    """Friction force of every contact, where its slip 1/(mu F_N) differs from zero, and its k."""
    results = []
    for i, (a, e) in enumerate(contacts, start=COMMON):
        slip, std = float(values[i]), float(np.sqrt(covariance[i, i]))
        force = k = None
        if slip > _SIGNIFICANT * std:
            force = ParameterEstimate(value=1 / slip, std=std / slip**2, unit="N")
        if alone := stiffnesses.get((a, e)):
            k = ParameterEstimate(value=alone.k, std=alone.std, unit=UNITS[0])
        results.append(ContactPatchResult(a=a, e=e, force=force, k=k))
    return tuple(results)


def _vibration_fit(
    vibration: FreeVibration, response: VibrationTrajectory, values: Array
) -> VibrationFit:
    """A recording beside its fit, with k, b_t and its own unknowns as in `Likelihood.columns`."""
    k, b_t, centre = values[[0, 1, -1]].tolist()
    omega_n = _natural_frequency(vibration, k)
    return VibrationFit(
        name=vibration.decay.name,
        a=vibration.decay.rig.a,
        t=vibration.t,
        psi=vibration.psi,
        fitted=response.psi,
        centre=centre,
        step=vibration.step,
        sticking=(omega_n, b_t / (2 * vibration.decay.inertia * omega_n)),
    )
