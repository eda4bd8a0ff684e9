"""Flags of a sample's status in generated code, with what to do about each."""

from observers.protocol import Status

REFUSED = 128
"""Status of a sample that generated code ignores; Python raises an error there."""
STATUS_FLAGS = (
    *((str(flag.name), int(flag), flag.remedy) for flag in Status if flag & ~Status.NO_ROOT),
    (
        "REFUSED",
        REFUSED,
        "dt out of range, the sample was ignored; or an estimate was not finite; or the state is none"
        " of this code",
    ),
)
"""Name, number and remedy of every status that generated code can set."""
