"""Values of a source by the names it gives them, as columns of a recording in SI units."""

import logging
from collections.abc import Mapping
from functools import lru_cache
from math import inf

from identification.reading.channels_by_name import map_hint, match_channel
from identification.reading.checked_sample_table import MAX_VALUES, possible_columns
from identification.reading.map_for_recording import add_unit_by_name, choose_map_for_channels
from identification.reading.signal_map import SignalMap
from identification.reading.units import unit_in_brackets
from symbolic import InvalidInputError
from symbolic.tables.toml_and_json_parsing import excerpt

Row = Mapping[str, float]
"""One sample: values by column, SI units, NaN where one is missing; `t` is its time [s]."""
_LOG = logging.getLogger(__name__)
MAX_NAMES = 200
"""Names of a source that are remembered."""
MAX_LISTED = 5
"""Names that a message lists."""
OF_WHEEL, OF_CAR = (("psi",), ("M_z", "M")), (("rack", "handwheel"), ("F_rack", "T_bar"))
"""Columns of angle and torque, of each the first that a source has."""


def columns_out_of_range(row: Row) -> list[str]:
    """Columns with a value for which a file would be refused."""
    sizes = {name: MAX_VALUES.get(name, (inf,))[0] for name in row if name != "t"}
    return [n for n, size in sizes.items() if abs(row[n]) > size or (n == "F_N" and row[n] <= 0)]


class MappedColumns:
    """The columns that a map finds among the names of a source."""

    def __init__(self, where: str, signals: SignalMap, *, car: bool) -> None:
        """Remember the map; `where` names the source in messages."""
        self.angles: tuple[str, ...]
        self.torques: tuple[str, ...]
        self.angles, self.torques = OF_CAR if car else OF_WHEEL
        self._where, self._signals = where, signals
        self._needed = ("t",) if car else ("t", "psi", "F_N")
        self._units: dict[str, str] = {}
        self._said: set[str] = set()
        # A source whose names change with every line is no reason to remember them all.
        self._plan_of = lru_cache(maxsize=10)(self._columns_among_names)

    def find(self, units: Mapping[str, str], *, by_part: bool = False) -> dict[str, tuple[str, float]]:
        """Name and factor to SI of each column, by the unit of each name; its last part may do."""
        names, found = list(units), {}
        signals = choose_map_for_channels(self._where, self._signals, names)
        for column in possible_columns(self._needed):
            source = signals.of(column)
            name = match_channel(self._where, source.channel.split("/")[-1], names, by_part=by_part)
            if name is not None:
                source, said = add_unit_by_name(column, source, units[name])
                if said and column not in self._said:
                    self._said.add(column)
                    _LOG.warning("brushgrip: %s: %s: by the name; a map overrides it", self._where, said)
                found[column] = (name, source.factor_to_si(column, units[name]))
        alternatives = (self.angles, self.torques, *(() if "rack" in self.angles else (("F_N",),)))
        lacking = [any_of[0] for any_of in alternatives if not any(c in found for c in any_of)]
        if lacking:
            hint = map_hint(lacking, names, signals, in_python=False)
            raise InvalidInputError(f"{self._where}: {', '.join(lacking)} missing{hint}")
        return found

    def __call__(self, values: Mapping[str, float]) -> dict[str, float]:
        """The columns of values by name; a line may hold some of the names that others hold."""
        plan = self._plan_of(tuple(values))
        if not plan.keys() - {"t"}:
            names = ", ".join(list(values)[:MAX_LISTED]) or "nothing"
            raise InvalidInputError(f"{self._where}: no column but a time in {excerpt(names)}")
        return {column: values[name] * factor for column, (name, factor) in plan.items()}

    def _columns_among_names(self, names: tuple[str, ...]) -> dict[str, tuple[str, float]]:
        own = {name: unit_in_brackets(name) for name in names[:MAX_NAMES]}
        self._units = dict([*self._units.items(), *own.items()][:MAX_NAMES])
        try:
            found = self.find(own)
        except InvalidInputError:
            found = self.find(self._units)
        return {column: of for column, of in found.items() if of[0] in names}
