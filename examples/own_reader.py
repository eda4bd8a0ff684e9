"""A reader of your own
====================

Read a recording in a format of one's own: a logger that writes semicolons and degrees.

The logger's file is made here from an embedded recording. Its reader turns it into the `Table` that
every other part of the project takes, so that mu comes out as from the CSV file.
"""

import csv
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from identification import READERS, Recording, Table, fit, read_recording, read_rig
from symbolic import Model

RECORDINGS = Path(__file__).resolve().parent / "recordings"
COLUMNS = {"t": "Time [s]", "psi": "Angle [deg]", "M_z": "Torque [Nm]", "F_N": "Load [N]"}
"""Heading of each column in the logger's files."""


def read_log(path: Path, needed: Sequence[str]) -> Table:
    """Read a file of the logger; angles become radians."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file, delimiter=";"))
    columns = {name: np.array([float(row[COLUMNS[name]]) for row in rows]) for name in needed}
    columns["psi"] = np.radians(columns["psi"])
    return Table(path=path, columns=columns, place=lambda at: f"line {at}")


def write_log(path: Path, recording: Recording) -> None:
    """Write what the logger would have written."""
    values = (recording.t, np.degrees(recording.psi), recording.M_z, recording.F_N)
    np.savetxt(
        path, np.column_stack(values), "%.12g", ";", header=";".join(COLUMNS.values()), comments=""
    )


def main() -> None:
    """Print mu from the CSV file and from the logger's file."""
    rig, source = read_rig(RECORDINGS / "rig.toml"), RECORDINGS / "holdout_c.csv"
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "run.log"
        write_log(log, read_recording(source, rig))
        recordings = [
            read_recording(path, rig, readers={**READERS, ".log": read_log}) for path in (source, log)
        ]
    for recording in recordings:
        mu = fit(Model(), [recording]).values.own[recording.name]["mu"]
        print(f"{recording.name}: mu = {mu:.8f}")


if __name__ == "__main__":
    main()
