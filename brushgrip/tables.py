"""Numbers as files and as tables on the screen."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from brushgrip.formatting import (
    error_columns,
    error_figures,
    headline,
    listed,
    parameters,
    plain,
    remainder,
    sentence,
)
from identification.results import Diagnosis


def csv_text(columns: Mapping[str, NDArray[Any]]) -> str:
    """Columns of equal length under their names.

    Floats round-trip, truth values are 0 and 1, NaN is an empty field, as in a recording.
    """
    lists = [[_field(value) for value in values.tolist()] for values in columns.values()]
    rows = [",".join(columns), *(",".join(row) for row in zip(*lists, strict=True))]
    return "\n".join(rows) + "\n"


def _field(value: float) -> str:
    if isinstance(value, bool):
        return str(int(value))
    return "" if math.isnan(value) else repr(float(value))


def json_text(content: Any) -> str:
    """Strict JSON: what is not finite becomes null."""
    return json.dumps(_finite(content), indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def _finite(content: Any) -> Any:
    if isinstance(content, Mapping):
        return {key: _finite(value) for key, value in content.items()}
    if isinstance(content, Sequence) and not isinstance(content, str):
        return [_finite(value) for value in content]
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content


def print_summary(diagnosis: Diagnosis) -> None:
    """Errors, effects and what is left, on standard output."""
    screen = Console(highlight=False, markup=False)
    screen.print(headline(diagnosis), style="bold")
    screen.print(_errors(diagnosis))
    screen.print(f"Before any effect: {diagnosis.signatures_before.reading}")
    if diagnosis.effects:
        screen.print(_effects(diagnosis))
    for effect in diagnosis.effects:
        if effect.experiment:
            screen.print(f"next experiment: {sentence(effect.experiment.sentence)}")
    screen.print(f"{remainder(diagnosis)} {sentence(diagnosis.unexplained.evidence)}")
    for note in diagnosis.notes:
        screen.print(f"note: {note}")


def _errors(diagnosis: Diagnosis) -> Table:
    table = Table(title="Torque error, root mean square", title_justify="left")
    table.add_column("model")
    for heading in error_columns(diagnosis).values():
        table.add_column(heading, justify="right")
    for label, errors in (
        ("declared", diagnosis.declared),
        ("before", diagnosis.before),
        ("after", diagnosis.after),
    ):
        table.add_row(label, *error_figures(diagnosis, errors))
    return table


def _effects(diagnosis: Diagnosis) -> Table:
    table = Table(title="Effects found", title_justify="left")
    for heading in ("effect", "parameters ± standard deviation", "cannot be told from"):
        table.add_column(heading)
    for effect in diagnosis.effects:
        alike = listed([plain(name) for name in effect.indistinguishable_from], "or")
        table.add_row(plain(effect.name), parameters(effect.parameters), alike or "–")
    return table
