"""Observers of the friction coefficient for controllers."""

from observers.estimates import Estimates, Innovations, innovations
from observers.estimators.casadi_observer import CasadiObserver
from observers.estimators.ekf import Ekf
from observers.estimators.mhe import Mhe
from observers.interfaces.car_observer import RackSampler, car_observer, run_standstills
from observers.interfaces.control_loop import Loop
from observers.interfaces.observer_from_files import aligning_torque_for, from_files
from observers.interfaces.run import run
from observers.interfaces.smoothing import smooth
from observers.interfaces.tuning_profiles import PROFILES, profile, tuning_for
from observers.layout import Layout, ObserverState
from observers.measurement.causal_yaw_rate import causal_rate, next_rate
from observers.measurement.directional_friction import DirectionalFriction
from observers.measurement.measurement_model import CLEAN, AligningTorque, MeasurementModel
from observers.measurement.motion_and_torque_jacobians import build_clean
from observers.measurement.rack_force import RackForce
from observers.measurement.steering_torque_as_input import SteeringTorque
from observers.planning.advice_and_stop_reasons import Advice
from observers.planning.plan import Plan, plan
from observers.planning.probe import Probe
from observers.planning.steering_limits_and_paths import SteeringLimits
from observers.planning.uncertainty_budget import uncertainty_budget
from observers.protocol import (
    ESTIMATE,
    OUTPUT,
    SAMPLE,
    BatchObserver,
    Estimate,
    FunctionObserver,
    Observer,
    Sample,
    Status,
)
from observers.quality.agreement_with_final_estimate import (
    SelfConsistency,
    friction_spread,
    self_consistency,
)
from observers.quality.friction_across_recordings import GroundFriction, ground_friction
from observers.quality.wrong_units_or_signs import suspicions_of
from observers.thesis.root_observer import RootObserver, ZoneRootState
from observers.thesis.zone_state_machine import ZoneHistory, zone_history
from observers.tuning import Tuning
from observers.udu import covariance_of

__all__ = [
    "CLEAN",
    "ESTIMATE",
    "OUTPUT",
    "PROFILES",
    "SAMPLE",
    "Advice",
    "AligningTorque",
    "BatchObserver",
    "CasadiObserver",
    "DirectionalFriction",
    "Ekf",
    "Estimate",
    "Estimates",
    "FunctionObserver",
    "GroundFriction",
    "Innovations",
    "Layout",
    "Loop",
    "MeasurementModel",
    "Mhe",
    "Observer",
    "ObserverState",
    "Plan",
    "Probe",
    "RackForce",
    "RackSampler",
    "RootObserver",
    "Sample",
    "SelfConsistency",
    "Status",
    "SteeringLimits",
    "SteeringTorque",
    "Tuning",
    "ZoneHistory",
    "ZoneRootState",
    "aligning_torque_for",
    "build_clean",
    "car_observer",
    "causal_rate",
    "covariance_of",
    "friction_spread",
    "from_files",
    "ground_friction",
    "innovations",
    "next_rate",
    "plan",
    "profile",
    "run",
    "run_standstills",
    "self_consistency",
    "smooth",
    "suspicions_of",
    "tuning_for",
    "uncertainty_budget",
    "zone_history",
]
__dir__ = __all__.copy
