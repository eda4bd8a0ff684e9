"""Words that a user chooses from on the command line, by the name that they have there."""

from enum import StrEnum


class ObserverName(StrEnum):
    """Observers by the name that a user gives."""

    EKF = "ekf"
    MHE = "mhe"
    ROOT = "root"


class TuningName(StrEnum):
    """Tunings by the name that a user gives."""

    REAL_TYRE = "real_tyre"
    CLEAN = "clean"
    CHANGING_GROUND = "changing_ground"
