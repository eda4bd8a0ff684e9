"""Rig and tyre as a rig file."""

from symbolic import TOLERATED, Rig, Tyre
from symbolic.rig_tables import NEUTRAL, RIG_KEYS


def rig_text(rig: Rig, tyre: Tyre) -> str:
    """The rig file (TOML) of which `read_rig` makes these again; what is unknown is left out."""
    lines = []
    for section, source in (("rig", rig), ("tyre", tyre)):
        lines += [f"[{section}]", *filter(None, (_line(source, name) for name in RIG_KEYS[section]))]
        if section == "rig":
            spans = ((name, getattr(rig.tolerances, name)) for name in NEUTRAL)
            lines += [f"{name} = {{ tolerance = {span!r} }}" for name, span in spans if span]
        lines.append("")
    return "\n".join(lines)


def _line(source: Rig | Tyre, name: str) -> str:
    value = getattr(source, name)
    if value is None:
        return ""
    span = getattr(source.tolerances, name) if isinstance(source, Rig) and name in TOLERATED else 0.0
    return f"{name} = {{ value = {value!r}, tolerance = {span!r} }}" if span else f"{name} = {value!r}"
