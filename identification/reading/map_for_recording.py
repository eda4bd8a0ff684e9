"""What of a map a recording takes: one of several, units by the names of channels, a steering ratio."""

from collections.abc import Sequence
from dataclasses import replace
from math import inf

from identification.reading.channels_by_name import match_channel
from identification.reading.signal_map import ANGLES, SignalMap, SignalSource, as_map_option
from identification.reading.units import UNITS, UNSURE_AT_END, factor_of, unit_at_end
from symbolic import InvalidInputError


def choose_map_for_channels(where: str, signals: SignalMap, names: Sequence[str]) -> SignalMap:
    """Of several maps the one whose channels a file has, or of which it has most.

    A file that has columns of a recording under their own names, and no channel of any map, needs none.
    """
    sources = {(c, source.channel) for one in signals.alternatives for c, source in one.signals.items()}
    foreign = [channel for column, channel in sources if channel != column]
    own = foreign and signals.steering_ratio is None and {"t", "psi", "F_N"} <= set(names)
    # A unit or a factor of a column under its own name holds for this file too.
    own = own and not any(
        source.channel == column and source != SignalSource(channel=column)
        for one in signals.alternatives
        for column, source in one.signals.items()
    )
    if own and not any(_has_channel(channel, names) for channel in foreign):
        # They are named, so that a map that is proposed for another column needs none of these.
        return SignalMap(signals={c: SignalSource(channel=c) for c in ("psi", "F_N")}, dbc=signals.dbc)
    if not signals.others:
        return signals

    def lacking(one: SignalMap) -> int:
        return sum(not _has_channel(source.channel, names) for source in one.signals.values())

    fitting = [one for one in signals.alternatives if not lacking(one)]
    if len(fitting) > 1:
        texts = [
            ",".join(s.map_option_text(column) for column, s in one.signals.items()) for one in fitting
        ]
        raise InvalidInputError(
            f"{where}: several maps fit, {' and '.join(texts)}; join them, or name a channel in each"
            " that the other recordings lack"
        )
    return min(signals.alternatives, key=lacking)


def _has_channel(channel: str, names: Sequence[str]) -> bool:
    try:
        return match_channel("", channel, names) is not None
    except InvalidInputError:  # It is there, even more than once.
        return True


def add_unit_by_name(column: str, source: SignalSource, stated: str) -> tuple[SignalSource, str]:
    """The source with the unit that its channel's name ends in, and words on what was taken.

    A unit that the map has or that the file has stated stays; where the map has a factor, it may hold
    the unit already, and that is a fault.
    """
    unit, name = unit_at_end(column, source.channel), source.channel
    if source.unit is not None or not unit or factor_of(column, unit) == factor_of(column, stated):
        return source, ""
    if stated.strip():
        return source, f"{name} in {stated} as the file says, not in {unit}"
    if unit in UNSURE_AT_END:
        return source, f"{name} in {next(iter(UNITS[column]))}, not in {unit}"
    if abs(source.factor) != 1:
        units = unit, next(iter(UNITS[column]))
        with_unit, without = (replace(source, unit=one).map_option_text(column) for one in units)
        raise InvalidInputError(
            f"is {unit} the unit of {name}, or in the factor already? Write"
            f" {as_map_option([with_unit])}, or {as_map_option([without])}"
        )
    return replace(source, unit=unit), f"{name} in {unit}"


def with_steering_ratio(signals: SignalMap, ratio: float) -> SignalMap:
    """The map of recordings of a steering wheel's angle, which is the wheel's times this ratio [1]."""
    if not 0 < ratio < inf:
        raise InvalidInputError(f"--steering-ratio must be finite and greater than 0, got {ratio:g}")
    bare = [one for one in signals.alternatives if abs(one.of("psi").factor) == 1]
    if bare and len({one.of("psi") for one in signals.alternatives}) > 1:
        listed = " or ".join(_entries_with_steering_ratio(one, ratio) for one in bare)
        angles = (one.of("psi") for one in signals.alternatives if one not in bare)
        known = "".join(f"; {angle.channel} has a factor already" for angle in angles)
        raise InvalidInputError(
            f"--steering-ratio {ratio:g}: the maps take psi from different channels, and which of them"
            f" is the steering wheel's is not known{known}; leave --steering-ratio out, and write its"
            f" factor into the map of that channel alone: {listed}"
        )
    for column, source in ((c, one.of(c)) for one in signals.alternatives for c in ANGLES):
        if abs(source.factor) != 1:
            raise InvalidInputError(
                f"--steering-ratio {ratio:g}: the map of channels has a factor for {column} already,"
                f" {source.map_option_text(column)}; give one of them"
            )
    first, *others = (replace(one, steering_ratio=ratio) for one in signals.alternatives)
    return replace(first, others=tuple(others))


def _entries_with_steering_ratio(one: SignalMap, ratio: float) -> str:
    """The entries of the angle and of its rate with the steering ratio as their factor."""
    entries = []
    for column in ("psi", *(c for c in ANGLES[1:] if c in one.signals)):
        source = one.of(column)
        at_end = unit_at_end(column, source.channel)
        unit = source.unit or (at_end if at_end and at_end not in UNSURE_AT_END else None)
        entries.append(replace(source, factor=source.factor / ratio, unit=unit).map_option_text(column))
    return ",".join(entries)
