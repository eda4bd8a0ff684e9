"""Flags of a sample's status in generated code, with what to do about each in the names of C."""

from observers.protocol import Status

REFUSED = 128
"""Status of a sample that generated code ignores; Python raises an error there."""
REMEDIES = {
    Status.MISSING: "no measurement, predicted through: check the sensor if it lasts",
    Status.HELD: "angle, load or steering torque missing, the last one used: check the sensor if it"
    " lasts",
    Status.REJECTED: "measurement beyond the gate, rejected: if it lasts without a reset,"
    " raise gate or noise",
    Status.RESET: "the ground has changed, mu is being learnt anew: wait until informed",
    Status.BOUND: "mu is on its bound: check k, a, F_N and the sign of the torque, or widen the bounds",
    Status.UNSETTLED: "the last Gauss-Newton step moved mu by more than its standard deviation: raise"
    " iterations",
    Status.INCONSISTENT: "model and stated error do not explain the torque, mu_std is too small: check"
    " units, a, F_N and k, find what the model lacks (brushgrip diagnose), or raise error",
    Status.IMPLAUSIBLE: "a value is beyond its limit or psi jumps, and is left out: check the sensor, or"
    " raise the limits of the tuning",
    Status.ACQUIRING: "friction is being acquired: turn on, or turn back once, and where that does not"
    " help, correct k or declare its tolerance",
    Status.SUSPECT: "an input looks wrong by its unit, its sign, its gear or its sensor, or k, a and F_N"
    " do not belong to this tyre",
}
"""Meaning and remedy of every flag that generated code can set."""
STATUS_FLAGS = (
    *((str(flag.name), int(flag), remedy) for flag, remedy in REMEDIES.items()),
    ("REFUSED", REFUSED, "dt out of range, the sample was ignored; or an estimate was not finite"),
)
"""Name, number and remedy of every status."""
