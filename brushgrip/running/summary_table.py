"""The table of a summary: a row for each recording."""

import csv
from collections.abc import Iterable
from math import nan
from pathlib import Path

import numpy as np

from brushgrip.estimation.friction_by_direction import OF_DIRECTIONS
from brushgrip.running.row_spool import Row
from brushgrip.wording.formatting import csv_field
from brushgrip.wording.friction_in_words import slippery_ground_note
from identification import Recording
from observers import Estimates, Status
from observers.quality.when_usable import last_usable, steadily_usable_since

FLAGS = {
    name: Status[name.upper()]
    for name in ("rejected", "inconsistent", "acquiring", "suspect", "bound", "implausible")
}
"""Columns of the summary with the share of samples that have a flag [1]: rejected, not explained by
model and stated error, friction being acquired, an input suspect, mu on its bound, a value
implausible."""
FRICTION = ("mu_eff", "mu_eff_std", "mu", "mu_std")
"""Columns of the summary with friction by the last usable sample on the last ground [1]; empty without
one."""
COLUMNS = (
    *("recording", "ground", "samples", "measured", "duration"),
    *FRICTION,
    *OF_DIRECTIONS,
    *("direction", "weaker", "first_usable", "last_usable", "since_usable", "usable", "informed"),
    *FLAGS,
    *("wide", "changes", "steady_from", "upper_limit", "fault", "remark"),
)
"""Columns of the summary; measured are the samples with a torque, of which usable, informed and the
flags are shares [1], implausible that of all samples, wide that without a flag whose deviation of mu is
too large; duration, first_usable, last_usable, from there to the last torque [s], changes of the
ground, what is wrong, and what is told beside friction. first_usable is that of the whole recording;
steady_from [s] is from when on friction was usable up to last_usable, on the last ground and without a
gap of more than 0.5 s. upper_limit is 1 where mu_eff is one, as it is below 0.15 and the sensor's noise
or dry friction is not declared; empty where it is not known. With --by-direction, `direction` is that of
mu_eff, empty where not known; `weaker`, the share of mu_eff that the weaker direction holds less [1]."""
DIGITS = 5
"""Significant digits of a number in the summary."""
FORMULA = ("=", "+", "-", "@", "\t", "\r")
"""Beginnings of a text that spreadsheets take for a formula."""


def summary_row(recording: Recording, estimates: Estimates, beside: str = "") -> Row:
    """The row of a recording that has been estimated."""
    at, measured = last_usable(estimates), estimates.has_measured_torque
    of_rig = at is not None and recording.standstills is None
    is_limit = of_rig and slippery_ground_note(float(estimates.mu_eff[at]), recording.rig) != ""
    count = max(1, int(measured.sum()))

    def share(flag: Status) -> float:
        flagged = estimates.status & flag != 0
        # An implausible torque is left out, and then missing.
        if flag is Status.IMPLAUSIBLE:
            return float(flagged.mean())
        return float((flagged & measured).sum()) / count

    return {
        "recording": recording.name,
        "ground": recording.ground or "",
        "samples": estimates.t.size,
        "measured": int(measured.sum()),
        "duration": float(estimates.t[-1] - estimates.t[0]),
        **{name: nan if at is None else float(getattr(estimates, name)[at]) for name in FRICTION},
        "weaker": nan if at is None else 0.0,
        "first_usable": nan if at is None else estimates.first_usable_time,
        "last_usable": nan if at is None else float(estimates.t[at]),
        "since_usable": nan if at is None else float(estimates.t[measured][-1] - estimates.t[at]),
        "usable": estimates.usable_share,
        "informed": float((estimates.informed & measured).sum()) / count,
        **{name: share(flag) for name, flag in FLAGS.items()},
        "wide": float((estimates.is_too_uncertain & measured).sum()) / count,
        "changes": int(np.count_nonzero(estimates.status & Status.RESET)),
        "steady_from": nan if at is None else steadily_usable_since(estimates)[0],
        "upper_limit": nan if at is None else int(is_limit),
        "fault": "",
        "remark": beside,
    }


def write_summary(path: Path, rows: Iterable[Row]) -> None:
    """Write rows as CSV; what is not known is empty, and no text is a formula to a spreadsheet."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows({name: _csv_cell(value) for name, value in row.items()} for row in rows)


def _csv_cell(value: str | int | float) -> str:
    if isinstance(value, str):
        return f"'{value}" if value.startswith(FORMULA) else value
    return csv_field(value, DIGITS)
