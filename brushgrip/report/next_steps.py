"""What to do next after a diagnosis, for somebody who knows no tyre model."""

from collections.abc import Sequence
from math import sqrt
from statistics import fmean

from brushgrip.estimation.friction_by_both_models import FrictionByBothModels
from brushgrip.estimation.recording_warnings import SUSPECTED
from brushgrip.report.friction_and_found_stiffness import stiffness_explanations
from brushgrip.report.friction_summary import is_band_mostly_from_spread, variance_shares_by_cause
from brushgrip.report.what_effects_do import effect_size_text
from brushgrip.wording.diagnosis_in_words import (
    CLEAR,
    doubtful_effects,
    find_note,
    is_single_recording,
    is_validation_wheel_doubtful,
    proposed_recordings,
    unexplained_is_larger,
)
from brushgrip.wording.formatting import (
    band_decimals,
    effect_words,
    listed,
    percent,
    sentence,
    unrefitted_error,
)
from brushgrip.wording.friction_in_words import how_to_narrow_band
from identification import Diagnosis, FoundEffect
from identification.diagnosis.graded_effects import ASSUMED, UNRECORDED_LOAD
from observers.quality.agreement_with_final_estimate import BAND_95
from observers.tuning import OF_LENGTHS, OF_LOAD

TOLD = 0.95
"""Of a ± up to which one that is narrower is told."""
MAX_STEPS = 4
"""What to do next that is told."""
CHECKS = {
    False: "whoever keeps the rig file: find where the declared stiffness comes from; whoever runs the"
    " rig: check the torque (its zero with nothing on it, then a known weight on a lever), the angle (a"
    " known turn), the gear ratios and the half-length of the contact (an ink print at each load). If a"
    " factor or a length was wrong and is known now, correct it in the rig file and run this program"
    " again; if something had to be repaired, record again: every figure here may change. If"
    " the rig proves right and the declared stiffness was guessed or is another tyre's, declare the one"
    " found (k under [tyre] in the rig file), which settles it. If rig and declared stiffness both prove"
    " right, all figures stay provisional until further recordings tell why the fitted one differs",
    True: "check the force's unit and motor_ratio: steer from lock to lock on ground of known friction,"
    " which gives scale and stiffness (brushgrip identify --lock-to-lock)",
}
"""What a stiffness far from the declared one asks for, of a rig and of a car."""
STIFFNESS = "tread stiffness k"
PART_OF_BAND = {"half-length a": OF_LENGTHS, "caster e": OF_LENGTHS, "load": OF_LOAD}
"""The part of a band that each value makes whose tolerance is assumed.

That of k is no narrower where it is declared: it then counts what the torque's scale may be off by.
"""
HARDLY = "; that hardly narrows the ±"
"""Of what is to be declared."""
OF_ZERO = {
    "torque_offset": "a zero error of the torque", "zero_drift": "a drift of the torque's zero",
}  # fmt: skip
"""What an effect is where a check at the rig may rule it out."""


def next_steps(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> list[str]:
    """Measurements or actions that come next, the most urgent first, at most `MAX_STEPS`, each a phrase.

    Where nothing is open, what narrows the ± of friction.
    """
    steps = []
    if diagnosis.notes and diagnosis.notes[0].startswith(SUSPECTED):
        steps.append("mend the input that looks wrong, or leave its recording out, and run this again")
    if stiffness_explanations(diagnosis):
        steps.append(CHECKS[diagnosis.of_car])
    if outcome.inclination is not None:
        steps.append("check the inclination of the steering axes, and declare it in the vehicle file")
    never = outcome.recordings_without_friction()
    # A model that misses more than it has found is why friction is not known.
    if never and not unexplained_is_larger(diagnosis):
        steps.append(
            f"record {listed(never)} again, turning to and fro until the wheel slides both ways"
        )
    if is_single_recording(diagnosis):
        steps.append("make a second recording, without which nothing judges the result")
    like_load = [
        effect_words(e.name) for e in diagnosis.effects if UNRECORDED_LOAD in e.indistinguishable_from
    ]
    if like_load:
        steps.append(
            f"record the load, as one that changes with the angle would look like {listed(like_load)}"
        )
    steps += _recordings_for_the_model(diagnosis)
    doubted = is_validation_wheel_doubtful(diagnosis)
    check = _check_validation_wheel(diagnosis)
    steps += check * doubted
    unconfirmed, *_ = doubtful_effects(diagnosis)
    if unconfirmed:
        steps.append(
            "fit a recording of each ground (with --holdout, leave that out), which settles whether"
            f" {listed(unconfirmed)} is there"
        )
    weak = [effect_words(e.name) for e in diagnosis.effects if e.grade in ("weak", "stands_in")]
    if weak and not steps:
        steps.append(f"make more recordings, which settle whether {listed(weak)} is there")
    more, declare = _more_recordings(outcome), _tolerances_to_declare(diagnosis, outcome)
    narrow = [] if steps else _steps_to_narrow_band(outcome, told_apart=declare)
    if stiffness_explanations(diagnosis):  # Both at the rig.
        after = steps.index(CHECKS[diagnosis.of_car]) + 1
        steps, declare = [*steps[:after], *declare, *steps[after:]], []
    if not steps:
        hardly = any(HARDLY in one for one in declare)
        steps, declare = (narrow, declare) if hardly else ([*declare, *narrow], [])
    last = [*_steps_on_play(diagnosis), *declare, *check * (not doubted)]
    return [*steps[: MAX_STEPS - len(more)], *more, *last][:MAX_STEPS] or ["nothing"]


def _steps_on_play(diagnosis: Diagnosis) -> list[str]:
    """That play which was found may be removed or left."""
    return [
        f"look for the play of {effect_size_text(e)} between angle sensor and tyre and remove it (then"
        " record everything again), or leave it: the model allows for it"
        for e in diagnosis.effects
        if e.name == "backlash" and e.grade in CLEAR
    ]


def _tolerances_to_declare(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> list[str]:
    """That tolerances are to be declared, and what that brings; empty where all are."""
    # Not k where that is to be declared first.
    parts = find_note(diagnosis, ASSUMED).partition(": ")[2].split(", ")
    names = [name for part in parts if (name := part.split(" ±")[0].split(" (")[0])]
    if stiffness_explanations(diagnosis):
        names = [name for name in names if name != STIFFNESS]
    if not names:
        return []
    brought = _best_possible_band_text(outcome, *{PART_OF_BAND.get(name, "") for name in names})
    visit = "at the rig, on the same visit, " * bool(stiffness_explanations(diagnosis))
    was, tolerances = ("was", "its tolerance") if len(names) == 1 else ("were", "the tolerances")
    return [
        f"{visit}find out how well {listed(names)} {was} measured (measure what was guessed), and"
        f" declare {tolerances} in the rig file"
        + (brought or HARDLY * bool(outcome.prediction_band_by_ground()))
    ]


def _recordings_for_the_model(diagnosis: Diagnosis) -> list[str]:
    """What recordings would tell more of the model."""
    apart = what_experiments_separate(diagnosis)
    by_zero = all(p.rival in OF_ZERO for _, p in proposed_recordings(diagnosis).values())
    unchecked = ", if the torque's zero cannot be checked," * by_zero
    proposed = f"stands under “Next recording”, which tells {apart}"
    if diagnosis.unexplained.present:
        still = "if something unknown remains after (1)"
        return [
            f"{still if stiffness_explanations(diagnosis) else 'as something unknown remains'}, record"
            " at other steering speeds, steering angles and loads to find it; friction may change then"
            + f"; begin{unchecked} with what {proposed}"
            * bool(apart)
        ]
    return [f"record what {proposed}"] * bool(apart)


def _check_validation_wheel(diagnosis: Diagnosis) -> list[str]:
    """That the recordings that judge may be of another wheel, as nothing adjusted they fit worse."""
    unrefitted = unrefitted_error(diagnosis)
    if unrefitted is None or diagnosis.unexplained.present:
        return []
    nothing = diagnosis.after.unrefitted
    worst = max(nothing, key=lambda name: nothing[name])
    return [
        "check that the validation recordings are of the same wheel, load and ground, as with nothing"
        f" adjusted to them the error is {percent(unrefitted)} of range, most in {worst}"
        f" ({percent(nothing[worst])})"
    ]


def _more_recordings(outcome: FrictionByBothModels) -> list[str]:
    """That more recordings narrow the widest ± of those that are wide by how recordings differ."""
    wide = {
        g: one for g, one in outcome.last_usable_by_ground().items() if is_band_mostly_from_spread(one)
    }
    if not wide:
        return []
    ground, one = max(wide.items(), key=lambda own: own[1].further or 0.0)
    count, half = one.recordings, one.further or 0.0
    digits, more = band_decimals(half), one.further_half_width(2 * count)
    seconds = fmean(float(track.t[-1] - track.t[0]) for track, _ in outcome.known_tracks(ground))
    return [
        f"record {ground} {count} more times, {seconds:.0f} s each like these, at the load that you need"
        f" friction for: ± {half:.{digits}f} would come to about ± {more:.{digits}f} if they differ as"
        " much as these, or to less if it is their loads that make these differ"
    ]


def _steps_to_narrow_band(outcome: FrictionByBothModels, told_apart: Sequence[str]) -> list[str]:
    """What narrows the ± of friction, if nothing says that yet."""
    cause = next(iter(variance_shares_by_cause(outcome)), "")
    said = cause in PART_OF_BAND.values() and told_apart
    return [
        f"to narrow the ±, {how_to_narrow_band(cause)}{_best_possible_band_text(outcome, cause)}"
    ] * bool(cause and not said)


def limits_of_further_recordings(diagnosis: Diagnosis, steps: Sequence[str]) -> str:
    """That no recording would settle what is open, or none beyond steps, in sentences; else empty."""
    if diagnosis.unexplained.present:
        return ""
    told = [inseparable_text(e) for e in diagnosis.effects if e.experiment and not e.experiment.feasible]
    if all(e.grade == "strong" for e in diagnosis.effects):
        asked = [f"({at})" for at, one in enumerate(steps, 1) if one.startswith(("record ", "make "))]
        beyond = listed(asked) if len(steps) > 1 else "what is to do first"
        told.append(f"none beyond {beyond}" if asked else "none is needed to find the model")
    return " ".join(map(sentence, told))


def inseparable_text(effect: FoundEffect) -> str:
    """That recordings do not settle which of several effects it is."""
    rivals = effect.indistinguishable_from or tuple(e.rival for e in (effect.experiment,) if e)
    others = listed([effect_words(name) for name in rivals], "or")
    return f"a usual manoeuvre, repeated, would not tell {effect_words(effect.name)} from {others}"


def what_experiments_separate(diagnosis: Diagnosis) -> str:
    """Which effects the proposed recordings would tell from which, and from which not."""
    proposed = proposed_recordings(diagnosis)
    pairs = [
        f"{effect_words(e.name)} from {OF_ZERO.get(p.rival, effect_words(p.rival))}"
        f" (recording {at}, {p.manoeuvre.seconds * (p.times or 1):.0f} s)"
        for at, (e, p) in proposed.items()
    ]
    more = any(set(e.indistinguishable_from) - {p.rival} for e, p in proposed.values())
    return listed(pairs) + "; other explanations stay possible" * more


def _best_possible_band_text(outcome: FrictionByBothModels, *causes: str) -> str:
    """What the bands of grounds are without what a remedy addresses; empty where none has a band."""
    changes = []
    for ground, one in outcome.prediction_band_by_ground().items():
        squares = [float(track.mu_std[at]) ** 2 for track, at in outcome.known_tracks(ground)]
        shares, half = variance_shares_by_cause(outcome, ground), one.further or 0.0
        share = sum(shares.get(cause, 0.0) for cause in causes)
        best = sqrt(max(0.0, half**2 - share * BAND_95**2 * fmean(squares)))
        digits = band_decimals(half)
        old, new = f"± {half:.{digits}f}", f"± {best:.{digits}f}"
        changes += [f"{old} to {new} on {ground}"] * (best < TOLD * half and old != new)
    return f"; that lowers {listed(changes)} at best" * bool(changes)
