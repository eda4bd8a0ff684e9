"""Observers of the friction coefficient for controllers."""

from observers.ekf import Ekf, EkfState, build_step
from observers.mhe import Mhe, MheState
from observers.protocol import Estimate, Estimates, Observer, Sample
from observers.rate import causal_rate, next_rate
from observers.run import run
from observers.tuning import STATES, Tuning

__all__ = [
    "STATES",
    "Ekf",
    "EkfState",
    "Estimate",
    "Estimates",
    "Mhe",
    "MheState",
    "Observer",
    "Sample",
    "Tuning",
    "build_step",
    "causal_rate",
    "next_rate",
    "run",
]
