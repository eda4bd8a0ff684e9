"""Which channels of a file may be the columns of a car, by their names."""

import re
from collections.abc import Collection, Iterator, Sequence

from identification.reading.signal_map import SignalMap
from identification.reading.table import CAR_COLUMNS
from identification.reading.units import bare_name

EITHER = {"rack": "rack or handwheel", "F_rack": "F_rack or T_bar"}
"""Columns of which one or the other is needed."""
_USUAL = {
    "t": r"^t$|time|zeit|^sec",
    "F_rack": r"rack.*(force|frc|load)|zahnstangenkraft|^f_?rack",
    "T_motor": r"^(?!.*(speed|angle|pos|state|temp)).*mot",
    "T_bar": r"bar|tors|(steer|hand|driver).*(torq|trq|mom)|^swt",
    "rack": r"rack|zahnstange",
    "handwheel": r"^(?!.*(rate|speed|vel)).*(steer|hand.?wheel|lenkrad|volant|^swa|^lws|^sas)",
    "brake": r"brak|brems",
    "speed": r"^(?!.*(steer|angle|mot|engine|rate|wheel)).*(speed|veh.*vel|geschw|^v$)",
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
    short = {name: re.split("[/.]", bare_name(name))[-1] for name in names}
    taken = {*(source.channel for source in signals.signals.values()), *CAR_COLUMNS, "t"}
    left = [name for name in names if not {short[name], bare_name(name)} & taken]
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
