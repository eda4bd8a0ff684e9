"""The tuning of an observer as the command line says it: a profile by name, then single values."""

from collections.abc import Sequence
from dataclasses import replace

from observers import Tuning, profile
from observers.tuning import TUNING_FIELDS
from symbolic import InvalidInputError

OF_STATES = {
    "stiffness_std": "k is no state of the observers that commands run; from Python:"
    " Ekf(..., stiffness=True)",
}
"""Values that say nothing without a state that only Python adds, and why."""


def chosen_tuning(name: str | None, values: Sequence[str] | None) -> Tuning | None:
    """The tuning of a profile with some values replaced; None where nothing is chosen.

    Args:
        name: of the profile; None for the usual one.
        values: texts such as "mu_walk=0.02"; one may hold several, separated by commas.

    Raises:
        InvalidInputError: there is no such profile or value, or a value is given twice or outside its
            range.
    """
    pairs = [pair.strip() for text in values or () for pair in text.split(",") if pair.strip()]
    if name is None and not pairs:
        return None
    given: dict[str, float] = {}
    for pair in pairs:
        field, _, text = (part.strip() for part in pair.partition("="))
        if field not in TUNING_FIELDS:
            allowed = ", ".join(TUNING_FIELDS)
            raise InvalidInputError(f"--tune {pair}: expected NAME=NUMBER with a name out of {allowed}")
        if field in given:
            raise InvalidInputError(f"--tune {pair}: {field} is given twice")
        if field in OF_STATES:
            raise InvalidInputError(f"--tune {pair}: {OF_STATES[field]}")
        given[field] = _number(field, pair, text)
    try:
        return replace(Tuning() if name is None else profile(name), **given)  # type: ignore[arg-type]
    except InvalidInputError as error:
        raise InvalidInputError(f"--tune: {error}") from None


def _number(field: str, pair: str, text: str) -> float:
    try:
        return int(text) if field == "reset_after" else float(text)
    except ValueError:
        kind = "a whole number" if field == "reset_after" else "a number"
        raise InvalidInputError(f"--tune {pair}: expected {kind}, got {text!r}") from None
