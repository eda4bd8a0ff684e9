"""What an observer takes from the model of a diagnosis, in words."""

from brushgrip.wording.diagnosis_in_words import GRADES
from brushgrip.wording.formatting import listed, percent, plain, quantity
from identification import Diagnosis, FoundModel, ParameterEstimate


def use_of(diagnosis: Diagnosis, found: FoundModel) -> str:
    """Friction by `estimate` with the model of a diagnosis."""
    if not diagnosis.of_car:
        return f"With model.json the command estimate uses {taken_from_model(found)}."
    return (
        "Friction is by the vehicle as declared, before and after alike: estimate takes no model.json of"
        " a car. Declare what was found, with its tolerance, in the vehicle file."
    )


def taken_from_model(found: FoundModel) -> str:
    """What an observer takes from a model file, and on how many recordings that stands."""
    basis, model = found.basis, found.model
    grades = {} if basis is None else basis.grades
    scopes = {effect.name: {p.scope for p in effect.parameters} for effect in model.effects}
    own = [name for name, scope in scopes.items() if scope == {"recording"}]
    parts = [
        plain(name) + (f" ({GRADES.get(grades[name], grades[name])})" if name in grades else "")
        for name in scopes
        if name not in own
    ]
    if "k" in found.tyre:
        stiffness = ParameterEstimate(value=found.tyre["k"], std=None, unit="N/m^2")
        parts.append(f"k = {quantity(stiffness)}")
    else:
        parts.append("k of the ground")
    if found.error is not None:
        whole = "the torque of full slide" if found.error.relative is None else "half the torque range"
        parts.append(f"the model's error, {percent(found.error.share)} of {whole}")
    line = listed(parts)
    if own:
        line += f"; not {listed([plain(name) for name in own])}, which belongs to a recording"
    return f"{line}. {_standing(found)}"


def _standing(found: FoundModel) -> str:
    basis = found.basis
    if basis is None:
        return "The file does not say how many recordings that stands on"
    count = f"{basis.training} recording{'s' * (basis.training != 1)}"
    if basis.holdout:
        judged = f"{basis.holdout} validation recording{'s' * (basis.holdout != 1)} judged it"
    elif basis.training > 1:
        judged = "each left out in turn judged it"
    else:
        judged = "nothing judged it"
    weak = sum(grade in ("weak", "stands_in") for grade in basis.grades.values())
    doubt = f"; {weak} of {len(basis.grades)} effects are weak or stand-ins" * bool(weak)
    return f"It stands on {count}, {judged}{doubt}"
