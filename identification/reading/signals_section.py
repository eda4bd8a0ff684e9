"""The section [signals] of a rig file: the map of its recordings' channels, read and written."""

import re
from math import inf
from pathlib import Path

from identification.reading.file_content import read_bytes
from identification.reading.signal_map import (
    DBC,
    SignalMap,
    SignalSource,
    alternatives,
    toml_entry,
    toml_text,
)
from symbolic import InvalidInputError
from symbolic.tables.parsing import MAX_TABLES_SIZE, excerpt, floats, naming, shown, toml_of
from symbolic.tables.rig_from_tables import SIGNALS

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
    with naming(path):
        given = toml_of(content).get(SIGNALS, {})
        with naming(f"[{SIGNALS}]"):
            sections = given if isinstance(given, list) and given else [given]
            maps = [_section(section, path.parent) for section in sections]
            return alternatives([one.signals for one in maps], [one.dbc for one in maps])


def _section(section: object, folder: Path) -> SignalMap:
    if not isinstance(section, dict):
        raise InvalidInputError("must be a section")
    entries = dict(section)
    dbc = entries.pop(DBC, None)
    if not isinstance(dbc, str | None) or "\0" in (dbc or ""):
        raise InvalidInputError(f"{DBC} must be the name of a file, got {shown(dbc)}")
    signals = {column: _signal(column, entry) for column, entry in entries.items()}
    return SignalMap(signals=signals, dbc=None if dbc is None else folder / dbc)


def _signal(column: str, entry: object) -> SignalSource:
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
        raise InvalidInputError(f"{column}: unit must be a text, got {shown(unit)}")
    if isinstance(factor, str) and (fraction := _FRACTION.fullmatch(factor)):
        over = float(fraction["over"])
        factor = float(fraction["part"]) / over if over else inf
    if isinstance(factor, bool) or not isinstance(factor, int | float):
        raise InvalidInputError(
            f'{column}: factor must be a number, or a fraction such as "1/14.8", got {shown(factor)}'
        )
    with naming(column):
        return SignalSource(
            channel=table["channel"], unit=unit, factor=floats("factor", {"": factor})[""]
        )


def signals_section(signals: SignalMap) -> str:
    """The sections of a rig file of which `read_signals` makes this map again; empty for none."""
    lines = []
    for one in signals.each if signals.signals or signals.dbc or signals.others else ():
        lines += [f"[[{SIGNALS}]]" if signals.others else f"[{SIGNALS}]"]
        lines += [toml_entry(column, source) for column, source in one.signals.items()]
        lines += [] if one.dbc is None else [f"{DBC} = {toml_text(str(one.dbc.absolute()))}"]
    return "\n".join([*lines, ""]) if lines else ""
