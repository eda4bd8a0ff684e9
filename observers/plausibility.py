"""Which input looks like one in another unit, or of the other sign: evidence gathered sample by sample.

| suspect | because |
|---|---|
| psi in degrees | no wheel is steered beyond a right angle |
| dt in milliseconds | samples half a second apart and more cannot follow the wheel |
| F_N in kN, torque in N mm | the torque would need a friction of more than `LARGEST_FRICTION` |
| psi or torque of the other sign | the ground takes work from a wheel that turns; this one gives it |

A few odd samples, as a faulty sensor has them, are no evidence.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import isfinite, nan

from observers.protocol import Sample
from symbolic import Rig, full_slide_torque

LARGEST_ANGLE = 1.6
"""Steering angle that is not reached [rad]."""
LONGEST_PERIOD = 0.5
"""Time between samples that is too long to follow a wheel [s]."""
LARGEST_FRICTION = 15.0
"""Friction coefficient that no ground has [1]."""
LEAST_LOAD = 20.0
"""A load below this is suspected before the torque is [N]."""
LIFTED = 0.05
"""Share of the first load below which the wheel is lifted, and a torque beside it no evidence [1]."""
IN_A_ROW = 10
"""Samples in a row that make a suspicion."""
LEAST_TRAVEL = 0.2
"""Turn after which the sign is judged [rad]."""
GIVEN_BACK = 0.25
"""Share of the work, without regard to its sign, that no ground gives back [1]."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What the samples so far say; the state of the check.

    Attributes:
        angle, period, friction: samples in a row, up to now, beyond what is possible; `IN_A_ROW` stays.
        load: the last load [N].
        first_load: the first one [N]; a wheel that is lifted, far below it, is no evidence.
        psi: the last angle [rad], NaN at the start.
        travel: turn so far without its sign, while the torque was measured [rad].
        work: of the ground on the wheel [N m].
        exchanged: the same, each sample without its sign [N m].
    """

    angle: int = 0
    period: int = 0
    friction: int = 0
    load: float = nan
    first_load: float = nan
    psi: float = nan
    travel: float = 0.0
    work: float = 0.0
    exchanged: float = 0.0


def gathered(before: Evidence, sample: Sample, rig: Rig, channel: str) -> Evidence:
    """The evidence after one more sample.

    Args:
        before: the evidence so far.
        sample: the sample; what is missing in it is no evidence.
        rig: gives the half-length.
        channel: the torque that is measured, `M_z` or `M`.
    """
    torque = sample.M_z if channel == "M_z" else -sample.M
    load = sample.F_N if sample.F_N > 0 else before.load
    first = before.first_load if isfinite(before.first_load) else load
    beyond = abs(torque) > LARGEST_FRICTION * full_slide_torque(load, rig.a)
    psi = sample.psi if isfinite(sample.psi) else before.psi
    turn = psi - before.psi
    work = torque * turn
    after = replace(
        before,
        angle=_in_a_row(before.angle, abs(sample.psi) > LARGEST_ANGLE),
        period=_in_a_row(before.period, sample.dt >= LONGEST_PERIOD),
        friction=_in_a_row(before.friction, beyond and load >= LIFTED * first),
        load=load,
        first_load=first,
        psi=psi,
    )
    if not isfinite(work):
        return after
    return replace(
        after,
        travel=before.travel + abs(turn),
        work=before.work + work,
        exchanged=before.exchanged + abs(work),
    )


def suspicions(evidence: Evidence) -> tuple[str, ...]:
    """Each suspected cause in a sentence that says what to do; empty where all is plausible."""
    load_first = evidence.load < LEAST_LOAD
    texts = {
        "psi looks like degrees, or like a steering wheel's angle: it goes beyond a right angle;"
        " convert it to rad, or divide it by the steering ratio": evidence.angle >= IN_A_ROW,
        f"time looks like milliseconds: samples are {LONGEST_PERIOD:g} s apart; convert it to s": (
            evidence.period >= IN_A_ROW
        ),
        "F_N looks like kN: the torque is more than any ground holds at it; convert it to N": (
            evidence.friction >= IN_A_ROW and load_first
        ),
        "the torque looks like N mm, or like another shaft's: it is more than any ground holds;"
        " convert it to N m at the kingpin": evidence.friction >= IN_A_ROW and not load_first,
        "psi or the torque has the other sign: the ground would turn the wheel; flip one of them": (
            evidence.travel >= LEAST_TRAVEL and evidence.work > GIVEN_BACK * evidence.exchanged > 0
        ),
    }
    return tuple(text for text, holds in texts.items() if holds)


def suspicions_of(samples: Iterable[Sample], rig: Rig, channel: str) -> tuple[str, ...]:
    """The suspicions after all samples of a recording."""
    evidence = Evidence()
    for sample in samples:
        evidence = gathered(evidence, sample, rig, channel)
    return suspicions(evidence)


def _in_a_row(before: int, holds: bool) -> int:
    if before >= IN_A_ROW:
        return before
    return before + 1 if holds else 0
