"""Identification: recordings, parameters by a nonlinear programme, and the missing effect."""

from identification.decayresults import FreeDecay
from identification.decays import Decay, read_decay
from identification.diagnosis import diagnose
from identification.fitting import Fit, Values, first_values, fit, signals_of
from identification.freedecay import identify_free_decay
from identification.journal import Journal
from identification.learning import Learned, learn
from identification.loss import LEAST_SQUARES, Huber, Loss, Squares
from identification.modelfile import FoundModel, model_text, read_model
from identification.profile import Profile, profile
from identification.proposals import Proposal
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
from identification.separation import propose
from identification.signatures import Signature, Signatures, signatures
from identification.smoothing import smoothed_rate

__all__ = [
    "LEAST_SQUARES",
    "Candidate",
    "Decay",
    "Diagnosis",
    "Errors",
    "Estimate",
    "Fit",
    "FoundEffect",
    "FoundModel",
    "FreeDecay",
    "Huber",
    "Journal",
    "Learned",
    "Loss",
    "Profile",
    "Proposal",
    "Recording",
    "Series",
    "Signature",
    "Signatures",
    "Squares",
    "Unexplained",
    "Values",
    "diagnose",
    "first_values",
    "fit",
    "identify_free_decay",
    "learn",
    "model_text",
    "profile",
    "propose",
    "read_decay",
    "read_model",
    "read_recording",
    "read_rig",
    "search",
    "signals_of",
    "signatures",
    "smoothed_rate",
]
