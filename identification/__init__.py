"""Identification: recordings, parameters by nonlinear programming, and the missing effect."""

from identification.diagnosis.diagnose import diagnose
from identification.diagnosis.model_file import model_text, read_model
from identification.diagnosis.result import Diagnosis
from identification.diagnosis.result_parts import (
    Candidate,
    Curve,
    FoundEffect,
    FoundFamily,
    Series,
    TorqueErrors,
)
from identification.experiments.discriminating_experiment import propose
from identification.experiments.model_separation import Proposal
from identification.fits.fitting import Fit, fit
from identification.fits.least_squares_problem import signals_of
from identification.fits.loss import LEAST_SQUARES, Huber, Loss, Squares
from identification.fits.options import FitOptions
from identification.fits.profile_likelihood import LIMIT, Profile, profile
from identification.fits.values_by_ground_and_recording import (
    ParameterEstimate,
    Values,
    initial_guess,
    replaced_rig,
)
from identification.free_decay.recording import Decay, read_decay
from identification.free_decay.results import FreeDecay, VibrationFit
from identification.free_decay.stiffness_and_damping_by_likelihood import identify_free_decay
from identification.reading.car_as_mean_wheel import Standstills, read_vehicle
from identification.reading.checked_sample_table import Table
from identification.reading.conditioning import (
    Channel,
    LowPass,
    OffsetRemoved,
    Pipeline,
    Resampler,
    Scaled,
    default_pipeline,
    recording_from_raw,
)
from identification.reading.readers import READERS, Reader
from identification.reading.recordings import Recording, read_recording
from identification.reading.rigfile import read_rig, read_signals
from identification.reading.signal_map import SignalMap, SignalSource, parse_signals
from identification.reading.yaw_rate_from_angle import smoothed_rate
from identification.residuals.partial_correlations import SignalCorrelation, Signatures, signatures
from identification.residuals.residual_signals import RESIDUAL_SIGNALS
from identification.residuals.residual_structure import Unexplained
from identification.selection.criteria import SelectionCriteria
from identification.selection.stepwise_search import search
from identification.selection.trial_journal import Journal
from identification.thesis.block_towing import Tow, TowedFriction, friction_by_towing
from symbolic import FoundModel

__all__ = [
    "LEAST_SQUARES",
    "LIMIT",
    "READERS",
    "RESIDUAL_SIGNALS",
    "Candidate",
    "Channel",
    "Curve",
    "Decay",
    "Diagnosis",
    "Fit",
    "FitOptions",
    "FoundEffect",
    "FoundFamily",
    "FoundModel",
    "FreeDecay",
    "Huber",
    "Journal",
    "Loss",
    "LowPass",
    "OffsetRemoved",
    "ParameterEstimate",
    "Pipeline",
    "Profile",
    "Proposal",
    "Reader",
    "Recording",
    "Resampler",
    "Scaled",
    "SelectionCriteria",
    "Series",
    "SignalCorrelation",
    "SignalMap",
    "SignalSource",
    "Signatures",
    "Squares",
    "Standstills",
    "Table",
    "TorqueErrors",
    "Tow",
    "TowedFriction",
    "Unexplained",
    "Values",
    "VibrationFit",
    "default_pipeline",
    "diagnose",
    "fit",
    "friction_by_towing",
    "identify_free_decay",
    "initial_guess",
    "model_text",
    "parse_signals",
    "profile",
    "propose",
    "read_decay",
    "read_model",
    "read_recording",
    "read_rig",
    "read_signals",
    "read_vehicle",
    "recording_from_raw",
    "replaced_rig",
    "search",
    "signals_of",
    "signatures",
    "smoothed_rate",
]
__dir__ = __all__.copy
