"""What an identification from free vibrations says: frozen results, and the dictionary for its file."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from identification.parameter_estimate import ParameterEstimate
from identification.thesis.fft_decrement import SourceWay

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Identified:
    """An identified parameter.

    Attributes:
        value: the estimate, in `unit`.
        std: its standard deviation.
        interval: between these it lies with 95 % confidence.
        unit: the unit of all of these.
    """

    value: float
    std: float
    interval: tuple[float, float]
    unit: str


@dataclass(frozen=True, kw_only=True)
class ContactFound:
    """What belongs to one contact.

    Attributes:
        a: half-length of the contact patch [m].
        e: caster length [m].
        force: mu F_N as the sliding at the patch's ends shows it [N]; None where that is not told from
            none at all.
        k: from the recordings of this contact alone; None where they are all there is, or do not tell.
    """

    a: float
    e: float
    force: ParameterEstimate | None
    k: ParameterEstimate | None


@dataclass(frozen=True, kw_only=True, eq=False)
class Vibration:
    """One recording beside its fit; arrays of shape (n,), from the first turning point on.

    Attributes:
        name: the recording.
        a: half-length of the contact patch [m].
        t: time [s].
        psi: readings [rad].
        fitted: the fitted angle [rad].
        centre: angle about which the wheel swings [rad].
        amplitude: first deflection from there [rad].
        rms: root mean square of reading minus fitted angle [rad].
        rounded: share of the readings that are the fitted angle, rounded to the encoder's step [1].
        sticking: natural angular frequency [rad/s] and relative damping [1] with the identified k and
            b_t if no bristle slid, source (5.7) and (5.8) with J_A.
    """

    name: str
    a: float
    t: Array
    psi: Array
    fitted: Array
    centre: float
    amplitude: float
    rms: float
    rounded: float
    sticking: tuple[float, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class FreeDecay:
    """The whole result of `identify_free_decay`.

    Attributes:
        k: distributed lateral stiffness.
        b_t: torsional damping.
        covariance: of k and b_t, shape (2, 2) [N^2/m^4, N^2 s/(m rad), (N m s/rad)^2].
        correlation: of k and b_t [1].
        contacts: every contact; none where the patch was said to stick.
        contacts_agree: whether these tell one k; None where fewer than two tell it. Where they do not,
            the intervals do not cover what is wrong.
        encoder_step: of the yaw angle [rad].
        noise: scale of the logistic noise besides the step [rad].
        condition: condition number of the information on k, b_t and the friction forces, each in units
            of its standard deviation if all others were known [1].
        identifiability: what the recordings tell and what would help, in plain words, a sentence each.
        vibrations: every recording.
        converged: whether the programme was solved; values of one that was not are no result.
        status: how it ended.
        remedy: what to do where it was not solved, else empty.
        source: the source's way on the same recordings.
    """

    k: Identified
    b_t: Identified
    covariance: Array
    correlation: float
    contacts: tuple[ContactFound, ...]
    contacts_agree: bool | None
    encoder_step: float
    noise: float
    condition: float
    identifiability: tuple[str, ...]
    vibrations: tuple[Vibration, ...]
    converged: bool
    status: str
    remedy: str
    source: SourceWay

    def to_dict(self) -> dict[str, Any]:
        """The content of the result's file; SI units, named where they stand."""
        return {
            "k": _identified(self.k),
            "b_t": _identified(self.b_t),
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
            "recordings": [
                {
                    "name": v.name,
                    "a": v.a,
                    "samples": v.t.size,
                    "begin": float(v.t[0]),
                    "end": float(v.t[-1]),
                    "amplitude": v.amplitude,
                    "residual_rms": v.rms,
                    "readings_met": v.rounded,
                    "omega_n": v.sticking[0],
                    "zeta": v.sticking[1],
                    "source_omega_n": swing.omega_n,
                    "source_zeta": swing.zeta,
                }
                for v, swing in zip(self.vibrations, self.source.swings, strict=True)
            ],
            "recordings_units": {
                "a": "m", "begin": "s", "end": "s", "amplitude": "rad", "residual_rms": "rad",
                "readings_met": "1", "omega_n": "rad/s", "zeta": "1",
                "source_omega_n": "rad/s", "source_zeta": "1",
            },
            "source": {
                "k": {"value": self.source.k, "unit": "N/m^2"},
                "b_t": {"value": self.source.b_t, "unit": "N m s/rad"},
                "b_t_printed": {"value": self.source.b_t_printed, "unit": "1/s"},
            },
        }  # fmt: skip


def _identified(parameter: Identified) -> dict[str, Any]:
    return {
        "value": parameter.value,
        "std": parameter.std,
        "interval_95": list(parameter.interval),
        "unit": parameter.unit,
    }
