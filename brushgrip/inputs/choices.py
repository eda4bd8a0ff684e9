"""Words that a user chooses from on the command line, by the name that they have there."""

from enum import StrEnum


class ObserverName(StrEnum):
    """Observers by the name that a user gives."""

    EKF = "ekf"
    MHE = "mhe"
    ROOT = "root"


class ModelObserverName(StrEnum):
    """Observers on a model, which can be written as C and whose knowledge can be forecast."""

    EKF = "ekf"
    MHE = "mhe"


class TorqueChannel(StrEnum):
    """The torque that is measured: aligning, or steering."""

    GROUND = "M_z"
    HAND = "M"


class TuningPreset(StrEnum):
    """Tunings by the name that a user gives."""

    REAL_TYRE = "real_tyre"
    CLEAN = "clean"
    CHANGING_GROUND = "changing_ground"
