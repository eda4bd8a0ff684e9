"""Observers of the friction coefficient for controllers."""

from observers.course import Course, course
from observers.ekf import Ekf
from observers.factor import covariance_of
from observers.files import from_files
from observers.layout import Layout, State
from observers.loop import Loop
from observers.mhe import Mhe
from observers.protocol import SAMPLE, BatchObserver, Estimate, Estimates, Observer, Sample, Status
from observers.rate import causal_rate, next_rate
from observers.root import Root, RootState
from observers.run import run
from observers.sensing import AligningTorque, Sensing
from observers.steering import SteeringTorque
from observers.tuning import STATES, Tuning

__all__ = [
    "SAMPLE",
    "STATES",
    "AligningTorque",
    "BatchObserver",
    "Course",
    "Ekf",
    "Estimate",
    "Estimates",
    "Layout",
    "Loop",
    "Mhe",
    "Observer",
    "Root",
    "RootState",
    "Sample",
    "Sensing",
    "State",
    "Status",
    "SteeringTorque",
    "Tuning",
    "causal_rate",
    "course",
    "covariance_of",
    "from_files",
    "next_rate",
    "run",
]
