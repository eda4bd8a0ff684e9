"""What friction of a car rests on beside what was measured, in one line."""

from math import hypot

from brushgrip.wording.formatting import listed
from symbolic import Vehicle
from symbolic.vehicle.mean_wheel import friction_uncertainties

LEAST_SHARE = 0.01
"""Share of mu from which on a declared value is named [1]."""
REMEDIES = {
    "front_axle_load": "weighing the front axle",
    "half_length": "measuring a print of the contact",
    "slide_factor": "ground of better known friction",
    "geometry": "measuring steering arm and lock",
    "force_scale": "comparing the force with that of a load cell in the tie rod",
    "gear_load_share": "measuring how the gear's friction grows with load",
}
"""What makes a declared value better known, by its key in the vehicle file."""
STANDS = (
    "no speed is recorded, so that the car is taken to stand; where it rolled, friction is told too low,"
    " by half and more: map speed"
)
"""What friction of a car without a speed rests on."""


def rests_on(vehicle: Vehicle, *, brakes: bool) -> str:
    """The declared values in mu with their standard deviations, and what narrows them most."""
    shares = friction_uncertainties(vehicle, brakes=brakes)
    values = {
        "front_axle_load": f"front_axle_load {vehicle.front_axle_load:.0f} N",
        "half_length": f"half_length {1e3 * vehicle.a:.0f} mm",
        "slide_factor": f"slide_factor {vehicle.slide_factor or 1:.2f}",
        "geometry": "geometry",
        "gear_load_share": "gear_load_share",
        "force_scale": "force_scale",
    }
    ranked = sorted(shares, key=lambda name: -shares[name])
    named = [f"{values[name]} ({shares[name]:.1%})" for name in ranked if shares[name] >= LEAST_SHARE]
    if not named:
        return ""
    follows = (
        "; half_length follows from the load"
        if "half_length" in shares and vehicle.half_length is None
        else ""
    )
    return (
        f"{hypot(*shares.values()):.1%} of mu, as a standard deviation, rests on declared values that no"
        f" steering tells: {listed(named)}{follows}; {REMEDIES[ranked[0]]} narrows that most"
    )
