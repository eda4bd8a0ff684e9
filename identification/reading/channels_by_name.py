"""Channels of a file by name: which of them is which column of a recording, and a map where none is."""

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, suppress
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from pathlib import Path

import numpy as np

from identification.reading.checked_sample_table import CAR_COLUMNS, COLUMNS, possible_columns
from identification.reading.signal_map import NO_MAP, SignalMap, SignalSource, corrected_map_text
from identification.reading.units import (
    factor_of,
    is_unit,
    name_without_unit,
    unit_at_end,
    unit_in_brackets,
)
from identification.reading.units_by_magnitude import infer_units_and_sign
from symbolic import InvalidInputError
from symbolic.float_array_type import Array
from symbolic.tables.toml_and_json_parsing import excerpt

IN_PYTHON = " (in Python by signals=, or with the rig file itself as rig)"
CAR_IN_PYTHON = " (in Python by signals=)"
"""How a caller without a command line maps channels."""
CONSTANT_LOAD = "; a load that was not recorded needs a column too, with its value [N] in every row"
MAX_NAMES = 20
"""Names of channels that a message lists."""
_STEERING_WHEEL = re.compile(r"steering.?wheel|hand.?wheel|lenkrad|volant|^(swa|swt|sas)", re.IGNORECASE)
"""Names of a channel that belongs to the steering wheel, not to the wheel about its kingpin."""
_OF_GROUND = re.compile(r"m_?z|align", re.IGNORECASE)
"""Names of a torque that is the ground's by its name, not perhaps that which turns the wheel."""
_NEEDS_STEERING_RATIO = ("psi", "psi_dot", "M_z", "M")
_USUAL_NAMES = {
    "t": ("time", "zeit", "timestamp", "sec", "clock", "uhr"),
    "psi": ("psi", "angle", "winkel", "steer", "yaw", "lenk"),
    "M_z": ("mz", "torque", "moment", "align"),
    "F_N": ("fn", "fz", "load", "last", "force", "kraft", "normal"),
}
"""Parts of names that channels often have, in lower case."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelSamples:
    """One channel; arrays of shape (n,)."""

    values: Array
    unit: str = ""  # That the file says.
    times: Array | None = None  # Of its own clock, if it has one [s].
    remark: str = ""  # What the user has to know about the values.


@dataclass(frozen=True, kw_only=True, eq=False)
class ChannelFile:
    """The channels of an open file."""

    names: Sequence[str]  # Parts are separated by a slash or a dot, the last is the short name.
    read: Callable[[str], ChannelSamples]  # The samples of a channel by its full name.
    declared: Mapping[str, float] = field(default_factory=dict)  # Of a, e, k, mu, J_A, b_t.
    # Names under which a format keeps a column, tried in turn where the map is silent; a column that is
    # not in it has its own name.
    aliases: Mapping[str, Sequence[str]] = field(default_factory=dict)
    own_clocks: bool = False  # Whether channels come with their times, so that none has to hold them.


Opener = Callable[[Path, SignalMap], AbstractContextManager[ChannelFile]]
"""Opens a file and lists its channels without reading them."""


def resolve_columns(
    path: Path, file: ChannelFile, needed: Sequence[str], signals: SignalMap
) -> dict[str, str]:
    """The full name of the channel of each column that the file has."""
    full, absent = {}, []
    for column in possible_columns(needed):
        mapped = column in signals.signals
        wanted = [signals.of(column).channel] if mapped else file.aliases.get(column, (column,))
        asked = mapped or column in needed
        found = (
            match_channel(str(path), name, file.names, by_part=asked or column in CAR_COLUMNS)
            for name in wanted
        )
        if (name := next(filter(None, found), None)) is not None:
            full[column] = name
        elif mapped or (asked and column != "t"):
            absent.append(column)
    if absent == ["t"] and file.own_clocks:
        raise InvalidInputError(
            f"{path}: no channel {excerpt(signals.of('t').channel)} for t; the others have clocks of"
            " their own: map no t"
        )
    if absent:
        absent += ["t"] if not file.own_clocks and "t" not in (*full, *absent) else []
        raise missing_channels_error(path, absent, file.names, signals, file.read)
    return full


def match_channel(where: str, name: str, names: Sequence[str], *, by_part: bool = True) -> str | None:
    """The one channel of a name: exact, without its unit or, `by_part`, by its last parts; or None."""
    bare = [name_without_unit(full) for full in names]
    exact = [full for full in names if full == name]
    without_unit = [full for full, short in zip(names, bare, strict=True) if short == name]
    last_part = [
        full
        for full, short in zip(names, bare, strict=True)
        if by_part and short.endswith((f"/{name}", f".{name}"))
    ]
    candidates = exact or without_unit or last_part
    if len(candidates) > 1 and len(set(candidates)) == 1:
        raise InvalidInputError(f"{where}: two columns are named {candidates[0]}; one allowed")
    if len(candidates) > 1:
        raise InvalidInputError(
            f"{where}: {excerpt(name)} may be {_listed(candidates)}; give the full name in --map"
        )
    return candidates[0] if candidates else None


def missing_channels_error(
    path: Path,
    absent: Sequence[str],
    names: Sequence[str],
    signals: SignalMap,
    read: Callable[[str], ChannelSamples] | None = None,
) -> InvalidInputError:
    """Missing columns, channels that are there, and a map that may mend it; see `map_hint`."""
    wanted = ", ".join(
        EITHER.get(c, c) if c not in signals.signals else f"{c} (as {excerpt(signals.of(c).channel)})"
        for c in absent
    )
    plural = "s" * (len(absent) > 1)
    hint = map_hint(absent, names, signals, read)
    return InvalidInputError(
        f"{path}: channel{plural} {wanted} missing; there are {_listed(names)}{hint}"
    )


def map_hint(
    absent: Sequence[str],
    names: Sequence[str],
    signals: SignalMap = NO_MAP,
    read: Callable[[str], ChannelSamples] | None = None,
    *,
    in_python: bool = True,
) -> str:
    """A sentence that proposes a whole map, a torque in it; names that look alike are filled in.

    The samples of channels, where `read` gives them, show units and the sign of the torque.
    """
    if not names:
        return ""
    of_steering = {*absent, *signals.signals} | ({*names} if [*absent] == ["t"] else set())
    if {"rack", "handwheel", "F_rack", "T_bar", "T_motor"} & of_steering:
        cars = guess_car_channels(absent, names, signals)
        guesses = {c: _proposed_source(c, c if c in names else guess) for c, guess in cars}
        given = {c: source for c, source in signals.signals.items() if c not in absent}
        which = f"; say which is which{CAR_IN_PYTHON * in_python}"
        return f"{which}, such as {corrected_map_text(given, guesses)}"
    channels = dict(_channel_guesses(absent, names, signals))
    guessed = {
        column: replace(_proposed_source(column, guess), ratio=signals.steering_ratio)
        for column, guess in channels.items()
    }
    of_hand = {
        c
        for c, s in guessed.items()
        if c in _NEEDS_STEERING_RATIO and channels[c] and _STEERING_WHEEL.search(s.channel)
    }
    # The hand turns the wheel, M_z is the moment of the ground on it.
    guessed |= {c: replace(guessed[c], factor=-1.0) for c in of_hand & {"M_z"}}
    others = {c: signals.of(c) for c in (*COLUMNS, *signals.signals) if c not in channels}
    channels |= {c: match_channel("", s.channel, names) for c, s in others.items()}
    sources = {c: s for c, s in (others | guessed).items() if channels[c] or c not in others}
    values, certain = {}, {*signals.signals} - {*guessed}
    mapped = {column: sources[column] for column in certain & {*sources}}
    for column, name in channels.items():
        if read is None or name is None:
            continue
        with suppress(InvalidInputError), np.errstate(over="ignore"):
            samples, source = read(name), sources[column]
            if unit := source.unit or samples.unit or unit_in_brackets(name):
                certain.add(column)
            factor = source.factor if column in others else 1.0
            values[column] = samples.values * factor * (factor_of(column, unit) or 1.0)
    inferred, of_hand = infer_units_and_sign(sources, values, of_hand, certain)
    sources = inferred | mapped
    changed = {
        c: sources[c].geared_by_steering_ratio(c) if c in of_hand else sources[c]
        for c in sorted(sources, key=[*COLUMNS, *sources].index)
        if c in of_hand or c in signals.signals or sources[c] != SignalSource(channel=c)
    }
    load = CONSTANT_LOAD if [*absent] == ["F_N"] and channels["F_N"] is None else ""
    ratio = SignalSource(channel="psi", ratio=signals.steering_ratio).ratio_hint if of_hand else ""
    assumed = _assumed_torque_note(channels.get("M_z") if "M_z" in guessed else None)
    taken = "" if "M_z" in of_hand else assumed
    which = f"; say which is which{IN_PYTHON * in_python}"
    return f"{load}{taken}{which}, such as {corrected_map_text({}, changed)}{ratio}"


def _assumed_torque_note(channel: str | None) -> str:
    """Which torque a channel is taken for whose name does not tell, and how to say another one."""
    if channel is None or _OF_GROUND.search(channel):
        return ""
    name = excerpt(name_without_unit(channel))[1:-1]
    return (
        f"; {name} is taken for M_z, the moment of the ground on the wheel: one that turns the wheel is"
        f" M (M={name}, with J_A and b_t in the rig file) or, turned slowly, M_z=-{name}"
    )


def _proposed_source(column: str, channel: str | None) -> SignalSource:
    """A channel with the unit that its name ends in; a word in its place for none."""
    bare = name_without_unit(channel or "CHANNEL")
    unit = "" if is_unit(column, unit_in_brackets(channel or "")) else unit_at_end(column, bare)
    return SignalSource(channel=bare, unit=unit or None)


def _channel_guesses(
    absent: Sequence[str], names: Sequence[str], signals: SignalMap
) -> Iterator[tuple[str, str | None]]:
    """Columns with the channels that they may be."""
    left = list(names)
    known = {*absent, *signals.signals, *(name_without_unit(name) for name in names)}
    for column in absent if {"M_z", "M"} & known else (*absent, "M_z"):
        if (guess := _likely_channel(column, left)) is not None:
            left.remove(guess)
        yield column, guess


def _likely_channel(column: str, names: Sequence[str]) -> str | None:
    by_unit = [n for n in names if is_unit(column, unit_in_brackets(n) or unit_at_end(column, n))]
    parts = _USUAL_NAMES.get(column, (column.lower(),))
    by_name = [n for n in names if any(p in n.lower().replace("_", "") for p in parts)]
    close = get_close_matches(column, names, n=1, cutoff=0.6)
    return next(iter([*(n for n in by_name if n in by_unit), *by_name, *by_unit, *close]), None)


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - MAX_NAMES} more" if len(names) > MAX_NAMES else ""
    return (", ".join(excerpt(name)[1:-1] for name in names[:MAX_NAMES]) or "none") + more


EITHER = {"rack": "rack or handwheel", "F_rack": "F_rack or T_bar"}
"""Columns of which one or the other is needed."""
_USUAL = {
    "t": r"^t$|time|zeit|^sec|^clock|uhr",
    "F_rack": r"rack.*(force|frc|load)|zahnstangenkraft|^f_?rack",
    "T_motor": r"^(?!.*(speed|spd|angle|pos|state|temp)).*mot",
    "T_bar": r"bar|tors|(steer|hand|driver).*(torq|trq|mom)|^swt",
    "rack": r"rack|zahnstange",
    "handwheel": r"^(?!.*(rate|speed|spd|vel)).*(steer|hand.?wheel|lenkrad|volant|^swa|^lws|^sas)",
    "brake": r"brak|brk|brems",
    "speed": r"^(?!.*(steer|angle|mot|engine|rate|wheel|whl)).*(speed|spd|veh.*vel|geschw|^v$)",
}
"""Names that channels often have; each channel goes to the first column that it fits."""


def absent_rack_columns(columns: Collection[str]) -> list[str]:
    """Columns without which way or force of the rack are not known, see `EITHER`."""
    return [one for one, both in EITHER.items() if not {*columns} & {*both.split(" or ")}]


def guess_car_channels(
    absent: Sequence[str], names: Sequence[str], signals: SignalMap
) -> Iterator[tuple[str, str | None]]:
    """Columns with the channels that they may be: absent ones, and optional ones that are there.

    Handwheel and torsion bar stand for rack and force where names tell that these are what there is.
    """
    short = {name: re.split("[/.]", name_without_unit(name))[-1] for name in names}
    taken = {*(source.channel for source in signals.signals.values()), *CAR_COLUMNS, "t"}
    left = [name for name in names if not {short[name], name_without_unit(name)} & taken]
    found = dict[str, str]()
    for column in (c for c in _USUAL if c not in signals.signals and c not in short.values()):
        guess = next((n for n in left if re.search(_USUAL[column], short[n], re.IGNORECASE)), None)
        if guess is not None:
            left.remove(guess)
            found[column] = guess
    wanted = []
    for column in absent:
        other = EITHER.get(column, column).split(" or ")[-1]
        swap = column not in signals.signals and column not in found and other in found
        wanted.append(other if swap else column)
    wanted += ["T_motor"] * ("T_bar" in wanted and "T_motor" in found)
    wanted += [column for column in ("brake", "speed") if column in found]
    for column in dict.fromkeys(wanted):
        yield column, found.get(column)
