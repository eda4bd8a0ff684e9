"""The stiffness that was found, what it may mean, and what friction is then, in words."""

from brushgrip.estimation.friction_by_both_models import FrictionByBothModels
from brushgrip.wording.formatting import band_decimals, listed, sentence
from identification import Diagnosis
from identification.diagnosis.found_vs_declared_stiffness import OFF_STIFFNESS

MEANING = ", how steeply the torque rises before anything slides, is"
"""What the stiffness k is, behind its name."""


def stiffness_explanations(diagnosis: Diagnosis) -> list[str]:
    """The stiffness beyond its tolerance, then each thing that it may mean; of several, only those."""
    notes = _stiffness_notes(diagnosis)
    if len(notes) != 1:
        return [sentence(note) for note in notes]
    head, _, cases = notes[0].replace(" is", MEANING, 1).partition(": ")
    return [sentence(one) for one in (f"{head}; these recordings do not tell why", *cases.split("; "))]


def stiffness_deviation_phrase(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> str:
    """How far the stiffness is from the declared one, and what friction is else, a phrase."""
    comes = "tyres and what yields beside them come" if diagnosis.of_car else "the tyre comes"
    farthest = " at the farthest" * (len(_stiffness_notes(diagnosis)) > 1)
    otherwise, _ = stiffness_doubt_and_range(diagnosis, outcome)
    return f"{comes} out {diagnosis.stiffness_ratio:.2f} times as stiff as declared{farthest}{otherwise}"


def stiffness_tolerance_sentence(diagnosis: Diagnosis) -> str:
    """The stiffness found beside the declared one where its tolerance covers it, a sentence."""
    if (one := diagnosis.stiffness) is None or diagnosis.stiffness_ratio != 1:
        return ""
    off = f"{100 * (one.found / one.declared - 1):+.0f} %".replace("-", "−")
    tolerance = f"± {100 * one.tolerance / one.declared:.0f} %"
    return (
        f"Found {one.found / 1e6:.3g}·10⁶ N/m²{' at the farthest' * one.several}, declared"
        f" {one.declared / 1e6:.3g}·10⁶, {off}: inside its tolerance of {tolerance}"
        f"{' (assumed, as none is declared)' * one.assumed}."
    )


def stiffness_doubt_and_range(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> tuple[str, str]:
    """What friction may be else, and between which ends, by a stiffness that was not declared."""
    ratio, read = diagnosis.stiffness_ratio, "force" if diagnosis.of_car else "torque"
    if_wrong = friction_if_stiffness_is_wrong(diagnosis, outcome)
    # What yields beside a car's tyres is the likelier cause of a stiffness that is too low.
    if not if_wrong or (diagnosis.of_car and ratio < 1):
        return "", ""
    return (
        f"; if the {read} reads so much too {'high' if ratio > 1 else 'low'}, friction is {if_wrong[0]}",
        f"Whether the {read} or k is off: friction is from {_possible_friction_text(outcome, ratio)};"
        " other errors come on top.",
    )


def friction_if_stiffness_is_wrong(diagnosis: Diagnosis, outcome: FrictionByBothModels) -> list[str]:
    """Friction of each ground if the torque, then if the half-length makes the stiffness what it is."""
    bands, ratio = outcome.prediction_band_by_ground(), diagnosis.stiffness_ratio
    if not bands or ratio == 1 or len(_stiffness_notes(diagnosis)) != 1:
        return []
    bound = f"not {'less' if ratio > 1 else 'more'} than"
    return [
        f"{about} {listed([f'{one.mu_eff / factor:.2f} on {ground}' for ground, one in bands.items()])}"
        for factor, about in ((ratio, "about"), (ratio ** (1 / 3), bound))
    ]


def _stiffness_notes(diagnosis: Diagnosis) -> list[str]:
    return [note for note in diagnosis.notes if note.startswith(OFF_STIFFNESS)]


def _possible_friction_text(outcome: FrictionByBothModels, ratio: float) -> str:
    """Friction of each ground with a band, from end to end of it and of the same over a ratio."""
    told = []
    for ground, one in outcome.prediction_band_by_ground().items():
        # The figures as they are told, so that whoever does the sum finds the same.
        digits = band_decimals(one.further or 0.0)
        value, half = round(one.mu_eff, digits), round(one.further or 0.0, digits)
        ends = [max(0.0, (value + side * half) / of) for side in (-1, 1) for of in (1.0, ratio)]
        told.append(f"{min(ends):.{digits}f} to {max(ends):.{digits}f} on {ground}")
    return listed(told)
