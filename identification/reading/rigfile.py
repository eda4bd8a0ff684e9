"""Rig files (TOML): rig and tyre, overridden by what a recording declares, and [signals]; both ways."""

import re
from math import inf
from pathlib import Path

from identification.reading.checked_file_reading import read_bytes
from identification.reading.checked_sample_table import Table
from identification.reading.signal_map import (
    DBC,
    SignalMap,
    SignalSource,
    join_alternative_maps,
    parse_signals,
    toml_entry,
    toml_value,
)
from symbolic import TOLERATED, InvalidInputError, Rig, Tyre, rig_from_tables
from symbolic.tables.rig_from_tables import NEUTRAL, REQUIRED_KEYS, RIG_KEYS, SIGNALS, rig_and_tyre
from symbolic.tables.toml_and_json_parsing import (
    MAX_TABLES_SIZE,
    excerpt,
    floats,
    parse_toml,
    prefix_errors,
    quoted_value,
)

DECLARABLE = (*RIG_KEYS["rig"], *RIG_KEYS["tyre"])
"""Parameters that a recording may give for itself."""


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
    with prefix_errors(path):
        return rig_from_tables(parse_toml(content))


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
        entries = []
        for name in keys:
            if (value := getattr(source, name)) is not None:
                span = getattr(rig.tolerances, name) if name in TOLERATED else None
                told = f"{value!r}" if span is None else f"{{ value = {value!r}, tolerance = {span!r} }}"
                entries.append(f"{name} = {told}")
        if section == "rig":
            spans = ((name, getattr(rig.tolerances, name)) for name in NEUTRAL)
            entries += [
                f"{name} = {{ tolerance = {span!r} }}" for name, span in spans if span is not None
            ]
        lines += [f"[{section}]", *entries, ""] if entries else []
    return "\n".join(lines)


def rig_overridden_by_table(table: Table, nominal: tuple[Rig, Tyre] | None) -> tuple[Rig, Tyre]:
    """The nominal rig and tyre, overridden by the values that the table declares."""
    missing = [key for keys in REQUIRED_KEYS.values() for key in keys if key not in table.declared]
    if nominal is None and missing:
        raise InvalidInputError(
            f"{table.path}: {' and '.join(missing)} not known; name a rig file (--rig RIG.toml), or give"
            " a, e and k in the recording: lines such as '# a = 0.045' before a CSV header, scalars in a"
            " MAT file"
        )
    try:
        return rig_and_tyre(table.declared, nominal, table.tolerances)
    except InvalidInputError as error:
        # The message begins with the parameter; where the file itself gave it, name its place.
        name = str(error).split()[0]
        place = f"{table.place(name)}: " if name in table.declared else ""
        raise InvalidInputError(f"{table.path}: {place}{error}") from None


_FRACTION = re.compile(r"(?P<part>-?[0-9]{1,9}(\.[0-9]{1,9})?)/(?P<over>[0-9]{1,9}(\.[0-9]{1,9})?)")


def read_signals(path: str | Path) -> SignalMap:
    """The section ``[signals]`` of a rig file; an empty map where there is none.

    ``psi = { channel = "SteeringAngle", unit = "deg", factor = -0.06 }``, or ``psi = "SteeringAngle"``;
    ``dbc = "car.dbc"`` names a file relative to the rig's. Of several sections ``[[signals]]``, a
    recording takes the one whose channels it has.

    Raises:
        InvalidInputError: the file cannot be read, or an entry is none such.
    """
    path = Path(path)
    content = read_bytes(path, MAX_TABLES_SIZE)
    with prefix_errors(path):
        given = parse_toml(content).get(SIGNALS, {})
        with prefix_errors(f"[{SIGNALS}]"):
            sections = given if isinstance(given, list) and given else [given]
            maps = [_parse_section(section, path.parent) for section in sections]
            return join_alternative_maps([one.signals for one in maps], [one.dbc for one in maps])


def _parse_section(section: object, folder: Path) -> SignalMap:
    if not isinstance(section, dict):
        raise InvalidInputError("must be a section")
    entries = dict(section)
    dbc = entries.pop(DBC, None)
    if not isinstance(dbc, str | None) or "\0" in (dbc or ""):
        raise InvalidInputError(f"{DBC} must be the name of a file, got {quoted_value(dbc)}")
    signals = {column: _parse_source(column, entry) for column, entry in entries.items()}
    return SignalMap(signals=signals, dbc=None if dbc is None else folder / dbc)


def _parse_source(column: str, entry: object) -> SignalSource:
    table = {"channel": entry} if isinstance(entry, str) else entry
    if not isinstance(table, dict) or not isinstance(table.get("channel"), str):
        raise InvalidInputError(
            f'{column} needs its channel, such as {{ channel = "Angle", unit = "deg" }}'
        )
    if unknown := sorted(set(table) - {"channel", "unit", "factor"}):
        raise InvalidInputError(
            f"{column}: unknown {excerpt(unknown[0])}; allowed: channel, unit, factor"
        )
    unit, factor = table.get("unit"), table.get("factor", 1.0)
    if not isinstance(unit, str | None):
        raise InvalidInputError(f"{column}: unit must be a text, got {quoted_value(unit)}")
    if isinstance(factor, str) and (fraction := _FRACTION.fullmatch(factor)):
        over = float(fraction["over"])
        factor = float(fraction["part"]) / over if over else inf
    if isinstance(factor, bool) or not isinstance(factor, int | float):
        raise InvalidInputError(
            f'{column}: factor must be a number, or a fraction such as "1/14.8",'
            f" got {quoted_value(factor)}"
        )
    with prefix_errors(column):
        return SignalSource(
            channel=table["channel"], unit=unit, factor=floats("factor", {"": factor})[""]
        )


def signals_section(signals: SignalMap) -> str:
    """The sections of a rig file of which `read_signals` makes this map again; empty for none."""
    lines = []
    for one in signals.alternatives if signals.signals or signals.dbc or signals.others else ():
        lines += [f"[[{SIGNALS}]]" if signals.others else f"[{SIGNALS}]"]
        lines += [toml_entry(column, source) for column, source in one.signals.items()]
        lines += [] if one.dbc is None else [f"{DBC} = {toml_value(str(one.dbc.absolute()))}"]
    return "\n".join([*lines, ""]) if lines else ""
