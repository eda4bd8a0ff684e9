"""Friction at one load, where a found model's friction depends on the load."""

from collections.abc import Sequence
from dataclasses import replace
from statistics import median_low

import numpy as np

from brushgrip.wording.recording_remarks import OVER_LOAD
from identification import FoundModel, Recording
from observers import Estimates
from symbolic.bristle_patch import BristlePatch
from symbolic.float_array_type import Array
from symbolic.patch_moment_by_zones import full_slide_arm

LEAST_CHANGE = 0.01
"""Change of friction over the loads of a recording from which on its load is told [1]."""


def mu_eff_ratio_at_load(found: FoundModel, recording: Recording, load: float) -> Array:
    """mu_eff at a load [N] over that at the load of each sample, by the model's law [1], shape (n,)."""
    model, rig = found.model, recording.rig
    # The law's own mu is a factor on both.
    theta = model.theta({**found.values_for_estimation(recording.ground), "mu": 1.0})
    memory, loads = np.zeros(model.memory_size), np.append(recording.F_N, load)[None]
    mu_eff, _ = model.full_slide(memory, loads, theta, [rig.a, rig.e], rig.slide_rate)
    each = np.asarray(mu_eff, dtype=float).ravel()
    return np.asarray(each[-1] / each[:-1])


def common_load(found: FoundModel, recordings: Sequence[Recording]) -> float | None:
    """A load of the recordings amid theirs [N], at which they compare; None where it changes nothing.

    None, too, for a car, whose observer takes no found model.
    """
    load = median_low(float(np.median(r.F_N)) for r in recordings)
    on_rig = [r for r in recordings if r.standstills is None]
    ratios = [mu_eff_ratio_at_load(found, recording, load) for recording in on_rig]
    return load if any(np.abs(ratio - 1).max() >= LEAST_CHANGE for ratio in ratios) else None


def at_load(estimates: Estimates, found: FoundModel, recording: Recording, load: float) -> Estimates:
    """The estimates with mu_eff and its deviation as they would be at a load [N]."""
    ratio = mu_eff_ratio_at_load(found, recording, load)
    return replace(estimates, mu_eff=ratio * estimates.mu_eff, mu_eff_std=ratio * estimates.mu_eff_std)


def friction_load_text(found: FoundModel, recording: Recording, at: int) -> str:
    """The load that mu_eff of a sample belongs to, where it changes with the load; else empty."""
    load = float(recording.F_N[at])
    if np.abs(mu_eff_ratio_at_load(found, recording, load) - 1).max() < LEAST_CHANGE:
        return ""
    share, length = friction_to_mu_eff_ratio(found, recording, load), ""
    if abs(share - 1) >= LEAST_CHANGE:
        length = (
            ", over the declared half-length; of the contact that the model has there friction is"
            f" {share:.2f} times mu_eff"
        )
    return f"{OVER_LOAD}: mu_eff is that at {load:.0f} N{length}"


def friction_to_mu_eff_ratio(found: FoundModel, recording: Recording, load: float) -> float:
    """Friction over mu_eff [1], which counts a contact that is longer under a load [N] as friction."""
    model, rig = found.model, recording.rig
    patch = model.patch(model.theta({**found.values_for_estimation(recording.ground), "mu": 1.0}))
    growth = patch.traits.relative_length(load, rig.a) if isinstance(patch, BristlePatch) else 1
    arms = (full_slide_arm(half_length, rig.e) for half_length in (rig.a, rig.a * float(growth)))
    return float(next(arms)) / float(next(arms))
