"""Independent reference rig: an oracle for the packages and the source of the examples' recordings.

A tyre stands on a fine grid of bristles in plain NumPy. The rig shares no code with `symbolic`,
`observers`, `identification` or `brushgrip` and imports none of them, so that agreement is evidence.

- `simulate_bristles` turns a `RigTyre` through a `RigDrive`, with the effects of `RIG_EFFECTS`.
- `make_recording` and `make_campaign` record it with a hand's path and the sensors' noise.
- `make_ground_recording` changes the friction with time, and `make_steering_recording` turns a
  wheel with inertia by its steering torque.
- `draw_car` draws a car that is steered at standstill; `simulate_car` and `record_car` are its parts.
- `make_impacts` and `make_tows` repeat the two identification experiments of [Györök 2022].
"""

from reference_rig.campaign import Campaign, make_campaign, plant_effect
from reference_rig.car import Car
from reference_rig.car_driver import handwheel_path
from reference_rig.car_fleet import TOLERANCES, FleetCar, draw_car
from reference_rig.car_gear import Assistance, GearFriction, Joint
from reference_rig.car_geometry import Kingpin, Linkage, ackermann_share
from reference_rig.car_motion import CAR_STEP, CarMotion, simulate_car
from reference_rig.car_patch import CarPatches, CarTyre, bristle_grid
from reference_rig.car_recording import CarBus, CarRecording, record_car
from reference_rig.ground import (
    WALK_KNOT,
    Friction,
    GroundRecording,
    constant_friction,
    friction_between,
    friction_step,
    make_ground_recording,
    simulate_ground,
)
from reference_rig.hooks import Array, PlantedEffect, RigDrive, RigHistory
from reference_rig.other_laws import MECHANISMS, OTHER_LAWS
from reference_rig.patch import (
    REFERENCE_SPEED,
    RENEWAL,
    REST_SPEED,
    RigTyre,
    contact_age,
    simulate_bristles,
)
from reference_rig.path import SUBSTEPS, Hand, constant_turn, free_path, hand_path
from reference_rig.recording import (
    RIG_EFFECTS,
    EffectValues,
    RigRecording,
    build_effects,
    make_recording,
    recording_csv,
    rig_toml,
)
from reference_rig.sensors import (
    FOURTEEN_BIT_STEP,
    add_outliers,
    delay_samples,
    drop_samples,
    jitter_instants,
    quantise,
    sample_instants,
)
from reference_rig.steered_car import SteeredCar
from reference_rig.steered_wheel import SteeredWheel
from reference_rig.steering import (
    MOTION_STEP,
    Grip,
    SteeredMotion,
    SteeringRecording,
    Wheel,
    full_slide_moment,
    make_steering_recording,
    simulate_steering,
)
from reference_rig.thesis_experiments import (
    CONTACT_HALF_LENGTHS,
    IMPACT_PULSE,
    IMPACT_STEP,
    THESIS_DAMPING,
    THESIS_TYRE,
    TOWING_LOADS,
    ImpactRecording,
    Towing,
    impact_rig_toml,
    inertia,
    load_at,
    make_impact,
    make_impacts,
    make_tows,
    simulate_impact,
    write_impacts,
)
from reference_rig.unmodelled import UNMODELLED_EFFECTS

__all__ = [
    "CAR_STEP",
    "CONTACT_HALF_LENGTHS",
    "FOURTEEN_BIT_STEP",
    "IMPACT_PULSE",
    "IMPACT_STEP",
    "MECHANISMS",
    "MOTION_STEP",
    "OTHER_LAWS",
    "REFERENCE_SPEED",
    "RENEWAL",
    "REST_SPEED",
    "RIG_EFFECTS",
    "SUBSTEPS",
    "THESIS_DAMPING",
    "THESIS_TYRE",
    "TOLERANCES",
    "TOWING_LOADS",
    "UNMODELLED_EFFECTS",
    "WALK_KNOT",
    "Array",
    "Assistance",
    "Campaign",
    "Car",
    "CarBus",
    "CarMotion",
    "CarPatches",
    "CarRecording",
    "CarTyre",
    "EffectValues",
    "FleetCar",
    "Friction",
    "GearFriction",
    "Grip",
    "GroundRecording",
    "Hand",
    "ImpactRecording",
    "Joint",
    "Kingpin",
    "Linkage",
    "PlantedEffect",
    "RigDrive",
    "RigHistory",
    "RigRecording",
    "RigTyre",
    "SteeredCar",
    "SteeredMotion",
    "SteeredWheel",
    "SteeringRecording",
    "Towing",
    "Wheel",
    "ackermann_share",
    "add_outliers",
    "bristle_grid",
    "build_effects",
    "constant_friction",
    "constant_turn",
    "contact_age",
    "delay_samples",
    "draw_car",
    "drop_samples",
    "free_path",
    "friction_between",
    "friction_step",
    "full_slide_moment",
    "hand_path",
    "handwheel_path",
    "impact_rig_toml",
    "inertia",
    "jitter_instants",
    "load_at",
    "make_campaign",
    "make_ground_recording",
    "make_impact",
    "make_impacts",
    "make_recording",
    "make_steering_recording",
    "make_tows",
    "plant_effect",
    "quantise",
    "record_car",
    "recording_csv",
    "rig_toml",
    "sample_instants",
    "simulate_bristles",
    "simulate_car",
    "simulate_ground",
    "simulate_impact",
    "simulate_steering",
    "write_impacts",
]
