"""Rig and tyre as a rig file."""

import json

from identification.reading.signal_map import DBC, SignalMap
from symbolic import TOLERATED, Rig, Tyre
from symbolic.tables.rig_tables import NEUTRAL, RIG_KEYS, SIGNALS


def rig_text(rig: Rig, tyre: Tyre) -> str:
    """The rig file (TOML) of which `read_rig` makes these again; what is unknown is left out."""
    lines = []
    for section, source in (("rig", rig), ("sensor", rig), ("tyre", tyre)):
        entries = [*filter(None, (_line(rig, source, name) for name in RIG_KEYS[section]))]
        if section == "rig":
            spans = ((name, getattr(rig.tolerances, name)) for name in NEUTRAL)
            entries += [
                f"{name} = {{ tolerance = {span!r} }}" for name, span in spans if span is not None
            ]
        lines += [f"[{section}]", *entries, ""] if entries else []
    return "\n".join(lines)


def signals_text(signals: SignalMap) -> str:
    """The section of a rig file of which `read_signals` makes this map again; empty for none."""
    entries = [
        f"{column} = {{ channel = {_quoted(source.channel)}, factor = {source.factor!r}"
        + ("" if source.unit is None else f", unit = {_quoted(source.unit)}")
        + " }"
        for column, source in signals.signals.items()
    ]
    entries += [] if signals.dbc is None else [f"{DBC} = {_quoted(str(signals.dbc.absolute()))}"]
    return "\n".join([f"[{SIGNALS}]", *entries, ""]) if entries else ""


def _quoted(text: str) -> str:
    # Of what a string of TOML may not hold, JSON leaves the character DEL as it is.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _line(rig: Rig, source: Rig | Tyre, name: str) -> str:
    value = getattr(source, name)
    if value is None:
        return ""
    span = getattr(rig.tolerances, name) if name in TOLERATED else None
    return (
        f"{name} = {value!r}"
        if span is None
        else f"{name} = {{ value = {value!r}, tolerance = {span!r} }}"
    )
