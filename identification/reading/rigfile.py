"""Rig and tyre from a TOML file and back, overridden by values that a recording declares."""

from pathlib import Path

from identification.reading.file_content import read_bytes
from identification.reading.signal_map import SignalMap, parse_signals
from identification.reading.signals_section import read_signals
from identification.reading.table import Table
from symbolic import TOLERATED, InvalidInputError, Rig, Tyre, rig_from_tables
from symbolic.tables.parsing import MAX_TABLES_SIZE, naming, toml_of
from symbolic.tables.rig_from_tables import NEUTRAL, REQUIRED_KEYS, RIG_KEYS, rig_from_values

DECLARABLE = (*RIG_KEYS["rig"], *RIG_KEYS["tyre"])
"""Parameters that a recording may give for itself."""
TOLERANCE_ONLY = tuple(NEUTRAL)
"""What a recording may give a tolerance alone: a factor on its load, the zero of its torque."""


def read_rig(path: str | Path) -> tuple[Rig, Tyre]:
    """Read ``[rig] a, e, J_A, b_t`` and ``[tyre] k, mu`` (SI units; J_A, b_t and mu optional).

    `a = { value = 0.045, tolerance = 0.0025 }` says how far off a may be, and so for e; `load` and
    `zero` have a tolerance alone, `load = { tolerance = 0.01 }`, see `symbolic.Tolerances`.

    Raises:
        InvalidInputError: the file cannot be read, a section or key is missing or unknown, or a
            value is not a number within its range.
    """
    path = Path(path)
    content = read_bytes(path, MAX_TABLES_SIZE)
    with naming(path):
        return rig_from_tables(toml_of(content))


def rig_and_signals(
    rig: tuple[Rig, Tyre] | str | Path | None, signals: SignalMap | str
) -> tuple[tuple[Rig, Tyre] | None, SignalMap]:
    """Rig and tyre, of their file where that is given, and the map, which goes before its [signals]."""
    signals = parse_signals(signals) if isinstance(signals, str) else signals
    if not isinstance(rig, str | Path):
        return rig, signals
    return read_rig(rig), read_signals(rig).updated(signals)


def rig_text(rig: Rig, tyre: Tyre) -> str:
    """The rig file (TOML) of which `read_rig` makes these again; what is unknown is left out."""
    lines = []
    for section, keys in RIG_KEYS.items():
        source = tyre if section == "tyre" else rig
        entries = [
            _entry(rig, name, value) for name in keys if (value := getattr(source, name)) is not None
        ]
        if section == "rig":
            spans = ((name, getattr(rig.tolerances, name)) for name in TOLERANCE_ONLY)
            entries += [
                f"{name} = {{ tolerance = {span!r} }}" for name, span in spans if span is not None
            ]
        lines += [f"[{section}]", *entries, ""] if entries else []
    return "\n".join(lines)


def _entry(rig: Rig, name: str, value: float) -> str:
    span = getattr(rig.tolerances, name) if name in TOLERATED else None
    return (
        f"{name} = {value!r}"
        if span is None
        else f"{name} = {{ value = {value!r}, tolerance = {span!r} }}"
    )


def rig_of_table(table: Table, nominal: tuple[Rig, Tyre] | None) -> tuple[Rig, Tyre]:
    """The nominal rig and tyre, overridden by the values that the table declares.

    Args:
        table: with values by name, out of `DECLARABLE` (SI units), and their tolerances.
        nominal: rig and tyre from elsewhere; None where only the recording knows them.
    """
    missing = [key for keys in REQUIRED_KEYS.values() for key in keys if key not in table.declared]
    if nominal is None and missing:
        raise InvalidInputError(
            f"{table.path}: {' and '.join(missing)} not known; name a rig file (--rig RIG.toml), or give"
            " a, e and k in the recording: lines such as '# a = 0.045' before a CSV header, scalars in a"
            " MAT file"
        )
    try:
        return rig_from_values(table.declared, nominal, table.tolerances)
    except InvalidInputError as error:
        # The message begins with the parameter; where the file itself gave it, name its place.
        name = str(error).split()[0]
        place = f"{table.place(name)}: " if name in table.declared else ""
        raise InvalidInputError(f"{table.path}: {place}{error}") from None
