"""Results of an identification from free vibrations, and the dictionary for its file."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from identification.fits.values_by_ground_and_recording import ParameterEstimate
from symbolic.float_array_type import Array


@dataclass(frozen=True, kw_only=True)
class IdentifiedParameter:
    """An identified parameter with its standard deviation and 95 % confidence interval, in a unit."""

    value: float
    std: float
    interval: tuple[float, float]
    unit: str

    def to_dict(self) -> dict[str, Any]:
        """Its part of the result's file."""
        return {
            "value": self.value,
            "std": self.std,
            "interval_95": list(self.interval),
            "unit": self.unit,
        }


@dataclass(frozen=True, kw_only=True)
class ContactPatchResult:
    """Results of one contact."""

    a: float  # Half-length of the contact patch [m].
    e: float  # Caster length [m].
    # mu F_N from the sliding at the patch's ends [N]; None where that is not clearly above zero.
    force: ParameterEstimate | None
    # From this contact alone; None where it does not determine k, or there is no other contact.
    k: ParameterEstimate | None


@dataclass(frozen=True, kw_only=True, eq=False)
class VibrationFit:
    """One recording beside its fit; arrays of shape (n,), from the first turning point on.

    Attributes:
        name: the recording.
        a: half-length of the contact patch [m].
        t: time [s].
        psi: readings [rad].
        fitted: the fitted angle [rad].
        centre: angle about which the wheel swings [rad].
        step: of the encoder [rad].
        sticking: natural angular frequency [rad/s] and relative damping [1] with the identified k and
            b_t if no bristle slid, [Györök 2022], (5.7) and (5.8) with J_A.
    """

    name: str
    a: float
    t: Array
    psi: Array
    fitted: Array
    centre: float
    step: float
    sticking: tuple[float, float]

    @property
    def amplitude(self) -> float:
        """First deflection from the centre [rad]."""
        return float(abs(self.fitted[0] - self.centre))

    @property
    def rms(self) -> float:
        """Root mean square of reading minus fitted angle [rad]."""
        return float(np.sqrt(np.mean((self.psi - self.fitted) ** 2)))

    @property
    def share_of_readings_reproduced(self) -> float:
        """Share of the readings that are the fitted angle, rounded to the encoder's step [1]."""
        return float(np.mean(np.abs(self.psi - self.fitted) <= self.step / 2))

    def to_dict(self) -> dict[str, Any]:
        """Its part of the result's file."""
        return {
            "name": self.name,
            "a": self.a,
            "samples": self.t.size,
            "begin": float(self.t[0]),
            "end": float(self.t[-1]),
            "amplitude": self.amplitude,
            "residual_rms": self.rms,
            "readings_met": self.share_of_readings_reproduced,
            "omega_n": self.sticking[0],
            "zeta": self.sticking[1],
        }


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeDecay:
    """The whole result of `identify_free_decay`.

    Attributes:
        k: distributed lateral stiffness, with what a and e may be off in its deviation.
        b_t: torsional damping.
        covariance: of k and b_t, shape (2, 2) [N^2/m^4, N^2 s/(m rad), (N m s/rad)^2].
        contacts: every contact; none where the patch was assumed to stick.
        contacts_agree: whether their values of k agree; None where fewer than two determine it. Where
            they do not, the intervals cover of the fault what tolerances of a and e allow.
        noise: scale of the logistic noise besides the step [rad].
        condition: condition number of the information on k, b_t and the friction forces, each in units
            of its standard deviation if all others were known [1].
        identifiability: sentences: how well the recordings determine k and b_t, and what would help.
        vibrations: every recording.
        converged: whether the solver converged; otherwise the values are no result.
        status: how it ended.
        remedy: what to do where it did not converge, else empty.
    """

    k: IdentifiedParameter
    b_t: IdentifiedParameter
    covariance: Array
    contacts: tuple[ContactPatchResult, ...]
    contacts_agree: bool | None
    noise: float
    condition: float
    identifiability: tuple[str, ...]
    vibrations: tuple[VibrationFit, ...]
    converged: bool
    status: str
    remedy: str

    @property
    def correlation(self) -> float:
        """Correlation of k and b_t [1]."""
        return float(self.covariance[0, 1] / (self.k.std * self.b_t.std))

    @property
    def encoder_step(self) -> float:
        """Step of the yaw angle's encoder, the median of the recordings [rad]."""
        return float(np.median([vibration.step for vibration in self.vibrations]))

    def to_dict(self) -> dict[str, Any]:
        """The content of the result's file; SI units, named where they stand."""
        return {
            "k": self.k.to_dict(),
            "b_t": self.b_t.to_dict(),
            "covariance": {
                "order": ["k", "b_t"],
                "units": [self.k.unit, self.b_t.unit],
                "values": self.covariance.tolist(),
            },
            "correlation": self.correlation,
            "contacts": [asdict(contact) for contact in self.contacts],
            "contacts_agree": self.contacts_agree,
            "encoder_step": {"value": self.encoder_step, "unit": "rad"},
            "noise": {"value": self.noise, "unit": "rad"},
            "condition": self.condition,
            "identifiability": list(self.identifiability),
            "converged": self.converged,
            "status": self.status,
            "remedy": self.remedy,
            "recordings": [vibration.to_dict() for vibration in self.vibrations],
            "recordings_units": {
                "a": "m", "begin": "s", "end": "s", "amplitude": "rad", "residual_rms": "rad",
                "readings_met": "1", "omega_n": "rad/s", "zeta": "1",
            },
        }  # fmt: skip
