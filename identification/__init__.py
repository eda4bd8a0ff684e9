"""Identification: recordings, parameters by a nonlinear programme, and the missing effect."""

from identification.decayresults import FreeDecay
from identification.decays import Decay, read_decay
from identification.diagnosis import diagnose
from identification.fitting import Fit, Values, first_values, fit, signals_of
from identification.freedecay import identify_free_decay
from identification.modelfile import FoundModel, model_text, read_model
from identification.recordings import Recording, read_recording
from identification.results import (
    Candidate,
    Diagnosis,
    Errors,
    Estimate,
    FoundEffect,
    Series,
    Unexplained,
)
from identification.rigfile import read_rig
from identification.selection import search
from identification.smoothing import smoothed_rate

__all__ = [
    "Candidate",
    "Decay",
    "Diagnosis",
    "Errors",
    "Estimate",
    "Fit",
    "FoundEffect",
    "FoundModel",
    "FreeDecay",
    "Recording",
    "Series",
    "Unexplained",
    "Values",
    "diagnose",
    "first_values",
    "fit",
    "identify_free_decay",
    "model_text",
    "read_decay",
    "read_model",
    "read_recording",
    "read_rig",
    "search",
    "signals_of",
    "smoothed_rate",
]
