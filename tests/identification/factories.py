"""Recordings, series and fits that several suites make."""

from collections.abc import Sequence

import numpy as np
from scipy.signal import lfilter

from identification import Decay, Fit, Recording, fit
from identification.selection.trial import fit_recording_parameters
from reference_rig import Campaign, make_campaign
from rig_recordings import as_read
from symbolic import Rig, Tolerances, Tyre


def read_campaign(
    name: str | None, seed: int, recordings: int = 2, duration: float = 10.0
) -> tuple[Campaign, list[Recording]]:
    """Recordings of the reference rig as they are read, with nominal parameters alone declared."""
    made = make_campaign(name, seed, recordings, duration=duration)
    return made, [as_read(recording, made.nominal) for recording in made.recordings]


def with_torque(recording: Recording, M_z: Sequence[float] | np.ndarray) -> Recording:
    return Recording(**{**vars(recording), "M_z": np.asarray(M_z, dtype=float)})


def recording(
    name: str = "one",
    ground: str | None = None,
    psi: np.ndarray | None = None,
    *,
    period: float = 0.01,
    load: float = 300.0,
    rig: Rig | None = None,
    k: float = 2e6,
    **tolerances: float,
) -> Recording:
    """A recording along these angles, or half a second of a sine; its torque is the negative angle."""
    psi = 0.1 * np.sin(np.arange(50) * 0.01) if psi is None else psi
    t = np.arange(psi.size) * period
    measured = {"t": t, "psi": psi, "psi_dot": np.gradient(psi, t), "M_z": -psi}
    measured["F_N"] = np.full(t.size, load)
    rig = rig or Rig(a=0.045, e=0.009, tolerances=Tolerances(**tolerances))
    return Recording(name=name, **measured, rig=rig, tyre=Tyre(k=k), ground=ground)


def decay(t: np.ndarray, psi: np.ndarray, rig: Rig | None = None) -> Decay:
    return Decay(name="run", t=t, psi=psi, rig=rig or Rig(a=0.045, e=0.009, J_A=0.15), tyre=Tyre(k=2e6))


def autoregressive(weights: Sequence[float], n: int, rng: np.random.Generator) -> np.ndarray:
    """A stationary autoregression of white noise of variance one."""
    return lfilter([1.0], weights, rng.standard_normal(n + 1500))[1500:]


def first_order(phi: float, n: int, rng: np.random.Generator) -> np.ndarray:
    """A stationary first-order autoregression of variance one."""
    return np.sqrt(1 - phi**2) * autoregressive([1.0, -phi], n, rng)


def positions(fitted: Fit) -> np.ndarray:
    """The values of a fit in the order of its labels."""
    return np.array([fitted.values.at(label) for label in fitted.labels])


def left_out_exactly(fitted: Fit, recordings: Sequence[Recording]) -> dict[str, np.ndarray]:
    """Residuals of each recording by a fit of the others, to which its own parameters are fitted."""
    residuals = {}
    for left_out in recordings:
        others = [other for other in recordings if other is not left_out]
        refitted = fit(fitted.model, others, fitted.values)
        residuals |= fit_recording_parameters(refitted, [left_out]).residuals
    return residuals
