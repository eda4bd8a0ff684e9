"""Samples from a CAN bus, by python-can and cantools."""

from pathlib import Path
from typing import Any

import numpy as np

from brushgrip.live.mapped_columns import MappedColumns, Row
from brushgrip.live.sources import MAX_MESSAGES_AT_ONCE, WAIT
from identification.reading.formats.can import is_extended, read_database, within_signal_range
from identification.reading.formats.optional_libraries import import_library

MAX_SKEW = 0.1
"""An angle and a torque of a bus that are further apart are no one sample [s]."""
SILENCE, USUAL = 2.0, 5.0
"""A signal that came again and again is silent after so long [s], and so many of its longest pauses."""


class CanSource:
    """Signals of a bus. A sample is complete when its angle and its torque have both come anew.

    The others have their newest values; where one of them falls silent, it is missing, and so is the
    torque. The time is that of the frame that completes the sample; where angle or torque stays away
    for `MAX_SKEW` the sample lacks it.
    """

    waits = False

    def __init__(self, interface: str, channel: str, dbc: Path, columns: MappedColumns) -> None:
        """Join the bus; an OSError where there is none."""
        self.refused, self.fault = 0, ""
        can, database = import_library("can", "can", dbc), read_database(dbc)
        listed = {f"{m.name}.{s.name}": (m, s) for m in database.messages for s in m.signals}
        found = columns.find({name: s.unit or "" for name, (_, s) in listed.items()}, by_part=True)
        self._messages: dict[tuple[int, bool], tuple[Any, list[tuple[Any, str, float]]]] = {}
        for column, (name, factor) in found.items():
            message, signal = listed[name]
            of_message = self._messages.setdefault(
                (message.frame_id, is_extended(message)), (message, [])
            )
            of_message[1].append((signal, column, factor))
        self._angle, self._torque = (
            next(c for c in any_of if c in found) for any_of in (columns.angles, columns.torques)
        )
        self._values = dict.fromkeys(found, np.nan)
        self._new: dict[str, float] = {}
        self._came: dict[str, tuple[float, float]] = {}
        try:
            self._bus = can.Bus(interface=interface, channel=channel)
        except Exception as error:  # Every interface has errors of its own.
            raise OSError(f"can:{interface}:{channel}: {error}") from None
        self._lost = (can.CanError, OSError)

    def read(self) -> list[Row]:
        """The samples that frames have completed."""
        rows: list[Row] = []
        try:
            for place in range(MAX_MESSAGES_AT_ONCE + 1):
                if (frame := self._bus.recv(0 if place else WAIT)) is None:
                    break
                self._add_frame_to_sample(frame, rows)
        except self._lost as error:
            raise OSError(f"the bus is lost: {error}") from None
        return rows

    def _add_frame_to_sample(self, frame: Any, rows: list[Row]) -> None:
        """Put the values of a frame into the present sample, and add it where it is complete."""
        wanted = self._messages.get((frame.arbitration_id, frame.is_extended_id))
        if wanted is None or frame.is_error_frame or frame.is_remote_frame:
            return
        now, (message, signals) = frame.timestamp, wanted
        if self._new and now - min(self._new.values()) > MAX_SKEW:
            self._add_sample(min(self._new.values()), rows)
        padded = frame.is_fd and len(frame.data) > message.length
        try:
            if len(frame.data) != message.length and not padded:
                raise ValueError(f"{len(frame.data)} bytes, the database has {message.length}")
            content = message.decode(bytes(frame.data), decode_choices=False)
        except Exception as error:  # cantools has several of its own.
            self.refused, self.fault = self.refused + 1, f"{message.name}: {error}"
            return
        for signal, column, factor in signals:
            if signal.name not in content:  # The multiplexer has another one in its place.
                continue
            last, pause = self._came.get(column, (now, 0.0))
            self._came[column] = now, pause if self._is_silent(column, now) else max(pause, now - last)
            value = float(content[signal.name])
            usable = bool(within_signal_range(signal, np.array(value)))
            self._values[column] = value * factor if usable else np.nan
            if column in (self._angle, self._torque):
                self._new[column] = now
        if len(self._new) == 2:
            self._add_sample(now, rows)

    def _add_sample(self, now: float, rows: list[Row]) -> None:
        both = (self._angle, self._torque)
        missing = {column: np.nan for column in both if column not in self._new}
        if silent := [c for c in self._came if c not in both and self._is_silent(c, now)]:
            missing |= dict.fromkeys((*silent, self._torque), np.nan)
            self.refused, self.fault = self.refused + 1, f"{', '.join(silent)} came no more"
        rows.append({"t": now, **self._values, **missing})
        self._new.clear()

    def _is_silent(self, column: str, now: float) -> bool:
        last, pause = self._came.get(column, (now, 0.0))
        return pause > 0 and now - last > max(SILENCE, USUAL * pause)

    def close(self) -> None:
        """Leave the bus."""
        self._bus.shutdown()
