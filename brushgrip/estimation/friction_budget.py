"""What the band of a recording's last usable friction is made of, and what that of a car rests on."""

from math import hypot

import numpy as np

from brushgrip.estimation.observe_recording import ObserverFactory, run_arguments, with_mean_wheel_rig
from brushgrip.wording.formatting import listed
from identification import FoundModel, Recording
from observers import Ekf, Estimates, uncertainty_budget
from observers.estimates import BAND_STDS
from observers.quality.when_usable import last_usable
from observers.tuning import OF_LOAD, OF_SCALE
from symbolic import Vehicle
from symbolic.vehicle.mean_wheel import mu_std_by_cause

MAX_BUDGET_SAMPLES = 100_000
"""Samples that go through the filter once more."""
OF_VEHICLE = {
    "front_axle_load": ("axle load", "weighing the front axle"),
    "half_length": ("half-length of the contact", "measuring a print of the contact"),
    "geometry": ("lengths and ratios of the steering", "measuring steering arm and lock"),
    "slide_factor": ("measured torque of full slide", "ground of better known friction"),
    "force_scale": (
        "scale of the measured force",
        "comparing the force with that of a load cell in the tie rod",
    ),
    "gear_load_share": (
        "gear friction that grows with the force",
        "measuring how the gear's friction grows with load",
    ),
}
"""What the mean wheel of a car counts as its load, by its key in the vehicle file; what narrows that."""
LEAST_SHARE = 0.01
"""Share of mu from which on a declared value is named [1]."""
STANDS = (
    "no speed is recorded, so that the car is taken to stand; where it rolled, friction is told too low,"
    " by half and more: map speed"
)
"""What friction of a car without a speed rests on."""


def friction_budget(
    factory: ObserverFactory, recording: Recording, found: FoundModel | None, estimates: Estimates
) -> dict[str, float]:
    """Half of the 95 % band of mu_eff by cause at the last usable sample [1], which add up as squares.

    Empty where no sample is usable, for other observers than an `Ekf`, and beyond `MAX_BUDGET_SAMPLES`.
    """
    at = last_usable(estimates)
    if at is None or at >= MAX_BUDGET_SAMPLES:
        return {}
    channels, held = run_arguments(recording), recording
    if (car := recording.standstills) is not None:
        number = int(car.stretch[at])
        of_stretch = np.flatnonzero(car.stretch == number)
        channels = {n: c if c is None else c[of_stretch] for n, c in channels.items()}
        channels |= {"psi_dot": None}
        held, at = with_mean_wheel_rig(recording, car, car.brakes[number]), at - int(of_stretch[0])
    observer = factory(held, found)
    if not isinstance(observer, Ekf):
        return {}
    shares = uncertainty_budget(observer, at, **channels)
    if car is not None:
        del shares[OF_LOAD], shares[OF_SCALE]
        declared = mu_std_by_cause(car.vehicle, brakes=car.brakes[number])
        shares |= {OF_VEHICLE[name][0]: share for name, share in declared.items()}
    half = BAND_STDS * float(estimates.mu_eff[last_usable(estimates)])
    return {name: half * share for name, share in shares.items() if share > 0}


def declared_uncertainty_text(vehicle: Vehicle, *, brakes: bool) -> str:
    """The declared values in mu with their standard deviations, and what narrows them most."""
    shares = mu_std_by_cause(vehicle, brakes=brakes)
    values = {
        "front_axle_load": f"front_axle_load {vehicle.front_axle_load:.0f} N",
        "half_length": f"half_length {1e3 * vehicle.a:.0f} mm",
        "slide_factor": f"slide_factor {vehicle.slide_factor or 1:.2f}",
    }
    ranked = sorted(shares, key=lambda name: -shares[name])
    named = [
        f"{values.get(name, name)} ({shares[name]:.1%})"
        for name in ranked
        if shares[name] >= LEAST_SHARE
    ]
    if not named:
        return ""
    follows = "half_length" in shares and vehicle.half_length is None
    note = "; half_length follows from the load" * follows
    narrows = OF_VEHICLE[ranked[0]][1]
    return (
        f"{hypot(*shares.values()):.1%} of mu, as a standard deviation, rests on declared values that no"
        f" steering tells: {listed(named)}{note}; {narrows} narrows that most"
    )
