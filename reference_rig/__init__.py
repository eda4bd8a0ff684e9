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

from reference_rig.campaign import Campaign as Campaign
from reference_rig.campaign import make_campaign as make_campaign
from reference_rig.campaign import plant_effect as plant_effect
from reference_rig.car import Car as Car
from reference_rig.car_driver import handwheel_path as handwheel_path
from reference_rig.car_fleet import TOLERANCES as TOLERANCES
from reference_rig.car_fleet import FleetCar as FleetCar
from reference_rig.car_fleet import draw_car as draw_car
from reference_rig.car_gear import Assistance as Assistance
from reference_rig.car_gear import GearFriction as GearFriction
from reference_rig.car_gear import Joint as Joint
from reference_rig.car_geometry import Kingpin as Kingpin
from reference_rig.car_geometry import Linkage as Linkage
from reference_rig.car_motion import CAR_STEP as CAR_STEP
from reference_rig.car_motion import CarMotion as CarMotion
from reference_rig.car_motion import simulate_car as simulate_car
from reference_rig.car_patch import CarPatches as CarPatches
from reference_rig.car_patch import CarTyre as CarTyre
from reference_rig.car_recording import CarBus as CarBus
from reference_rig.car_recording import CarRecording as CarRecording
from reference_rig.car_recording import record_car as record_car
from reference_rig.ground import WALK_KNOT as WALK_KNOT
from reference_rig.ground import Friction as Friction
from reference_rig.ground import GroundRecording as GroundRecording
from reference_rig.ground import constant_friction as constant_friction
from reference_rig.ground import friction_between as friction_between
from reference_rig.ground import friction_step as friction_step
from reference_rig.ground import make_ground_recording as make_ground_recording
from reference_rig.ground import simulate_ground as simulate_ground
from reference_rig.hooks import Array as Array
from reference_rig.hooks import RigDrive as RigDrive
from reference_rig.hooks import RigHistory as RigHistory
from reference_rig.other_laws import MECHANISMS as MECHANISMS
from reference_rig.other_laws import OTHER_LAWS as OTHER_LAWS
from reference_rig.patch import REFERENCE_SPEED as REFERENCE_SPEED
from reference_rig.patch import RENEWAL as RENEWAL
from reference_rig.patch import REST_SPEED as REST_SPEED
from reference_rig.patch import RigTyre as RigTyre
from reference_rig.patch import contact_age as contact_age
from reference_rig.patch import simulate_bristles as simulate_bristles
from reference_rig.path import SUBSTEPS as SUBSTEPS
from reference_rig.path import Hand as Hand
from reference_rig.path import constant_turn as constant_turn
from reference_rig.path import free_path as free_path
from reference_rig.path import hand_path as hand_path
from reference_rig.recording import RIG_EFFECTS as RIG_EFFECTS
from reference_rig.recording import EffectValues as EffectValues
from reference_rig.recording import RigRecording as RigRecording
from reference_rig.recording import build_effects as build_effects
from reference_rig.recording import make_recording as make_recording
from reference_rig.recording import recording_csv as recording_csv
from reference_rig.recording import rig_toml as rig_toml
from reference_rig.sensors import FOURTEEN_BIT_STEP as FOURTEEN_BIT_STEP
from reference_rig.sensors import add_outliers as add_outliers
from reference_rig.sensors import delay_samples as delay_samples
from reference_rig.sensors import drop_samples as drop_samples
from reference_rig.sensors import jitter_instants as jitter_instants
from reference_rig.sensors import quantise as quantise
from reference_rig.sensors import sample_instants as sample_instants
from reference_rig.steered_by_samples import SteeredCar as SteeredCar
from reference_rig.steered_by_samples import SteeredWheel as SteeredWheel
from reference_rig.steering import MOTION_STEP as MOTION_STEP
from reference_rig.steering import Grip as Grip
from reference_rig.steering import SteeredMotion as SteeredMotion
from reference_rig.steering import SteeringRecording as SteeringRecording
from reference_rig.steering import Wheel as Wheel
from reference_rig.steering import full_slide_moment as full_slide_moment
from reference_rig.steering import make_steering_recording as make_steering_recording
from reference_rig.steering import simulate_steering as simulate_steering
from reference_rig.thesis_experiments import CONTACT_HALF_LENGTHS as CONTACT_HALF_LENGTHS
from reference_rig.thesis_experiments import IMPACT_PULSE as IMPACT_PULSE
from reference_rig.thesis_experiments import IMPACT_STEP as IMPACT_STEP
from reference_rig.thesis_experiments import THESIS_DAMPING as THESIS_DAMPING
from reference_rig.thesis_experiments import THESIS_TYRE as THESIS_TYRE
from reference_rig.thesis_experiments import TOWING_LOADS as TOWING_LOADS
from reference_rig.thesis_experiments import ImpactRecording as ImpactRecording
from reference_rig.thesis_experiments import Towing as Towing
from reference_rig.thesis_experiments import impact_rig_toml as impact_rig_toml
from reference_rig.thesis_experiments import inertia as inertia
from reference_rig.thesis_experiments import load_at as load_at
from reference_rig.thesis_experiments import make_impact as make_impact
from reference_rig.thesis_experiments import make_impacts as make_impacts
from reference_rig.thesis_experiments import make_tows as make_tows
from reference_rig.thesis_experiments import simulate_impact as simulate_impact
from reference_rig.thesis_experiments import write_impacts as write_impacts
from reference_rig.unmodelled import UNMODELLED_EFFECTS as UNMODELLED_EFFECTS
