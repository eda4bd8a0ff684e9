"""Magnitudes beyond which a recorded signal has the wrong unit or the wrong sign."""

MAX_STEERING_ANGLE = 1.6
"""Largest steering angle of a wheel [rad]."""
MAX_PLAUSIBLE_PERIOD = 0.5
"""Longest time between samples with which a wheel can be followed [s]."""
MIN_WHEEL_LOAD = 20.0
"""Least load of a wheel [N]."""
MIN_SIGN_TRAVEL = 0.2
"""Turn after which the torque's sign is judged [rad]."""
MAX_RETURNED_WORK = 0.25
"""Largest share of the work, without regard to its sign, that ground and gear give back [1]."""
