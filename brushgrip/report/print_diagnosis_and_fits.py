"""Results of a diagnosis and of free vibrations as lines and tables on the screen."""

from collections.abc import Mapping

from brushgrip.estimation.friction_by_both_models import FrictionByBothModels, found_model
from brushgrip.outputs.console import print_line, print_table, print_text, warn
from brushgrip.report.friction_summary import causes_of_band_text
from brushgrip.report.friction_verdict import verdict
from brushgrip.report.plain_summary import friction_and_notes, repeatability_in_words, summary_mail_parts
from brushgrip.report.tables import errors_by_stage, friction_by_recording, settling_and_coverage_table
from brushgrip.report.validity_and_missing_effects import notes_not_in_text
from brushgrip.wording.diagnosis_in_words import (
    GRADES,
    experiment_in_words,
    grade_reason,
    headline,
    mechanism,
    model_use_text,
    proposed_recordings,
    rivals_of,
)
from brushgrip.wording.formatting import (
    candidate_parameters,
    candidate_reason,
    effect_words,
    judging_error_before_and_after,
    listed,
    parameter_list,
    percent,
    residual_structure,
    sentence,
    signed,
    value_with_std,
)
from identification import Diagnosis, FoundModel, FreeDecay, ParameterEstimate
from identification.steering.gear_friction_on_plates import (
    PLATE_FRICTION,
    PlatesResult,
    full_slide_rack_force,
)
from identification.steering.tyres_on_known_friction import TyresResult
from identification.thesis import DecrementIdentification
from symbolic import CANDIDATES, Vehicle
from symbolic.vehicle.candidate_effects import CAR_EFFECTS

FEW = 3
"""Recordings that a line names."""
DOUBTFUL = 2.0
"""Standard deviations of a slide factor by what is declared, beyond which it is doubted."""


def print_ground_values(grounds: Mapping[str, str | None], found: FoundModel | None) -> None:
    """A line for each ground of recordings on the values that a model has for it."""
    for ground in dict.fromkeys(grounds.values() if found else ()):
        names = [name for name, one in grounds.items() if one == ground]
        if found and (taken := found.ground_used_text(ground)):
            print_line(f"{listed(names) if len(names) <= FEW else f'{len(names)} recordings'}: {taken}")


def print_diagnosis(
    diagnosis: Diagnosis, outcome: FrictionByBothModels | None = None, warning: str = ""
) -> None:
    """Print the finding, friction, errors, effects and what is unexplained; a warning goes first."""
    if warning:
        print_text(warning, style="bold")
    known, notes = friction_and_notes(outcome)
    use, why = verdict(diagnosis, outcome) if outcome else ("", [])
    judged = f"Friction: {use[:1].lower()}{use[1:]}. {' '.join(why)}".strip() * bool(use)
    for line in filter(None, (*known, judged, headline(diagnosis))):
        print_text(line, style="bold")
    for line in notes:
        print_text(line)
    if outcome:
        friction = friction_by_recording(outcome, diagnosis)
        print_table(friction.caption, friction.headings, friction.rows, overflow="fold")
        if causes := causes_of_band_text(outcome):
            print_text(causes)
    errors = errors_by_stage(diagnosis)
    title = "Torque error, root mean square, in N m and in % of range"
    print_table(title, errors.headings, errors.rows, right=True)
    print_text(f"Refitted: {diagnosis.signatures_before.summary_paragraph}")
    if diagnosis.effects:
        print_table(
            "Effects found",
            ("mechanism: effect", "grade", "parameters ± standard deviation", "indistinguishable from"),
            [
                (mechanism(e), GRADES[e.grade], parameter_list(e.parameters), rivals_of(e) or "–")
                for e in diagnosis.effects
            ],
        )
    for effect in diagnosis.effects:
        if effect.grade != "strong":
            print_text(f"{effect_words(effect.name)}, {GRADES[effect.grade]}: {grade_reason(effect)}")
    for letter, (_, proposal) in proposed_recordings(diagnosis).items():
        print_text(f"next recording {letter}: {experiment_in_words(proposal)}")
    for proposal in (e.experiment for e in diagnosis.effects if e.experiment):
        if not proposal.feasible:
            print_text(f"not separable: {experiment_in_words(proposal)}")
    if outcome:
        settling = settling_and_coverage_table(outcome, diagnosis)
        title = f"Settling and coverage of friction. {settling.caption}"
        print_table(title, settling.headings[:-1], [row[:-1] for row in settling.rows], right=True)
        print_text(
            "Settled: within 10 % of where the estimate ends. Movement: largest minus smallest estimate"
            " over the last one. Standard deviation: of μ_eff, median."
        )
    print_text(f"{residual_structure(diagnosis)} {sentence(diagnosis.unexplained.evidence)}")
    to_send, details = summary_mail_parts(diagnosis, outcome, warning) if outcome else ([], [])
    told = " ".join(item for _, items in (*to_send, *details) for item in items)
    for note in notes_not_in_text(diagnosis, told):
        print_text(f"note: {note}")
    for line in filter(None, [repeatability_in_words(diagnosis), *rejected_user_effects(diagnosis)]):
        print_text(line)
    print_text(model_use_text(diagnosis, found_model(diagnosis)))
    for title, parts in (("Before you act on it", details), ("To send", to_send)):
        if parts:
            print_text(title, style="bold")
        for label, items in parts:
            print_text("\n- ".join([f"{label}:", *items]) if len(items) > 1 else f"{label}: {items[0]}")


def rejected_user_effects(diagnosis: Diagnosis) -> list[str]:
    """A line for each effect of the user's own that was not added: what it is worth, and why not."""
    added = {effect.name for effect in diagnosis.effects}
    _, before, _ = judging_error_before_and_after(diagnosis)
    return [
        f"{effect_words(c.name)}, of your own, was not added. In the refitted model, without the effects"
        f" found: {candidate_parameters(c) or 'by recording'}; error {percent(before)} →"
        f" {percent(c.holdout_nrmse)} of range with it alone, ΔBIC {signed(c.delta_bic)};"
        f" {candidate_reason(diagnosis, c)}"
        for c in diagnosis.candidates
        if c.name not in {*added, *CANDIDATES, *CAR_EFFECTS}
    ]


def print_free_decay(result: FreeDecay, decrement: DecrementIdentification) -> None:
    """Print k and b_t by maximum likelihood and by [Györök 2022], and what determines them."""
    rough_k, with_J_A, as_printed = (
        value_with_std(ParameterEstimate(value=value, std=None, unit=unit))
        for value, unit in (
            (decrement.k, result.k.unit),
            (decrement.b_t, result.b_t.unit),
            (decrement.b_t_printed, "1/s"),
        )
    )
    print_table(
        f"From {len(result.vibrations)} free vibrations",
        ("", "k", "b_t"),
        [
            ("maximum likelihood", value_with_std(result.k), value_with_std(result.b_t)),
            ("FFT and decrement, (5.8) with J_A", rough_k, with_J_A),
            ("FFT and decrement, (5.8) as printed", rough_k, as_printed),
        ],
    )
    forces = [
        f"{value_with_std(contact.force)} at a = {1000 * contact.a:g} mm"
        for contact in result.contacts
        if contact.force is not None
    ]
    if forces:
        print_text(f"The ends of the patch slide as with μ F_N = {', '.join(forces)}.")
    for line in result.identifiability:
        print_text(line)


def print_car_result(result: PlatesResult | TyresResult, car: Vehicle) -> None:
    """Print what was identified of a car, what that rests on, and what it holds for."""
    rows = [(name, value_with_std(one)) for name, one in result.parameters.items()]
    headings = ("", "value ± standard deviation")
    if isinstance(result, PlatesResult):
        print_table("Steering, wheels on plates", headings, rows)
        if result.damping.value < -2 * (result.damping.std or 0.0):
            warn("damping is below zero, as if gear friction fell with speed: the file gets 0")
        print_line(
            f"friction of the turntables is taken to be {PLATE_FRICTION:g} at most; each 0.01 more,"
            f" as of greased plates, is told as {0.01 * full_slide_rack_force(car):.0f} N of gear"
        )
        return
    rows.append(("unexplained, of full slide (rms)", percent(result.rest)))
    print_table("Tyres", headings, rows)
    print_line(
        f"slide_factor holds for a front axle load of {car.front_axle_load:g} N, these tyres and"
        " this pressure; declare another load where passengers or cargo change it, and identify"
        " anew where by more than a tenth"
    )
    if abs(result.deviations) > DOUBTFUL:
        warn(
            f"slide_factor {result.slide_factor.value:.2f} is"
            f" {abs(result.deviations):.1f} standard deviations from what the vehicle file"
            " declares: check --ground-friction, front_axle_load and half_length; if the ground"
            " is wrong by a share, all later friction is wrong by it"
        )
