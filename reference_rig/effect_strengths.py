"""How strong each effect may be made, and what is drawn along with its strength."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from reference_rig.path import Hand

Random = np.random.Generator
Parameters = dict[str, float]


def _unchanged(parameters: Parameters, rng: Random) -> Parameters:
    del rng
    return parameters


def _nothing(a: float, load: float) -> Parameters:
    del a, load
    return {}


def _another_value(parameters: Parameters, rng: Random) -> Parameters:
    factor = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.6, 1.2))
    return {name: factor * value for name, value in parameters.items()}


def _another_gust(parameters: Parameters, rng: Random) -> Parameters:
    return parameters | {"seed": int(rng.integers(2**31))}


USUAL = Hand()
LATE_SLIDE = Hand(first=0.12, pace=0.11, nesting=0.6)
"""A full slide wipes the first twist out; here it comes late."""


@dataclass(frozen=True, kw_only=True)
class Planting:
    """How strong an effect may be made."""

    parameters: Callable[[float, Random], Parameters]
    """Parameters from a strength; draws whatever else there is to choose."""
    least: float
    largest: float
    hand: Hand = USUAL
    given: Callable[[float, float], Parameters] = _nothing
    """Further parameters from half-length [m] and mean load [N] of the first recording."""
    another_day: Callable[[Parameters, Random], Parameters] = _unchanged
    """Parameters of the next recording from those of the first."""


def _one(parameter: str, neutral: float = 0.0) -> Callable[[float, Random], Parameters]:
    return lambda strength, _: {parameter: neutral + strength}


def _either_sign(parameter: str) -> Callable[[float, Random], Parameters]:
    return lambda strength, rng: {parameter: float(rng.choice([-1.0, 1.0])) * strength}


def _with(
    parameter: str, neutral: float, other: str, low: float, high: float
) -> Callable[[float, Random], Parameters]:
    return lambda strength, rng: {
        parameter: neutral + strength,
        other: float(np.exp(rng.uniform(np.log(low), np.log(high)))),
    }


def _gust(strength: float, rng: Random) -> Parameters:
    return {"level": strength, "time": rng.uniform(0.4, 1.0), "seed": int(rng.integers(2**31))}


PLANTINGS: Mapping[str, Planting] = {
    "rate_friction": Planting(parameters=_one("c"), least=2e-3, largest=0.15),
    "stribeck": Planting(parameters=_with("ratio", 1.0, "v_s", 1e-3, 6e-3), least=0.01, largest=1.5),
    "carcass_torsion": Planting(
        parameters=lambda strength, _: {"k_t": 1 / strength}, least=1e-4, largest=0.05
    ),
    "patch_width": Planting(parameters=_one("half_width"), least=2e-3, largest=0.06),
    "pressure_shape": Planting(parameters=_one("exponent", 2.0), least=0.1, largest=8.0),
    "viscoelastic_relaxation": Planting(
        parameters=_with("gain", 0.0, "time", 0.2, 1.0), least=0.02, largest=4.0
    ),
    "contact_damping": Planting(parameters=_one("c"), least=0.05, largest=20.0),
    "sensor_delay": Planting(parameters=_one("delay"), least=2e-3, largest=0.14),
    "torque_offset": Planting(
        parameters=_either_sign("M_0"), least=0.05, largest=10.0, another_day=_another_value
    ),
    "pretwist": Planting(
        parameters=_either_sign("psi_0"),
        least=2e-3,
        largest=0.3,
        hand=LATE_SLIDE,
        another_day=_another_value,
    ),
    "load_dependent_friction": Planting(parameters=_one("n"), least=0.05, largest=1.0),
    "asymmetric_friction": Planting(parameters=_one("ratio", 1.0), least=0.01, largest=0.6),
    "friction_drift": Planting(
        parameters=_with("gain", 0.0, "scale", 0.3, 1.5), least=0.01, largest=1.0
    ),
    "pressure_skew": Planting(parameters=_either_sign("skew"), least=0.02, largest=0.9),
    "bearing_friction": Planting(parameters=_one("M_c"), least=0.02, largest=5.0),
    "steering_return": Planting(parameters=_one("stiffness"), least=0.2, largest=50.0),
    "backlash": Planting(parameters=_one("gap"), least=1e-3, largest=0.1),
    "slide_oscillation": Planting(
        parameters=_with("amplitude", 0.0, "frequency", 3.0, 8.0), least=0.05, largest=5.0
    ),
    "gust": Planting(parameters=_gust, least=0.05, largest=5.0, another_day=_another_gust),
    "frictional_creep": Planting(parameters=_one("c"), least=2e-3, largest=0.2),
    "contact_length": Planting(
        parameters=_one("n"),
        least=0.05,
        largest=1.0,
        given=lambda a, load: {"F_0": load * (0.045 / a) ** 2, "m": 2.0},
    ),
}
