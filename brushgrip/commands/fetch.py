"""`brushgrip fetch`."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from brushgrip.commands.options import option


class PublishedRecordingSet(StrEnum):
    """Sets of recordings that can be fetched."""

    WHEEL = "wheel"
    FRICTION_DAMPER = "friction-damper"
    CHANGED_FRICTION = "changed-friction"


@dataclass(frozen=True, kw_only=True)
class FetchRequest:
    """Download the published measurements at the pinned commit, every digest checked.

    Where BRUSHGRIP_DATA names a folder, they are copied from there and nothing is downloaded.
    """

    which: Annotated[
        PublishedRecordingSet,
        typer.Argument(
            metavar="[wheel|friction-damper|changed-friction]",
            help="The thesis's wheel, or another rig's friction damper with backlash, its friction as it"
            " is or changed by actuators (CC BY-SA 4.0).",
        ),
    ] = PublishedRecordingSet.WHEEL
    out: Path | None = option(
        "--out", "DIR", "Folder to put them in; the user's data folder if left out."
    )

    def run(self) -> None:
        """Bring the published measurements to where recordings are looked for."""
        from brushgrip.inputs.recording_files import download_folder
        from brushgrip.outputs.console import print_line, show_json
        from brushgrip.published import fetch
        from brushgrip.published import friction_damper as damper

        usual_folder, fetch_into = {
            PublishedRecordingSet.WHEEL: (download_folder, fetch.fetch),
            PublishedRecordingSet.FRICTION_DAMPER: (damper.damper_folder, damper.fetch_friction_damper),
            PublishedRecordingSet.CHANGED_FRICTION: (
                damper.changed_friction_folder,
                damper.fetch_changed_friction,
            ),
        }[self.which]
        folder = self.out or usual_folder()
        files = fetch_into(folder, say=print_line)
        show_json({"folder": str(folder), "files": [str(path) for path in files]})
        print_line(f"{len(files)} file{'s' * (len(files) != 1)} in {folder}")
