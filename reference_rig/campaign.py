"""Campaigns: a few recordings of one tyre with one effect of a chosen strength."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from reference_rig.hooks import Array, RigDrive
from reference_rig.patch import RigTyre, simulate_bristles
from reference_rig.path import STEP_RATE, SUBSTEPS, Hand, hand_path
from reference_rig.recording import EffectValues, RigRecording, build_effects, make_recording

Random = np.random.Generator
Parameters = dict[str, float]


def _another_value(parameters: Parameters, rng: Random) -> Parameters:
    factor = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.6, 1.2))
    return {name: factor * value for name, value in parameters.items()}


def _another_gust(parameters: Parameters, rng: Random) -> Parameters:
    return parameters | {"seed": int(rng.integers(2**31))}


USUAL = Hand()
LATE_SLIDE_HAND = Hand(first=0.12, pace=0.11, nesting=0.6)
"""A full slide wipes the first twist out; here it comes late."""


@dataclass(frozen=True)
class StrengthRange:
    """Parameters of an effect at a strength, and its least and largest strength."""

    # Parameters from a strength; draws whatever else there is to choose.
    parameters: Callable[[float, Random], Parameters]
    least: float
    largest: float
    hand: Hand = USUAL
    # Further parameters from half-length [m] and mean load [N] of the first recording.
    given: Callable[[float, float], Parameters] = lambda _a, _load: {}
    # Parameters of the next recording from those of the first.
    another_day: Callable[[Parameters, Random], Parameters] = lambda parameters, _: parameters


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


def _slopes(strength: float, rng: Random) -> Parameters:
    return {name: strength * rng.uniform(0, 2) for name in ("slow", "middle", "fast")}


def _eccentricity(strength: float, rng: Random) -> Parameters:
    cycles, phase = float(rng.choice([6.0, 8.0, 10.0])), rng.uniform(0, 2 * np.pi)
    return {"amplitude": strength, "cycles": cycles, "phase": phase}


STRENGTHS: Mapping[str, StrengthRange] = {
    "rate_friction": StrengthRange(_one("c"), 2e-3, 0.15),
    "stribeck": StrengthRange(_with("ratio", 1.0, "v_s", 1e-3, 6e-3), 0.01, 1.5),
    "carcass_torsion": StrengthRange(lambda strength, _: {"k_t": 1 / strength}, 1e-4, 0.05),
    "patch_width": StrengthRange(_one("half_width"), 2e-3, 0.06),
    "pressure_shape": StrengthRange(_one("exponent", 2.0), 0.1, 8.0),
    "viscoelastic_relaxation": StrengthRange(_with("gain", 0.0, "time", 0.2, 1.0), 0.02, 4.0),
    "contact_damping": StrengthRange(_one("c"), 0.05, 20.0),
    "sensor_delay": StrengthRange(_one("delay"), 2e-3, 0.14),
    "torque_offset": StrengthRange(_either_sign("M_0"), 0.05, 10.0, another_day=_another_value),
    "zero_drift": StrengthRange(_either_sign("rate"), 2e-3, 1.0, another_day=_another_value),
    "pretwist": StrengthRange(
        _either_sign("psi_0"), 2e-3, 0.3, hand=LATE_SLIDE_HAND, another_day=_another_value
    ),
    "tared_pretwist": StrengthRange(_either_sign("psi_0"), 2e-3, 0.045, hand=LATE_SLIDE_HAND),
    "load_dependent_friction": StrengthRange(_one("n"), 0.05, 1.0),
    "asymmetric_friction": StrengthRange(_one("ratio", 1.0), 0.01, 0.6),
    "friction_drift": StrengthRange(_with("gain", 0.0, "scale", 0.3, 1.5), 0.01, 1.0),
    "pressure_skew": StrengthRange(_either_sign("skew"), 0.02, 0.9),
    "bearing_friction": StrengthRange(_one("M_c"), 0.02, 5.0),
    "steering_return": StrengthRange(_one("stiffness"), 0.2, 50.0),
    "backlash": StrengthRange(_one("gap"), 1e-3, 0.1),
    "play": StrengthRange(_one("gap"), 1e-3, 0.1),
    "slide_oscillation": StrengthRange(_with("amplitude", 0.0, "frequency", 3.0, 8.0), 0.05, 5.0),
    "gust": StrengthRange(_gust, 0.05, 5.0, another_day=_another_gust),
    "frictional_creep": StrengthRange(_one("c"), 2e-3, 0.2),
    "contact_length": StrengthRange(
        _one("n"), 0.05, 0.9, given=lambda a, load: {"F_0": load * (0.045 / a) ** 2, "m": 2.0}
    ),
    "free_branch": StrengthRange(_with("stiffness", 0.0, "time", 0.2, 1.0), 0.5, 200.0),
    "encoder_eccentricity": StrengthRange(_eccentricity, 1e-4, 0.1),
    "sensor_hysteresis": StrengthRange(_one("height"), 0.02, 5.0),
    "contact_ageing": StrengthRange(_one("gain"), 5e-3, 1.0),
    "log1p_friction": StrengthRange(_with("c", 0.0, "v_0", 2e-4, 5e-3), 2e-3, 0.5),
    "power_friction": StrengthRange(_one("p"), 2e-3, 0.2),
    "saturating_friction": StrengthRange(_with("gain", 0.0, "v_0", 1e-3, 1e-2), 0.01, 3.0),
    "gaussian_stribeck": StrengthRange(_with("ratio", 1.0, "v_s", 1e-3, 6e-3), 0.01, 1.5),
    "hyperbolic_stribeck": StrengthRange(_with("ratio", 1.0, "v_s", 1e-3, 6e-3), 0.01, 1.5),
    "logarithmic_drift": StrengthRange(_with("gain", 0.0, "scale", 0.1, 1.0), 0.01, 0.6),
    "exponential_load": StrengthRange(_one("n"), 0.05, 1.5),
    "smooth_asymmetry": StrengthRange(_one("gain"), 0.01, 0.4),
    "pressure_power": StrengthRange(_one("power", 1.0), 0.1, 6.0),
    "torque_lag": StrengthRange(_one("time"), 2e-3, 0.14),
    "quadratic_damping": StrengthRange(_one("c"), 0.05, 60.0),
    "hardening_return": StrengthRange(_one("stiffness"), 0.1, 50.0),
    "speed_law": StrengthRange(_slopes, 2e-3, 0.2),
}


MIN_EFFECT_SHARE, MAX_EFFECT_SHARE = 0.03, 0.10
"""Least and largest change of the torque by an effect, rms over the range without it [1]."""
SEARCH_BRISTLES = 400
SEARCH_STEPS = 14


@dataclass(frozen=True, kw_only=True, eq=False)
class Campaign:
    """Recordings of one tyre; every recording carries its own truth."""

    recordings: tuple[RigRecording, ...]
    nominal: RigTyre  # First guesses: a and e are true, k and mu are up to 20 % off.


def plant_effect(
    name: str | None, seed: int, *, tyre: RigTyre | None = None, load: float = 400.0,
    duration: float = 14.0, share: float | None = None,
) -> RigRecording:  # fmt: skip
    """One recording with one effect, strong enough to matter.

    Args:
        name: effect to plant; None for none.
        seed: of the path, the noise and the effect's strength.
        tyre: the tyre; None for the rig's usual one.
        load: mean vertical load [N].
        duration: length [s].
        share: rms of the change of torque over the torque's range [1]; None draws it from 3 % to
            10 %. Where the strongest sensible effect moves less, that one is taken.
    """
    tyre = tyre or RigTyre()
    hand = STRENGTHS[name].hand if name else USUAL
    effects: EffectValues = {}
    if name:
        rng = np.random.default_rng([seed, 3, list(STRENGTHS).index(name)])
        wanted = rng.uniform(MIN_EFFECT_SHARE, MAX_EFFECT_SHARE) if share is None else share
        effects = {name: _parameters_for(name, seed, tyre, load, duration, wanted)}
    name = f"{name or 'declared'}_{seed}"
    return make_recording(
        seed, effects, **vars(tyre), load=load, duration=duration, hand=hand, name=name
    )


def make_campaign(
    name: str | None,
    seed: int,
    recordings: int = 3,
    *,
    duration: float = 14.0,
    also: EffectValues | None = None,
    off: float = 0.0,
    grounds: Sequence[str] = (),
) -> Campaign:
    """Recordings of one tyre on different days: same k and effect, other path, load and mu.

    Args:
        name: effect to plant; None for none, the control.
        seed: of everything.
        recordings: how many.
        duration: of each [s].
        also: further effects with their parameters, in every recording.
        off: a recording's half-length differs from the nominal one by up to this [m], another day's
            inflation or a coarse ruler.
        grounds: names of grounds, on which the recordings stand in turn; on each, mu is by another
            factor of up to 30 %.
    """
    rng = np.random.default_rng([seed, 4])
    a = float(rng.choice([0.04, 0.045, 0.05]))
    tyre = RigTyre(a=a, k=rng.uniform(1.8e6, 3.2e6), mu=rng.uniform(1.0, 1.7))
    nominal = replace(tyre, k=tyre.k * rng.uniform(0.8, 1.2), mu=tyre.mu * rng.uniform(0.8, 1.2))
    load = 400.0 * rng.uniform(0.85, 1.15)
    hand = STRENGTHS[name].hand if name else USUAL
    first = plant_effect(name, seed, tyre=tyre, load=load, duration=duration)
    recorded = []
    for number in range(recordings):
        effects = dict(first.effects)
        if name and number:
            effects[name] = STRENGTHS[name].another_day(dict(effects[name]), rng)
        made = make_recording(
            seed + 1000 * number, effects | dict(also or {}),
            **vars(replace(tyre, mu=tyre.mu * rng.uniform(0.92, 1.08))),
            load=load * rng.uniform(0.95, 1.05), duration=duration, hand=hand,
            name=f"recording_{chr(ord('a') + number)}",
        )  # fmt: skip
        recorded.append(made)
    recorded = _elsewhere(recorded, seed, off, grounds, hand, duration)
    return Campaign(recordings=tuple(recorded), nominal=nominal)


def _elsewhere(
    recorded: list[RigRecording], seed: int, off: float, grounds: Sequence[str], hand: Hand,
    duration: float,
) -> list[RigRecording]:  # fmt: skip
    """The same recordings with other half-lengths and on grounds, where that is asked for."""
    if not (off or grounds):
        return recorded
    rng = np.random.default_rng([seed, 8])
    factors = {ground: rng.uniform(0.7, 1.3) for ground in grounds}
    made = []
    for number, recording in enumerate(recorded):
        ground = grounds[number % len(grounds)] if grounds else None
        a, mu = recording.tyre.a + rng.uniform(-off, off), recording.tyre.mu
        tyre = replace(recording.tyre, a=a, mu=mu * factors.get(ground or "", 1.0))
        load = float(recording.F_N_true.mean())
        again = make_recording(
            seed + 1000 * number, recording.effects, **vars(tyre),
            load=load, duration=duration, hand=hand, name=recording.name,
        )  # fmt: skip
        made.append(replace(again, ground=ground))
    return made


def _parameters_for(
    name: str, seed: int, tyre: RigTyre, load: float, duration: float, wanted: float
) -> Parameters:
    """Bisect the logarithm of the strength for the share of the range wanted."""
    planting = STRENGTHS[name]

    def parameters(strength: float) -> Parameters:
        drawn = planting.parameters(strength, np.random.default_rng([seed, 5]))
        return drawn | planting.given(tyre.a, load)

    low, high = np.log(planting.least), np.log(planting.largest)
    drive, without = _without(seed, tyre, load, duration, planting.hand)

    def share(strength: float) -> float:
        """Change of the torque, rms over the range without the effect [1]; nothing is refitted."""
        effects = build_effects({name: parameters(strength)})
        with_it = simulate_bristles(drive, tyre, effects, bristles=SEARCH_BRISTLES).M_z
        return float(np.sqrt(np.mean((with_it - without) ** 2)) / np.ptp(without))

    if share(planting.largest) < wanted:
        return parameters(planting.largest)
    for _ in range(SEARCH_STEPS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if share(float(np.exp(middle))) < wanted else (low, middle)
    return parameters(float(np.exp(0.5 * (low + high))))


@lru_cache
def _without(
    seed: int, tyre: RigTyre, load: float, duration: float, hand: Hand
) -> tuple[RigDrive, Array]:
    """The path, and the torque without any effect."""
    drive = hand_path(seed, duration, hand=hand, load=load, rate=STEP_RATE).every(SUBSTEPS)
    return drive, simulate_bristles(drive, tyre, bristles=SEARCH_BRISTLES).M_z
