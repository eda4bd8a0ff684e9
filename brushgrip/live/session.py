"""A live estimation: reads a source, follows it with an observer, keeps the newest points, records."""

import threading
import time
from collections import Counter, deque
from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from itertools import repeat
from math import nan
from pathlib import Path

import numpy as np

from brushgrip.live.estimate_ring import EstimatePoints, EstimateRing
from brushgrip.live.mapped_columns import Row, columns_out_of_range
from brushgrip.live.recorder import Recorder
from brushgrip.live.row_estimation import EstimatedSample, RowEstimator
from brushgrip.live.session_state_in_words import LastUsableFriction, State, remedy_without_turning
from brushgrip.live.sources import WAIT, Source
from brushgrip.live.steering_adviser import STOP, SteeringAdviser
from brushgrip.live.timestamp_filter import TimestampFilter, clock_time
from observers import ESTIMATE, Estimate, Status
from observers.quality.when_usable import HOLD
from symbolic import InvalidInputError

CAPACITY = 200_000
"""Points that are kept, 200 s at 1 kHz."""
MAX_QUEUED_SAMPLES = 20_000
"""Samples that wait for the observer; of a source that cannot wait what comes then is lost."""
AT_ONCE = 20
"""Samples between two looks at what else is to be done."""
LOOKS = 1.0
"""Between looks at whether the columns are plausible [s]."""
AGAIN = 1.0
"""Between attempts to open a source that is lost [s]."""


class Session:
    """Two threads: one reads the source, one estimates.

    `recording`, whether one is wanted, may be set at any time; a recording begins with what is in memory
    of the present stretch. `recorded` are files that are done.
    """

    def __init__(
        self,
        open_source: Callable[[], Source],
        estimator: RowEstimator,
        *,
        record: Path | None = None,
        adviser: SteeringAdviser | None = None,
        listeners: tuple[Callable[[State], None], ...] = (),
    ) -> None:
        """Prepare; nothing runs before `start`.

        The source is opened again where it is lost. A file to record to is written from the beginning.
        Listeners are told the state after every batch, and now and then without; they must not block.
        """
        self.ring, self.estimator = EstimateRing(CAPACITY), estimator
        self._open, self._adviser, self._listeners = open_source, adviser, listeners
        self._file, self.recording = record, record is not None
        self._recorder: Recorder | None = None
        self.recorded: list[Path] = []
        self._clock, self._counts = TimestampFilter(), Counter[str]()
        self._waiting: deque[tuple[float, Row]] = deque()
        self._arrived, self._stop = threading.Event(), threading.Event()
        self._threads: list[threading.Thread] = []
        self._stretch, self._done, self._came, self._looked = 0, -np.inf, -np.inf, 0.0
        self._t, self._fault, self._implausible, self._ended = nan, "", "", False
        self._remarks, self._crash, self._is_interrupted = "", "", False
        self._newest: Estimate | None = None
        self._measured, self._last_usable, self._estimating = -np.inf, LastUsableFriction(), False

    def start(self) -> None:
        """Open the source and run."""
        try:
            source = self._open()
        except OSError as error:
            raise InvalidInputError(f"the source cannot be opened: {error}") from None
        for name, target in (
            ("read", lambda: self._read_and_reopen(source)),
            ("estimate", self._estimate_queued),
        ):
            self._threads.append(threading.Thread(target=target, name=f"live-{name}", daemon=True))
            self._threads[-1].start()

    @property
    def has_begun(self) -> bool:
        """Whether it was started."""
        return bool(self._threads)

    def stop(self) -> None:
        """Close the source, estimate what waits, and end the recording."""
        self._stop.set()
        for thread in self._threads:
            thread.join()

    @property
    def has_plausible_columns(self) -> bool:
        """Whether the columns are in the units and of the signs that they are taken for."""
        return not self._implausible

    def state(self) -> State:
        """How the session stands now."""
        estimate, age = self._newest, clock_time() - self._came
        recorder, ended = self._recorder, self._is_over
        # Nobody turns any more, or no turning makes friction known.
        idle = ended or age >= HOLD or not self.has_plausible_columns
        idle |= estimate is not None and Status.INCONSISTENT in estimate.status
        advice = self._adviser.text if self._adviser and not idle else ""
        counts = {**self._counts, "late": self._clock.late, "wrong time": self._clock.wrong}
        return State(
            t=self._t,
            estimate=estimate,
            usable=bool(estimate and estimate.usable and age < HOLD and self.has_plausible_columns),
            status=self._state_text(estimate, age, stops=STOP in advice),
            advice=advice,
            counts={name: number for name, number in counts.items() if number},
            recording=f"{recorder.path}, {recorder.samples} samples" if recorder else "",
            ended=ended,
            weaker=self.estimator.weaker,
            note="; ".join(filter(None, (self._remarks, self.estimator.note))),
        )

    @property
    def _is_over(self) -> bool:
        """Whether nothing is estimated any more."""
        return self._ended and (self._is_interrupted or not self._waiting)

    def _state_text(self, estimate: Estimate | None, age: float, *, stops: bool) -> str:
        parts = [self._crash or self._fault, self._implausible]
        if self._is_over:
            why = "stopped" if self._is_interrupted else "the source has ended"
            told = self._last_usable.told
            parts.append(told if self._crash else f"{why}: {told}")
        elif age >= HOLD:
            none = "compiling the observer" if self._estimating else "no sample has come yet"
            old = f"{age:.1f} s behind the source" if self._waiting else f"no sample for {age:.0f} s"
            parts.append(old if estimate else none)
        elif estimate is not None:
            remedy = remedy_without_turning(estimate.remedy) if stops else estimate.remedy
            parts += [remedy, *self.estimator.suspicions]
        return "; ".join(filter(None, parts))

    def _read_and_reopen(self, source: Source) -> None:
        """Hand on what comes, until the end."""
        while not self._stop.is_set():
            try:
                with closing(source):
                    self._queue_rows(source)
                return
            except EOFError:
                self._ended = True
                return
            except (OSError, InvalidInputError) as error:
                self._fault = f"{error}; it is opened again"
            while not self._stop.wait(AGAIN):
                try:
                    source = self._open()
                except (OSError, InvalidInputError):
                    continue
                self._counts["reopened"] += 1
                self._fault = ""
                break

    def _queue_rows(self, source: Source) -> None:
        refused = 0
        while not self._stop.is_set():
            rows = source.read()
            if new := source.refused - refused:
                self._counts["unreadable"], refused = self._counts["unreadable"] + new, source.refused
                self._fault = f"{refused} not readable, the last: {source.fault}"
            elif rows:
                self._fault = ""
            while source.waits and len(self._waiting) > MAX_QUEUED_SAMPLES - len(rows):
                if self._stop.wait(WAIT):
                    return
            room = MAX_QUEUED_SAMPLES - len(self._waiting)
            self._counts["lost"] += max(len(rows) - room, 0)
            self._waiting.extend(zip(repeat(clock_time()), rows[:room], strict=False))
            if rows:
                self._arrived.set()

    def _estimate_queued(self) -> None:
        """Estimate what has come, in small batches."""
        try:
            while not self._stop.is_set() or self._waiting:
                if not self._waiting:
                    self._arrived.wait(WAIT)
                    self._arrived.clear()
                for _ in range(min(AT_ONCE, len(self._waiting))):
                    self._estimate_row(*self._waiting.popleft())
                self._start_or_stop_recording()
                self._check_plausibility()
                for listener in self._listeners:
                    listener(self.state())
        except Exception as error:
            # Said on every page, and no estimate is usable any more.
            self._crash, self._came = f"stopped by an error: {error}", -np.inf
            raise
        finally:
            self._is_interrupted, self._ended = not self._ended or bool(self._crash), True
            self._end_recording()
            for listener in self._listeners:
                listener(replace(self.state(), usable=False, ended=True))

    def _estimate_row(self, came: float, row: Row) -> None:
        self._counts["samples"] += 1
        for timed in self._clock(row):
            if timed.begins:
                self._begin_stretch()
            wrong, self._estimating = columns_out_of_range(timed.row), True
            self._counts["out of range"] += len(wrong)
            try:
                if points := self.estimator({**timed.row, **dict.fromkeys(wrong, nan)}):
                    self._store(points, came)
            except InvalidInputError as error:
                self._counts["unreadable"] += 1
                self._fault = str(error)
            self._estimating = False

    def _begin_stretch(self) -> None:
        if self._stretch:
            self._counts["begun anew"] += 1
        self._end_recording()
        self._stretch, self._measured = self._stretch + 1, -np.inf
        self.estimator.reset()

    def _store(self, points: list[EstimatedSample], came: float) -> None:
        begin, self._done, self._came = self.ring.end, time.monotonic(), came
        self.ring.append(points, self._stretch, self._done)
        for point in points:
            self._count_sample(point)
        if self._recorder is not None:
            self._write(self._recorder, self.ring.since(begin))

    def _count_sample(self, point: EstimatedSample) -> None:
        """Count a sample; the newest one counts, where torques come more slowly that with the last."""
        t, estimate = point.recorded[0], point.estimate
        self._counts["without a torque"] += bool(estimate.status & Status.MISSING)
        usable = estimate.usable and not self._implausible
        self._counts["usable"] += usable
        self._last_usable.add_sample(t, point.psi, estimate, usable=usable)
        if estimate.status != Status.MISSING:
            self._measured = t
        elif t - self._measured < HOLD:
            return
        self._newest, self._t = estimate, t

    def _check_plausibility(self) -> None:
        """Now and then, see whether the columns are what they are taken for."""
        due = self._done >= self._looked + LOOKS or (self._ended and not self._waiting)
        if not due or self._done <= self._looked:
            return
        self._looked = self._done
        points = self.ring.since(self.ring.end - MAX_QUEUED_SAMPLES, self._stretch)
        recorded = points.values[:, : len(self.estimator.columns)]
        self._implausible = self.estimator.implausibility_text(recorded)
        self._remarks = self.estimator.remarks(recorded)
        if not self.has_plausible_columns:
            self._counts["usable"], self._last_usable = 0, LastUsableFriction()

    def _start_or_stop_recording(self) -> None:
        """Begin or end a recording where that is wanted."""
        if not self.recording:
            self._end_recording()
        elif self._recorder is None and self.estimator.columns and self.ring.end:
            name = self._file or Path(time.strftime("live_%Y-%m-%d_%H%M%S.parquet"))
            try:
                self._recorder = Recorder(name, self.estimator.columns)
            except InvalidInputError as error:
                self._fault, self.recording = f"not recorded: {error}", False
            else:
                self._write(self._recorder, self.ring.since(0, self._stretch))

    def _write(self, recorder: Recorder, points: EstimatePoints) -> None:
        values, columns = points.values, len(self.estimator.columns)
        rows = np.hstack([values[:, :columns], values[:, -len(ESTIMATE) :]])
        try:
            recorder.write(rows)
        except OSError as error:
            self._fault, self.recording = f"the recording broke off: {error}", False
            self._recorder = None

    def _end_recording(self) -> None:
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return
        try:
            recorder.close()
            self.recorded.append(recorder.path)
        except OSError as error:
            self._fault, self.recording = f"the recording broke off: {error}", False
