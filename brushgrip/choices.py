"""Words that a user chooses from on the command line, by the name that they have there."""

from enum import StrEnum


class ObserverName(StrEnum):
    """Observers by the name that a user gives."""

    EKF = "ekf"
    MHE = "mhe"
    ROOT = "root"


class GeneratedObserver(StrEnum):
    """Observers that can be written out."""

    EKF = "ekf"
    MHE = "mhe"


class RealType(StrEnum):
    """Types of number by their name in C."""

    FLOAT = "float"
    DOUBLE = "double"


class Target(StrEnum):
    """What `codegen` writes."""

    C = "c"
    FMU = "fmu"
    FMU3 = "fmu3"
    ROS2 = "ros2"


class RunTime(StrEnum):
    """What generated code takes at run time."""

    TUNING = "tuning"
    ALL = "all"


class TorqueChannel(StrEnum):
    """Which torque the target measures, by its name in recordings."""

    GROUND = "M_z"
    HAND = "M"


class TuningName(StrEnum):
    """Tunings by the name that a user gives."""

    REAL_TYRE = "real_tyre"
    CLEAN = "clean"
    CHANGING_GROUND = "changing_ground"


class Published(StrEnum):
    """Sets of recordings that can be fetched."""

    WHEEL = "wheel"
    FRICTION_DAMPER = "friction-damper"
