"""`brushgrip demo`."""

from dataclasses import dataclass
from pathlib import Path
from shutil import copyfile

from brushgrip.commands.options import Force, option, valid_folder_name


@dataclass(frozen=True, kw_only=True)
class DemoRequest:
    """Show the main job on embedded recordings: diagnosis, report and friction over time."""

    out: Path = option(
        "--out",
        "DIR",
        "Folder to write to.",
        default=Path("demo_output"),
        callback=valid_folder_name,
        show_default=True,
    )
    examples: Path | None = option(
        "--examples",
        "DIR",
        "Write the scripts of the examples to this new folder, and do nothing else.",
        callback=valid_folder_name,
    )
    force: Force = False

    def run(self) -> None:
        """Diagnose the embedded recordings and write all results; or write the examples alone."""
        from brushgrip.outputs.atomic import staged_directory
        from brushgrip.outputs.provenance import require_same_run
        from brushgrip.published.bundled_files import RIG, copy_examples, demo_inputs_and_training_count
        from brushgrip.report.diagnosis_folder import DIAGNOSIS, clean_up_and_print, diagnose_and_write
        from identification.selection.trial_runner import worker_pool

        if self.examples is not None:
            copy_examples(self.examples)
            return
        inputs, training = demo_inputs_and_training_count()
        read = inputs.recordings()
        made = inputs.provenance()
        earlier = require_same_run(self.out / DIAGNOSIS, made, force=self.force)
        with staged_directory(self.out) as stage, worker_pool(None) as executor:
            parts = read[:training], read[training:]
            found = diagnose_and_write(stage, parts, parts, made, executor)
            copyfile(inputs.rig or RIG, stage / RIG)
        clean_up_and_print(self.out, earlier, *found)
