"""`brushgrip diagnose`."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from brushgrip.commands.options import (
    Force,
    Jobs,
    OutFolder,
    RecordingRequest,
    Scheduler,
    VehicleFile,
    option,
)

if TYPE_CHECKING:
    from concurrent.futures import Executor


@dataclass(frozen=True, kw_only=True)
class DiagnoseRequest(RecordingRequest):
    """Find what the declared model lacks; write diagnosis.json, model.json and report.html.

    An interrupted search is kept; the same command continues it.

    With --vehicle, of a car from its steering: gear friction, play of joints, compliance, jacking,
    damping and brakes beyond what the vehicle file declares.
    """

    out: OutFolder
    vehicle: VehicleFile = None
    holdout: list[str] | None = option(
        "--holdout",
        "REC...",
        "Recordings held out to judge the models: one or more names after the flag.",
    )
    robust: float | None = option(
        "--robust",
        "SHARE",
        "Threshold of Huber's loss, as a share of the torque range, for a torque with outliers:"
        " 1.5 times its noise.",
    )
    ground: list[str] | None = option(
        "--ground",
        "NAME",
        "What the recordings stand on, or NAME=REC,REC for some of them, repeated for others;"
        " goes before '# ground = steel' in a CSV file.",
    )
    jobs: Jobs = None
    scheduler: Scheduler = None
    force: Force = False

    def run(self) -> None:
        """Search for what the declared model lacks, and write all results."""
        from brushgrip.running.dask_or_local_executor import cluster_or_local_executor
        from symbolic import CANDIDATES

        # The processes import what they need beside this one, which imports more, and reads.
        with cluster_or_local_executor(self.scheduler, self.jobs, start=len(CANDIDATES)) as executor:
            self._diagnose(executor)

    def _diagnose(self, executor: "Executor | None") -> None:
        from brushgrip.estimation.recording_warnings import doubtful_inputs
        from brushgrip.outputs.atomic import staged_directory
        from brushgrip.outputs.console import print_line, warn
        from brushgrip.outputs.provenance import require_same_run
        from brushgrip.report.diagnosis_folder import (
            DIAGNOSIS,
            clean_up_and_print,
            diagnose_and_write,
            files_diagnosis_may_write,
            thinning_note,
        )
        from brushgrip.running.unfinished_search import trial_journal
        from identification import LEAST_SQUARES, Huber
        from identification.reading.trimming_and_thinning import thin_recordings
        from symbolic import CANDIDATES
        from symbolic.vehicle.candidate_effects import CAR_EFFECTS

        training, held_out = len(self.recordings), self.holdout or []
        inputs = self.inputs(held_out, ground=self.ground, vehicle=self.vehicle)
        inputs.refuse_overwriting(files_diagnosis_may_write(self.out))
        read = inputs.recordings()
        made = inputs.provenance(
            held_out=len(held_out), robust=self.robust, ground=list(self.ground or ())
        )
        earlier = require_same_run(self.out / DIAGNOSIS, made, force=self.force)
        suspected = doubtful_inputs(read)
        for line in suspected:
            warn(line)
        library = CAR_EFFECTS if self.vehicle else CANDIDATES
        loss = LEAST_SQUARES if self.robust is None else Huber(threshold=self.robust)
        with trial_journal(self.out) as journal, staged_directory(self.out) as folder:
            used, shortened = thin_recordings(read)
            for line in filter(None, (shortened, thinning_note(used))):
                print_line(line)
            # The search bounds the recordings itself, and notes that in its result.
            found = diagnose_and_write(
                folder,
                (read[:training], read[training:]),
                (used[:training], used[training:]),
                made,
                executor,
                notes=[*suspected.values()],
                with_inclination=lambda one: thin_recordings(inputs.recordings(inclination=one))[0],
                loss=loss,
                candidates=[*library.values(), *inputs.effects],
                jobs=self.jobs,
                journal=journal,
            )
        clean_up_and_print(self.out, earlier, *found)
