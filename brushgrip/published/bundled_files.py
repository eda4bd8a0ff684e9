"""The demo's recordings and the examples: in a checkout, or inside an installed package."""

from pathlib import Path
from shutil import copytree, ignore_patterns

import brushgrip
from brushgrip.inputs.command_inputs import Inputs, gather_inputs
from brushgrip.outputs.atomic import staged_directory
from brushgrip.outputs.console import print_line, show_json
from symbolic import InvalidInputError

RIG = "rig.toml"
GROUND = "plate"
"""Ground of the demo's recordings."""
TRUE_FRICTION = "1.28 to 1.42"
"""Effective friction that `examples/make_recordings.py` simulates in them, least and greatest [1]."""
SIMULATED, FIRST = "reference_rig", "estimate_in_a_loop.py"


def demo_inputs_and_training_count() -> tuple[Inputs, int]:
    """The demo's recordings with their rig, and how many of them are for training; these come first."""
    folder = demo_folder()
    training = sorted(folder.glob("train*.csv"))
    names = [str(path) for path in (*training, *sorted(folder.glob("holdout*.csv")))]
    return gather_inputs(names, rig=folder / RIG, ground=[GROUND]), len(training)


def demo_folder() -> Path:
    """The folder of the demo's recordings."""
    package = Path(brushgrip.__file__).parent
    places = (package.parent / "examples", package / "embedded")
    folders = [place / "recordings" for place in places]
    for folder in folders:
        if (folder / RIG).is_file():
            return folder
    raise InvalidInputError(
        f"the demo's recordings are missing from this installation; looked for {RIG} in "
        f"{' and '.join(map(str, folders))}; install brushgrip anew"
    )


def copy_examples(out: Path) -> None:
    """Writes the examples, their recordings and the rig that they simulate to a new folder."""
    if out.is_dir() and any(out.iterdir()):
        raise InvalidInputError(f"{out}: is not empty; name a new folder for the examples")
    source = demo_folder().parent
    rig = next(place for place in (source, source.parent) if (place / SIMULATED).is_dir()) / SIMULATED
    leave = ignore_patterns("__pycache__", "*_output")
    with staged_directory(out) as stage:
        copytree(source, stage, ignore=leave, dirs_exist_ok=True)
        copytree(rig, stage / SIMULATED, ignore=leave, dirs_exist_ok=True)
    scripts = sorted(str(path) for path in out.glob("*.py"))
    print_line(f"wrote {len(scripts)} examples to {out}; python {out / FIRST} runs one")
    show_json({"wrote": scripts})
