"""Campaigns: a few recordings of one tyre with one effect of a chosen strength."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from reference_rig.effect_strengths import PLANTINGS, USUAL, Parameters, Random
from reference_rig.hooks import Array, Drive
from reference_rig.patch import RigTyre, simulate
from reference_rig.path import Hand, hand_path
from reference_rig.record import (
    SAMPLE_RATE,
    SUBSTEPS,
    Planted,
    RigRecording,
    build_effects,
    make_recording,
    rig_text,
    write_csv,
)

LEAST_SHARE, LARGEST_SHARE = 0.03, 0.10
"""An effect moves the torque by this much, rms in shares of the range without it [1]."""
SEARCH_BRISTLES = 400
SEARCH_STEPS = 14


@dataclass(frozen=True, kw_only=True, eq=False)
class Campaign:
    """Recordings of one tyre; every recording carries its own truth."""

    name: str | None
    recordings: tuple[RigRecording, ...]
    nominal: RigTyre
    """First guesses: a and e are true, k and mu are up to 20 % off."""
    share: float
    """By how much the effect moved the first recording's torque, rms over range [1]."""


def plant(
    name: str | None,
    seed: int,
    *,
    tyre: RigTyre | None = None,
    load: float = 400.0,
    duration: float = 14.0,
    share: float | None = None,
) -> RigRecording:
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
    hand = PLANTINGS[name].hand if name else USUAL
    effects: Planted = {}
    if name:
        rng = np.random.default_rng([seed, 3, list(PLANTINGS).index(name)])
        wanted = rng.uniform(LEAST_SHARE, LARGEST_SHARE) if share is None else share
        effects = {name: _parameters_for(name, seed, tyre, load, duration, wanted)}
    return _record(seed, effects, tyre, load, duration, hand, f"{name or 'declared'}_{seed}")


def campaign(
    name: str | None,
    seed: int,
    recordings: int = 3,
    *,
    duration: float = 14.0,
    also: Planted | None = None,
) -> Campaign:
    """Recordings of one tyre on different days: same k and effect, other path, load and mu.

    Args:
        name: effect to plant; None for none, the control.
        seed: of everything.
        recordings: how many.
        duration: of each [s].
        also: further effects with their parameters, in every recording.
    """
    rng = np.random.default_rng([seed, 4])
    tyre = RigTyre(
        a=float(rng.choice([0.04, 0.045, 0.05])),
        k=rng.uniform(1.8e6, 3.2e6),
        mu=rng.uniform(1.0, 1.7),
    )
    nominal = replace(tyre, k=tyre.k * rng.uniform(0.8, 1.2), mu=tyre.mu * rng.uniform(0.8, 1.2))
    load = 400.0 * rng.uniform(0.85, 1.15)
    first = plant(name, seed, tyre=tyre, load=load, duration=duration)
    made = tuple(
        _record(
            seed + 1000 * number,
            _on_another_day(first.effects, name, number, rng) | dict(also or {}),
            replace(tyre, mu=tyre.mu * rng.uniform(0.92, 1.08)),
            load * rng.uniform(0.95, 1.05),
            duration,
            PLANTINGS[name].hand if name else USUAL,
            f"recording_{chr(ord('a') + number)}",
        )
        for number in range(recordings)
    )
    share = _share(name, seed, tyre, load, duration, first.effects[name]) if name else 0.0
    return Campaign(name=name, recordings=made, nominal=nominal, share=share)


def write_campaign(directory: Path, made: Campaign) -> list[Path]:
    """Write rig.toml and one CSV a recording; returns the paths of the recordings."""
    directory.mkdir(parents=True, exist_ok=True)
    (directory / "rig.toml").write_text(rig_text(made.nominal), encoding="utf-8", newline="\n")
    paths = [directory / f"{recording.name}.csv" for recording in made.recordings]
    for path, recording in zip(paths, made.recordings, strict=True):
        write_csv(path, recording)
    return paths


def _record(
    seed: int,
    effects: Planted,
    tyre: RigTyre,
    load: float,
    duration: float,
    hand: Hand,
    name: str,
) -> RigRecording:
    return make_recording(
        seed,
        effects,
        a=tyre.a,
        e=tyre.e,
        k=tyre.k,
        mu=tyre.mu,
        load=load,
        duration=duration,
        hand=hand,
        name=name,
    )


def _on_another_day(
    effects: Planted, name: str | None, number: int, rng: Random
) -> dict[str, Mapping[str, float]]:
    """The effects of the first recording, with a value of its own where the effect has one."""
    if name is None or number == 0:
        return dict(effects)
    return {name: PLANTINGS[name].another_day(dict(effects[name]), rng)}


def _parameters_for(
    name: str, seed: int, tyre: RigTyre, load: float, duration: float, wanted: float
) -> Parameters:
    """Bisect the logarithm of the strength for the share of the range wanted."""
    planting = PLANTINGS[name]

    def parameters(strength: float) -> Parameters:
        drawn = planting.parameters(strength, np.random.default_rng([seed, 5]))
        return drawn | planting.given(tyre.a, load)

    low, high = np.log(planting.least), np.log(planting.largest)
    if _share(name, seed, tyre, load, duration, parameters(planting.largest)) < wanted:
        return parameters(planting.largest)
    for _ in range(SEARCH_STEPS):
        middle = 0.5 * (low + high)
        moved = _share(name, seed, tyre, load, duration, parameters(float(np.exp(middle))))
        low, high = (middle, high) if moved < wanted else (low, middle)
    return parameters(float(np.exp(0.5 * (low + high))))


def _share(
    name: str,
    seed: int,
    tyre: RigTyre,
    load: float,
    duration: float,
    parameters: Mapping[str, float],
) -> float:
    """Change of the torque, rms over the range without the effect [1]; nothing is refitted."""
    drive, without = _without(seed, tyre, load, duration, PLANTINGS[name].hand)
    effects = build_effects({name: parameters})
    with_it = simulate(drive, tyre, effects, bristles=SEARCH_BRISTLES).M_z
    return float(np.sqrt(np.mean((with_it - without) ** 2)) / np.ptp(without))


@lru_cache
def _without(seed: int, tyre: RigTyre, load: float, duration: float, hand: Hand) -> tuple[Drive, Array]:
    """The path, and the torque without any effect."""
    fine = hand_path(seed, duration, hand=hand, load=load, rate=SAMPLE_RATE * SUBSTEPS)
    drive = Drive(
        t=fine.t[::SUBSTEPS],
        psi=fine.psi[::SUBSTEPS],
        psi_dot=fine.psi_dot[::SUBSTEPS],
        F_N=fine.F_N[::SUBSTEPS],
        psi_virgin=fine.psi_virgin,
    )
    return drive, simulate(drive, tyre, bristles=SEARCH_BRISTLES).M_z
