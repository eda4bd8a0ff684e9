"""Observers of the friction coefficient for controllers."""

from observers.ekf import STATES, Ekf, EkfState, Tuning, build_step
from observers.protocol import Estimate, Estimates, Observer, Sample
from observers.rate import causal_rate, next_rate
from observers.run import run

__all__ = [
    "STATES",
    "Ekf",
    "EkfState",
    "Estimate",
    "Estimates",
    "Observer",
    "Sample",
    "Tuning",
    "build_step",
    "causal_rate",
    "next_rate",
    "run",
]
