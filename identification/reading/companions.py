"""Files that are read along with a recording, though nobody named them."""

from pathlib import Path

from identification.reading.formats.opening import EXTRAS


def companions(path: Path) -> list[Path]:
    """The databases beside a CAN log, the rest of a ROS 2 bag, the index of a TDMS file.

    Args:
        path: of the recording.
    """
    suffix = path.suffix.lower()
    if EXTRAS.get(suffix) == "can":
        return sorted(path.parent.glob("*.dbc"))
    if suffix in (".db3", ".mcap"):
        patterns = ("*.db3", "*.mcap", "metadata.yaml")
        return sorted(other for pattern in patterns for other in path.parent.glob(pattern))
    return [path.with_name(f"{path.name}_index")] if suffix == ".tdms" else []
