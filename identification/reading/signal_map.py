"""Which channel of a file is which column of a recording, with its unit, sign and factor."""

import json
import re
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import inf
from pathlib import Path

from identification.reading.units import UNITS, require_factor
from symbolic import InvalidInputError
from symbolic.tables.rig_from_tables import SIGNALS
from symbolic.tables.toml_and_json_parsing import excerpt, prefix_errors, quoted_value

USUAL_RATIO = 15
"""Stands for the steering ratio in a map that is proposed [1]."""
ANGLES = ("psi", "psi_dot")
"""Columns that a steering ratio divides."""
DBC = "dbc"
"""Key of the file that says how signals lie in the messages of a CAN bus."""
MIN_FACTOR, MAX_FACTOR = 1e-12, 1e12
"""Size of a factor, beyond which no unit is."""
_WHOLE = [{"psi", "F_N", "M_z"}, {"psi", "F_N", "M"}, {"rack", "F_rack"}, {"handwheel", "T_bar"}]
"""Columns that describe a recording, beside its time."""
_SOURCE = re.compile(
    r"(?P<sign>[+-]?)(?:(?P<factor>\d+\.?\d*(?:[eE][+-]?\d+)?)(?:/(?P<over>\d+\.?\d*))?\*)?(?P<channel>.+?)(?::(?P<unit>[^:]*))?"
)


@dataclass(frozen=True, kw_only=True)
class SignalSource:
    """Where a column comes from: column [SI] = factor x unit x channel.

    Attributes:
        channel: its name in the file; of a CAN signal that several buses carry, with the bus before a
            slash, as in `1/Motion.Angle` or `can0/Motion.Angle`.
        unit: of the channel, as `deg`; None for what the file itself says, SI where it says nothing.
        factor: from the channel to the column, such as the ratio of steering wheel to kingpin; negative
            where the channel counts the other way [1].
        ratio: what `--steering-ratio` says, by which an angle is divided besides; None for nothing.

    Raises:
        InvalidInputError: no name, or a factor that is 0, not finite or of an absurd size.
    """

    channel: str
    unit: str | None = None
    factor: float = 1.0
    ratio: float | None = field(default=None, compare=False)

    def __post_init__(self) -> None:
        """Check name and factor."""
        if not self.channel.strip():
            raise InvalidInputError("a signal needs the name of its channel")
        if not MIN_FACTOR <= abs(self.factor) <= MAX_FACTOR:
            raise InvalidInputError(
                f"factor must be finite and not 0, from {MIN_FACTOR:g} to {MAX_FACTOR:g} or its"
                f" negative, got {quoted_value(self.factor)}"
            )

    def factor_to_si(self, column: str, unit: str) -> float:
        """The factor from channel to column in SI; the unit of the file counts if the map has none."""
        factor = require_factor(column, unit if self.unit is None else self.unit, self.channel)
        return self.factor * factor / (self.ratio if self.ratio and column in ANGLES else 1.0)

    def map_option_text(self, column: str) -> str:
        """As on the command line: `psi=-0.5*Steer:deg`."""
        factor = "" if abs(self.factor) == 1 else f"{_factor_text(abs(self.factor))}*"
        unit = "" if self.unit is None else f":{self.unit}"
        return f"{column}={'-' * (self.factor < 0)}{factor}{self.channel}{unit}"

    def geared_by_steering_ratio(self, column: str) -> "SignalSource":
        """The same with a steering ratio, that of `--steering-ratio` or the usual one.

        An angle is divided by it, unless that option does so; a moment is multiplied by it.
        """
        times = self.ratio or USUAL_RATIO
        if column in ANGLES:
            times = 1.0 if self.ratio else 1 / USUAL_RATIO
        return replace(self, factor=times if self.factor > 0 else -times)

    @property
    def ratio_hint(self) -> str:
        """What to put in place of the usual steering ratio; empty where it is not used."""
        return "" if self.ratio else f", with your steering ratio for {USUAL_RATIO}"

    def to_dict(self) -> dict[str, str | float | None]:
        """As in a rig file."""
        return {"channel": self.channel, "unit": self.unit, "factor": self.factor}


def _factor_text(factor: float) -> str:
    """A factor as it was written: 1/14.8, where that is the shorter text."""
    whole, over = f"{factor:.12g}", f"{1 / factor:.6g}"
    is_ratio = "e" not in over and len(over) + 2 < len(whole) and 1 / float(over) == factor
    return f"1/{over}" if is_ratio else whole


@dataclass(frozen=True, kw_only=True)
class SignalMap:
    """Columns of a recording by the channels of a file; a column that is not in it has its own name.

    Attributes:
        signals: by column, out of t, psi, M_z, F_N, psi_dot, M, and those of a car.
        dbc: database of a CAN bus; None for the only one beside the log.
        others: maps for recordings with other channels; a recording takes that whose channels it has.
        steering_ratio: recorded angle of a steering wheel over the wheel's; None for that of the wheel.

    Raises:
        InvalidInputError: a column that recordings do not have, or a unit that it does not have.
    """

    signals: Mapping[str, SignalSource] = field(default_factory=dict)
    dbc: Path | None = None
    others: tuple["SignalMap", ...] = ()
    steering_ratio: float | None = None

    def __post_init__(self) -> None:
        """Check columns and units."""
        for column, signal in self.signals.items():
            if column not in UNITS:
                raise InvalidInputError(
                    f"{excerpt(column)} is no column of a recording; allowed: {', '.join(UNITS)}, {DBC}"
                )
            with prefix_errors(column):
                signal.factor_to_si(column, "")

    def __bool__(self) -> bool:
        """Whether anything is mapped."""
        return bool(self.signals or self.others or self.steering_ratio)

    @property
    def alternatives(self) -> tuple["SignalMap", ...]:
        """This map without the others, then these."""
        return (replace(self, others=()), *self.others)

    def of(self, column: str, channel: str | None = None) -> SignalSource:
        """Where a column comes from; its own name, or the channel given, where the map is silent."""
        source = self.signals.get(column, SignalSource(channel=channel or column))
        return replace(source, ratio=self.steering_ratio)

    def updated(self, other: "SignalMap") -> "SignalMap":
        """This map where the other is silent; of several each with each, or one that is whole alone."""
        joined = list[SignalMap]()
        for mine, one in product(self.alternatives, other.alternatives):
            alone = self.others and any(whole <= one.signals.keys() for whole in _WHOLE)
            below = {} if alone else mine.signals
            new = replace(one, signals={**below, **one.signals}, dbc=one.dbc or mine.dbc)
            joined += [new] * (new not in joined)
        return replace(joined[0], others=tuple(joined[1:]))

    def to_dict(self) -> dict[str, object]:
        """As in a rig file."""
        signals = {column: signal.to_dict() for column, signal in self.signals.items()}
        others = {"others": [other.to_dict() for other in self.others]} if self.others else {}
        return {**signals, **({DBC: str(self.dbc)} if self.dbc else {}), **others}


NO_MAP = SignalMap()
"""Every column has the channel of its own name."""


def parse_signals(text: str) -> SignalMap:
    """A map as on the command line: ``psi=1/14.8*SteeringAngle:deg,t=time:ms,M_z=-Mz,F_N=0.5*Load:kN``.

    A name with a comma, a colon, or a sign at its beginning goes into a rig file instead.

    Raises:
        InvalidInputError: the text is none such, or names a column twice.
    """
    signals: dict[str, SignalSource] = {}
    dbc: Path | None = None
    for part in filter(None, (one.strip() for one in text.split(","))):
        column, equals, source = (one.strip() for one in part.partition("="))
        found = _SOURCE.fullmatch(source)
        if not equals or found is None:
            raise InvalidInputError(
                f"map {excerpt(part)}: expected COLUMN=FACTOR*CHANNEL:UNIT, such as"
                " psi=SteeringAngle:deg or psi=1/14.8*SteeringAngle:deg; numbers have a point"
            )
        if column in signals or (column == DBC and dbc is not None):
            raise InvalidInputError(f"map {excerpt(part)}: {column} is given twice; allowed: once")
        if column == DBC:
            if "\0" in source:
                raise InvalidInputError(f"{DBC} must be the name of a file, got {excerpt(source)}")
            dbc = Path(source)
            continue
        with prefix_errors(f"map {excerpt(part)}"):
            factor = float(found["factor"] or 1) * (-1 if found["sign"] == "-" else 1)
            over = float(found["over"] or 1)
            factor = factor / over if over else inf
            signal = SignalSource(channel=found["channel"].strip(), unit=found["unit"], factor=factor)
            signals = dict(SignalMap(signals={**signals, column: signal}).signals)
    return SignalMap(signals=signals, dbc=dbc)


def parse_maps(texts: Iterable[str]) -> SignalMap:
    """The map of several `--map`; one that names a column again begins that of other recordings."""
    given = [parse_signals(text) for text in texts]
    maps: list[dict[str, SignalSource]] = [{}]
    for one in given:
        if maps[-1].keys() & one.signals.keys():
            maps.append({})
        maps[-1] |= one.signals
    return join_alternative_maps(maps, [one.dbc for one in given])


def join_alternative_maps(
    maps: Sequence[Mapping[str, SignalSource]], databases: Sequence[Path | None]
) -> SignalMap:
    """Maps for recordings with other channels each, and the one database of a bus for all."""
    named = {*databases} - {None}
    if len(named) > 1:
        raise InvalidInputError(f"{DBC} is given twice; allowed: once")
    first, *others = (SignalMap(signals=one, dbc=next(iter(named), None)) for one in maps)
    return replace(first, others=tuple(others))


def as_map_option(entries: Iterable[str]) -> str:
    """Entries of a map as the option `--map`, to be pasted into a shell."""
    return f"--map {shlex.quote(','.join(entries))}"


def corrected_map_text(sources: Mapping[str, SignalSource], changed: Mapping[str, SignalSource]) -> str:
    """What to write so that some columns come from elsewhere, with all that is mapped already.

    Names that `--map` cannot hold make it the first line of the file that has [signals].
    """
    given = {c: s for c, s in sources.items() if s != SignalSource(channel=c)} | dict(changed)
    entries = {column: source.map_option_text(column) for column, source in given.items()}
    found = [_SOURCE.fullmatch(entry.partition("=")[2]) for entry in entries.values()]
    for source, one in zip(given.values(), found, strict=True):
        if "," in source.channel or one is None or one["channel"] != source.channel:
            text = ", ".join(toml_entry(column, source) for column, source in given.items())
            return f"first line of the file with [signals], in its place: {SIGNALS} = {{ {text} }}"
    return as_map_option(entries.values())


def toml_entry(column: str, source: SignalSource) -> str:
    """As a line of a rig file."""
    unit = {} if source.unit is None else {"unit": source.unit}
    return f"{column} = {toml_value({'channel': source.channel, 'factor': source.factor} | unit)}"


def toml_value(value: object) -> str:
    """A table of TOML on one line, a text or truth, or a number."""
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{name} = {toml_value(one)}' for name, one in value.items())} }}"
    if not isinstance(value, str | bool):
        return f"{value!r}"
    # Of what a string of TOML may not hold, JSON leaves the character DEL as it is.
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
