"""TDMS, as LabVIEW writes it, by npTDMS."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from identification.reading.channels import ChannelFile, Samples
from identification.reading.formats.opening import library, require_size
from identification.reading.signal_map import SignalMap


@contextmanager
def open_tdms(path: Path, _: SignalMap) -> Iterator[ChannelFile]:
    """Channels as `group/channel`; a waveform's increment is its clock."""
    nptdms = library("nptdms", "tdms", path)
    # npTDMS leaves a damaged file open that it opened itself.
    with path.open("rb") as raw, nptdms.TdmsFile.open(raw) as file:
        channels = {f"{g.name}/{c.name}": c for g in file.groups() for c in g.channels()}

        def read(name: str) -> Samples:
            channel = channels[name]
            require_size(path, name, len(channel))
            values = np.asarray(channel[:])
            if values.dtype.kind == "M":
                values = (values - values[:1]) / np.timedelta64(1, "s")
            step = channel.properties.get("wf_increment")
            start = channel.properties.get("wf_start_offset", 0.0)
            times = None if not step else start + step * np.arange(values.size)
            return Samples(
                values=values, unit=str(channel.properties.get("unit_string", "")), times=times
            )

        yield ChannelFile(names=list(channels), read=read)
