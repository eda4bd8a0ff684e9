"""Identification: recordings, parameters by a nonlinear programme, and the missing effect."""

from identification.diagnosis import diagnose
from identification.fitting import Fit, Values, first_values, fit, signals_of
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
    "Diagnosis",
    "Errors",
    "Estimate",
    "Fit",
    "FoundEffect",
    "FoundModel",
    "Recording",
    "Series",
    "Unexplained",
    "Values",
    "diagnose",
    "first_values",
    "fit",
    "model_text",
    "read_model",
    "read_recording",
    "read_rig",
    "search",
    "signals_of",
    "smoothed_rate",
]
