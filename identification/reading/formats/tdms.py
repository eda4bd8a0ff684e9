"""TDMS, as LabVIEW writes it, by npTDMS."""

import logging
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from struct import unpack

import numpy as np

from identification.reading.channels_by_name import ChannelFile, ChannelSamples
from identification.reading.formats.optional_libraries import import_library, require_allowed_size
from identification.reading.signal_map import SignalMap
from symbolic import InvalidInputError
from symbolic.float_array_type import Array

_LEAD_IN = 28
"""Of every segment: tag, contents, version, length of all that follows and of its metadata [bytes]."""
_BIG_ENDIAN = 1 << 6
_UNKNOWN_LENGTH = 2**64 - 1
"""Of the segment that LabVIEW was writing when it ended."""


@contextmanager
def open_tdms(path: Path, _: SignalMap) -> Iterator[ChannelFile]:
    """Channels as `group/channel`; a waveform's start and increment are its clock."""
    nptdms = import_library("nptdms", "tdms", path)
    remark = (
        ""
        if _last_segment_has_length(path)
        else "LabVIEW did not close the file, its end may be missing"
    )
    log = nptdms.log.log_manager
    # npTDMS leaves a damaged file open that it opened itself.
    with path.open("rb") as raw, ExitStack() as stack:
        stack.callback(log.set_level, log.log_level)
        log.set_level(logging.CRITICAL)  # What matters of damage is in our message.
        file = stack.enter_context(nptdms.TdmsFile.open(raw))
        channels = {f"{g.name}/{c.name}": c for g in file.groups() for c in g.channels()}
        starts = {
            name: channel.properties["wf_start_time"]
            for name, channel in channels.items()
            if channel.properties.get("wf_increment") and "wf_start_time" in channel.properties
        }
        dated = set[bool]()

        def clock(name: str, size: int) -> Array | None:
            properties = channels[name].properties
            if not (step := properties.get("wf_increment")):
                return None
            dated.add(name in starts)
            if len(dated) > 1:
                raise InvalidInputError(
                    f"{path}: of {name} and another channel only one has a wf_start_time, so no clock is"
                    " common to both; map t to a channel that holds the time"
                )
            late = starts[name] - min(starts.values()) if name in starts else np.timedelta64(0, "s")
            first = late / np.timedelta64(1, "s") + properties.get("wf_start_offset", 0.0)
            return np.asarray(first + step * np.arange(size))

        def read(name: str) -> ChannelSamples:
            channel = channels[name]
            require_allowed_size(path, name, len(channel))
            values = np.asarray(channel[:])
            unit = str(channel.properties.get("unit_string", ""))
            return ChannelSamples(
                values=values, unit=unit, times=clock(name, values.size), remark=remark
            )

        yield ChannelFile(names=list(channels), read=read, own_clocks=True)


def _last_segment_has_length(path: Path) -> bool:
    """Whether the last segment declares its length; npTDMS reads on where a file is shorter."""
    size, at = path.stat().st_size, 0
    with path.open("rb") as file:
        while at < size:
            file.seek(at)
            lead_in = file.read(_LEAD_IN)
            if at and not lead_in.startswith(b"TDSm"[: len(lead_in)]):
                break  # npTDMS says what is wrong
            if len(lead_in) == _LEAD_IN:
                order = ">" if lead_in[4] & _BIG_ENDIAN else "<"
                (length,) = unpack(f"{order}Q", lead_in[12:20])
                if length == _UNKNOWN_LENGTH:
                    return False
                at += _LEAD_IN + length
            if len(lead_in) < _LEAD_IN or at > size:
                raise InvalidInputError(f"{path}: is cut short; copy it again, or save what is in it")
    return True
