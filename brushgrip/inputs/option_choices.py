"""Words that a user chooses from on the command line; the value of each is its name there."""

from enum import StrEnum

ObserverName = StrEnum("ObserverName", ["EKF", "MHE", "ROOT"])
ModelObserverName = StrEnum("ModelObserverName", ["EKF", "MHE"])
"""Observers on a model, which can be written as C and whose knowledge can be forecast."""
TorqueChannel = StrEnum("TorqueChannel", {"GROUND": "M_z", "HAND": "M"})
"""The torque that is measured: aligning, or steering."""
TuningPreset = StrEnum("TuningPreset", ["REAL_TYRE", "CLEAN", "CHANGING_GROUND"])
