"""Effects that the model of a car may lack: those of the library in a car's words and ranges."""

from dataclasses import replace

from symbolic.effects.base import Effect
from symbolic.effects.library import EFFECTS


def _renamed_effect(effect: str, name: str, summary: str, **ranges: float) -> Effect:
    """An effect of the library under another name, its only parameter in another range."""
    (parameter,) = EFFECTS[effect].parameters
    own = replace(parameter, **ranges)  # type: ignore[arg-type]
    return replace(EFFECTS[effect], name=name, summary=summary, parameters=(own,))


# Friction of tyres that falls with speed looks like damping or friction below 0, which no steering has.
CAR_EFFECTS: dict[str, Effect] = {
    effect.name: effect
    for effect in (
        _renamed_effect(
            "bearing_friction", "gear_friction", "dry friction of the gear beyond that declared",
            start=1.0, lower=0.0, upper=200.0, scale=5.0,
        ),
        _renamed_effect("backlash", "play_of_joints", "play from rack to wheels, crossed at no force"),
        _renamed_effect(
            "carcass_torsion", "compliance_of_steering",
            "column, rods, suspension and carcass that give way, beside the tyre's stiffness",
            start=1e4, lower=100.0, scale=1e4,
        ),
        _renamed_effect(
            "steering_return", "jacking",
            "a torque that turns the wheels back to the middle, other than the declared kingpin's",
            start=5.0, lower=-500.0, upper=500.0, scale=20.0,
        ),
        _renamed_effect(
            "patch_width", "brakes_and_scrub", "a contact that turns about a point farther away"
        ),
        _renamed_effect(
            "contact_damping", "damping_of_joints", "viscous damping beyond that declared",
            start=1.0, lower=0.0, upper=200.0, scale=20.0,
        ),
        _renamed_effect("torque_offset", "zero_of_force", "a zero of the force beyond its tolerance"),
    )
}  # fmt: skip
"""Candidate effects of a car's diagnosis. Declared values vary within their tolerances anyway."""
