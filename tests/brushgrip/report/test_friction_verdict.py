"""Whether friction may be used: each fact that speaks against it, alone, and none."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from brushgrip.estimation.friction_by_both_models import FrictionByBothModels
from brushgrip.estimation.recording_warnings import MAY_END, SUSPECTED
from brushgrip.report.friction_verdict import CARE, NOT_YET, NOTHING, USE, verdict
from identification import Diagnosis
from identification.diagnosis.from_search import BEYOND_RANGE
from identification.diagnosis.graded_effects import ASSUMED, STOPPED_EARLY
from observers import Status
from tests.brushgrip.factories import make_diagnosis, make_outcome, make_track

NAMES = ("a", "b", "c", "d")
SOUND = make_diagnosis(NAMES, (), unexplained=False)
TRACKS = tuple(make_track(name, mu) for name, mu in zip(NAMES, (1.19, 1.2, 1.2, 1.21), strict=True))
KNOWN = make_outcome(tracks=TRACKS, grounds={"ice": NAMES})


def graded(grade: Any, **changes: Any) -> Diagnosis:
    first, second = SOUND.effects
    return replace(SOUND, effects=(first, replace(second, grade=grade, **changes)))


def unexplained(structured: float, diagnosis: Diagnosis = SOUND) -> Diagnosis:
    return replace(
        diagnosis, unexplained=replace(SOUND.unexplained, present=True, structured=structured)
    )


def of(*values: float, **grounds: tuple[str, ...]) -> FrictionByBothModels:
    tracks = tuple(make_track(name, mu) for name, mu in zip(NAMES, values, strict=False))
    return make_outcome(tracks=tracks, grounds=grounds or {"ice": NAMES})


def with_nothing_adjusted(before: float, after: float) -> Diagnosis:
    """Errors of the validation recording d without and with the effects found."""
    judged = make_diagnosis(NAMES[:3], NAMES[3:], unexplained=False)
    old, new = (
        replace(stage, unrefitted={"d": error})
        for stage, error in ((judged.before, before), (judged.after, after))
    )
    return replace(judged, before=old, after=new)


NEVER = replace(TRACKS[3], usable=np.zeros(11, dtype=bool))
ENDED = replace(TRACKS[3], usable=np.arange(11) < 9, last_status=Status.INCONSISTENT)
LOADS = replace(
    SOUND,
    recordings=tuple("abcdef"),
    series=tuple(
        replace(SOUND.series[0], name=name, F_N=np.full(600, 400.0 + 10 * i))
        for i, name in enumerate("abcdef")
    ),
)
RISING = make_outcome(
    tracks=tuple(make_track(name, 1.2 + 0.01 * i) for i, name in enumerate("abcdef")),
    grounds={"ice": tuple("abcdef")},
)
HALF = replace(SOUND, recordings=("a",), holdout=())


@pytest.mark.parametrize(
    ("label", "diagnosis", "outcome", "why"),
    [
        (USE, SOUND, KNOWN, "Nothing in these recordings speaks against it. The ± holds if"),
        (USE, replace(SOUND, notes=("c got worse",)), KNOWN, ""),
        (
            USE,
            replace(SOUND, notes=(f"{ASSUMED}: caster e (kingpin to contact) ± 2 mm, load ± 2 %",)),
            KNOWN,
            "right to caster e ± 2 mm, load ± 2 %: assumed, as nobody said",
        ),
        (USE, graded("ambiguous"), KNOWN, ""),
        (NOTHING, SOUND, make_outcome(tracks=(NEVER,)), ""),
        (NOT_YET, replace(SOUND, notes=(f"{SUSPECTED}: c",)), KNOWN, "An input looks wrong"),
        (NOT_YET, replace(SOUND, stiffness_ratio=1.6), KNOWN, "1.60 times as stiff as declared. Do not"),
        (NOT_YET, replace(SOUND, notes=(f"{MAY_END}: c",)), KNOWN, "The torque may end by its sensor"),
        (NOT_YET, unexplained(0.06), KNOWN, "unknown cause, 6.00 % of its range"),
        (CARE, unexplained(0.012), KNOWN, "have shown the unknown cause. Friction may change then."),
        (CARE, unexplained(0.03), KNOWN, "unknown cause, 3.00 % of its range, more than what was"),
        (NOT_YET, unexplained(0.03), of(1.2, 1.2), "and before 3 recordings on ice give one. Friction"),
        (NOT_YET, unexplained(0.03, HALF), of(1.2), "it rests on one recording, which nothing checks"),
        (CARE, HALF, of(1.2), "It rests on one recording, which nothing checks. Do not specify to it"),
        (CARE, SOUND, of(1.2, 1.2, ice=NAMES[:2]), "On ice fewer than 3 recordings give a value"),
        (CARE, SOUND, of(1.2, 1.2, 1.2, 1.2, **{"": NAMES}), "Each value is that of its recording"),
        (CARE, SOUND, of(1.0, 1.2, 1.2, 1.4), "before more recordings on ice have narrowed its ±."),
        (
            CARE,
            SOUND,
            make_outcome(
                tracks=tuple(replace(t, mu_std=np.full(11, 0.3)) for t in TRACKS), grounds={"ice": NAMES}
            ),
            "The ± on ice is 49 % of friction. Do not specify to it before that on ice is narrower.",
        ),
        (CARE, LOADS, RISING, "Friction goes with the load"),
        (CARE, SOUND, replace(KNOWN, tracks=(*TRACKS[:3], NEVER)), "D gave no value"),
        (CARE, SOUND, replace(KNOWN, tracks=(*TRACKS[:3], ENDED)), "not explain the end of d"),
        (CARE, replace(SOUND, notes=(f"{BEYOND_RANGE}, so",)), KNOWN, "inferred from what is below"),
        (CARE, replace(SOUND, notes=(f"{STOPPED_EARLY} (x)",)), KNOWN, "The fit stopped early"),
        (CARE, replace(SOUND, inclination=0.3), KNOWN, "The steering axes seem to be inclined"),
        (
            CARE,
            replace(SOUND, notes=("a: load is at the end of its tolerance, 1.1",)),
            KNOWN,
            "The recordings want a length, a load or a zero other than declared",
        ),
        (
            CARE,
            replace(SOUND, notes=("all 4 recordings want e more than the declared 0 m, 1 m",)),
            KNOWN,
            "other than declared",
        ),
        (USE, with_nothing_adjusted(0.1, 0.07), KNOWN, ""),
        (CARE, with_nothing_adjusted(0.09, 0.07), KNOWN, "With nothing adjusted what was found hardly"),
        (CARE, graded("stands_in"), KNOWN, "The model has a correction whose cause is not known. Do"),
        (CARE, graded("weak"), KNOWN, "The model allows for torque offset, which may be chance"),
        (
            CARE,
            graded("weak", standard_errors=2.5, deviations=99.0),
            KNOWN,
            "which the recordings that judge do not confirm",
        ),
        (USE, replace(graded("weak"), of_car=True), KNOWN, ""),
    ],
)
def test_each_fact_that_speaks_against_friction_alone(
    label: str, diagnosis: Diagnosis, outcome: FrictionByBothModels, why: str
) -> None:
    told, reasons = verdict(diagnosis, outcome)
    reason = " ".join(reasons)
    assert (told, why in reason) == (label, True), reason
    assert ("Do not specify to it before" in reason) == (label in (CARE, NOT_YET))


def test_the_gravest_goes_first_and_not_too_many_are_told() -> None:
    doubtful = replace(
        unexplained(0.012, graded("weak")),
        notes=(f"{BEYOND_RANGE}, so", f"{SUSPECTED}: c", f"{STOPPED_EARLY}"),
    )
    label, why = verdict(doubtful, replace(KNOWN, tracks=(*TRACKS[:3], NEVER)))
    assert (label, len(why)) == (NOT_YET, 4 + 1)
    assert why[0] == "An input looks wrong, which may make it void."
    assert why[1].startswith("The torque shows something of")
    assert "before it is mended, and before recordings at other steering speeds" in why[-1]


def test_a_ground_without_a_doubt_of_its_own_may_be_specified_to() -> None:
    wide = [make_track(name, mu) for name, mu in zip("efg", (1.0, 1.2, 1.4), strict=True)]
    both = make_outcome(tracks=(*TRACKS, *wide), grounds={"ice": NAMES, "snow": ("e", "f", "g")})
    allowed = " Ice may be specified to with the ± told, if what was declared is right."
    _, (why,) = verdict(SOUND, both)
    assert "3 recordings on snow differ so much" in why
    assert why.endswith(f"before more recordings on snow have narrowed its ±.{allowed}")
    _, (why,) = verdict(graded("weak"), both)
    assert "Ice may" not in why, "a doubt of all grounds"
