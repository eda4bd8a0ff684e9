"""MDF 3 and 4 (ASAM), as INCA, CANape and vehicle loggers write it, by asammdf."""

from collections.abc import Iterable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from identification.reading.channels_by_name import ChannelFile, ChannelSamples
from identification.reading.formats.optional_libraries import import_library, require_allowed_size
from identification.reading.signal_map import SignalMap
from symbolic import InvalidInputError

GROUPS = {3: 68, 4: 88}
"""Place of the link to the first data group, by the major version."""
LINKS = {3: (4, 4, 8), 4: (8, 24, 32)}
"""Size of a link, and where in a block those to the next block and to the first one inside stand."""
BESIDE_GROUPS = {3: (), 4: (96, 112, 120)}
"""Places of the links to the history, to attachments and to events, of which asammdf makes lists too."""

TIME = 1
"""Kind of a master channel; larger ones are an angle, a distance or a count of samples."""


@contextmanager
def open_mdf(path: Path, _: SignalMap) -> Iterator[ChannelFile]:
    """Channels by name; one of several is `group/channel`, of two in a group `group.number/channel`."""
    asammdf = import_library("asammdf", "mdf", path)
    import_library("asammdf.blocks.mdf_v4", "mdf", path).MDF4.__del__ = _close_quietly
    _require_acyclic_block_lists(path)
    # asammdf leaves a damaged file open that it opened itself.
    with path.open("rb") as raw, closing(asammdf.MDF(raw)) as file:
        places = {}
        for name, found in file.channels_db.items():
            # A group's master channel is its clock, and stands as times beside every other.
            data = [(g, c) for g, c in found if file.masters_db.get(g) != c]
            for group, channel in data:
                twice = sum(g == group for g, _ in data) > 1
                number = f"{group}.{channel}/" if twice else f"{group}/"
                places[name if len(data) == 1 else f"{number}{name}"] = (group, channel)

        def read(name: str) -> ChannelSamples:
            group, channel = places[name]
            _require_in_records(path, name, file.groups[group], (channel, file.masters_db.get(group)))
            # Else asammdf leaves out samples that are marked invalid, and their instants with them.
            signal = file.get(group=group, index=channel, ignore_invalidation_bits=True)
            values, remark, bits = np.asarray(signal.samples), "", signal.invalidation_bits
            if bits is not None and (invalid := np.asarray(bits)).any():
                if values.dtype.kind in "fiub":
                    values = np.where(invalid, np.nan, values)
                remark = (
                    f"{invalid.sum()} of {values.size} values are marked invalid, and count as missing"
                )
            # Of a group without a master asammdf counts the samples, and says that this were a time.
            _, kind = signal.master_metadata or ("", TIME)
            timed = kind <= TIME and (group in file.masters_db or signal.master_metadata is None)
            return ChannelSamples(
                values=values,
                unit=str(signal.unit or ""),
                times=np.asarray(signal.timestamps, dtype=np.float64) if timed else None,
                remark=remark,
            )

        yield ChannelFile(names=list(places), read=read, own_clocks=True)


def _require_acyclic_block_lists(path: Path) -> None:
    """Refuses lists of blocks that lead back into themselves, which asammdf follows for ever."""
    with path.open("rb") as file:
        version = 4 if _unsigned_integer(file, 28, 2) >= 400 else 3
        size, after, inside = LINKS[version]
        seen: set[int] = set()

        def blocks(first: int) -> Iterator[int]:
            at = _unsigned_integer(file, first, size)
            while at:
                if at in seen:
                    raise InvalidInputError(f"{path}: is damaged, a list of its blocks has no end")
                seen.add(at)
                yield at
                at = _unsigned_integer(file, at + after, size)

        for group in blocks(GROUPS[version]):
            for channels in blocks(group + inside):
                list(blocks(channels + inside))
        for first in BESIDE_GROUPS[version]:
            list(blocks(first))


def _unsigned_integer(file: BinaryIO, at: int, size: int) -> int:
    """An unsigned integer of the file, 0 beyond its end."""
    if at >= 2**62:
        return 0
    file.seek(at)
    content = file.read(size)
    return int.from_bytes(content, "little") if len(content) == size else 0


def _require_in_records(path: Path, name: str, group: Any, channels: Iterable[int | None]) -> None:
    """Refuses what lies beyond the records of a group, where asammdf leaves its buffers."""
    head = group.channel_group
    require_allowed_size(path, name, head.cycles_nr)
    record = head.samples_byte_nr + getattr(head, "invalidation_bytes_nr", 0)
    stored = sum(block.original_size for block in group.get_data_blocks())
    whole = stored < (head.cycles_nr + 1) * max(1, record) and (record <= stored or not stored)
    if getattr(group, "sorted", True) and not whole:
        raise InvalidInputError(
            f"{path}: is damaged, the group of {name} declares {head.cycles_nr} records and holds"
            f" {stored} bytes, {record} each"
        )
    for channel in (group.channels[at] for at in channels if at is not None):
        if hasattr(channel, "start_offset"):  # Of MDF 3.
            begin = channel.start_offset + 8 * channel.additional_byte_offset
        else:
            begin = 8 * channel.byte_offset + channel.bit_offset
        if begin + channel.bit_count > 8 * record:
            raise InvalidInputError(
                f"{path}: is damaged, {channel.name} lies at byte {begin // 8} of a record of {record}"
            )


def _close_quietly(file: Any) -> None:
    """Close a file; asammdf's destructor fails on attributes that a damaged file never got."""
    with suppress(Exception):
        file.close()
