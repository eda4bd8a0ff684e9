"""`brushgrip estimate`."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from brushgrip.commands.options import (
    Jobs,
    ModelRunRequest,
    ObserverUsed,
    Scheduler,
    StiffnessState,
    TuningProfile,
    TuningValues,
    VehicleFile,
    option,
    output_file_option,
)
from brushgrip.inputs.option_choices import ObserverName

if TYPE_CHECKING:
    from brushgrip.running.row_spool import Row
    from identification import FoundModel

MAX_PRINTED = 20
"""Most recordings of which --summary prints the table too."""


@dataclass(frozen=True, kw_only=True)
class EstimateRequest(ModelRunRequest):
    """Estimate friction over time, causally, one row a sample.

    Friction by the last usable sample is printed; --out writes all samples, and a picture beside them.

    Columns of OUT.csv: t,mu,mu_std,M_z_predicted,informed,usable,mu_eff,mu_eff_std,M_slide,nis,status.
    Act on friction where usable is 1. mu_eff is effective friction, which compares between models: the
    torque M_slide [N m] of a steady full slide over that of the declared patch with mu = 1. mu is that
    of the model's own law. informed and usable are 0 or 1, status is a number; nis is the square of
    measured minus predicted over its variance. With root, the method of [Györök 2022], deviations and
    nis are empty.

    With --vehicle, from the steering of a car: its columns are rack or handwheel, F_rack or T_bar and
    T_motor, and, where there, brake and speed. While the car rolls, the estimate is held.

    From the aligning torque M_z, or, where the recording has none, from the steering torque M; that
    takes J_A and b_t of the rig. With --smooth an estimate knows later samples on the same ground too,
    for those who work offline; usable is what is usable without it.

    With --by-direction friction has one value for each direction of turning; mu, mu_eff and M_slide are
    those of the direction that loads the patch. --json and --summary have mu_eff_positive and
    mu_eff_negative too, of the last usable sample of turning to positive and to negative psi. What the
    torque's zero may be off by is part of the band: declare it (zero of the rig) on slippery ground.
    Without --model nothing is usable before the torque's scale is found with one friction for both
    directions; with --model nothing checks the scale.

    Several recordings go to OUT_<recording>.csv, without pictures, and to rows of --summary. There
    friction is that of the last usable sample, at last_usable [s], and steadily usable from steady_from
    on, without a gap of more than 0.5 s (first_usable may be of a ground before); changes counts changes
    of the ground. upper_limit is 1 where mu_eff is only that: below 0.15, with noise or dry friction of
    the sensor not declared.
    usable, informed and the flags are shares, 0 to 1, of the samples with a torque, whose number is
    measured; implausible is that of all samples, and wide that of samples without a flag whose deviation
    of mu is too large to be informed. What is wrong with a recording stands in its row as fault; the
    others are estimated all the same, and the exit status is 2. remark is what a single recording is
    told beside its friction. A text in --summary that a spreadsheet would take
    for a formula begins with an apostrophe.
    """

    observer: ObserverUsed = ObserverName.EKF
    out: Path | None = output_file_option(
        "--out", "OUT.csv", "Table to write with a row for each sample."
    )
    vehicle: VehicleFile = None
    summary: Path | None = output_file_option(
        "--summary", "TABLE.csv", "Table to write with a row for each recording."
    )
    tuning: TuningProfile = None
    tune: TuningValues = None
    smooth: bool = option(
        "--smooth", help="Estimate every sample from the whole recording; takes ekf.", default=False
    )
    by_direction: bool = option(
        "--by-direction",
        help="Friction for each direction of turning; takes M_z, ekf or mhe.",
        default=False,
    )
    stiffness_state: StiffnessState = None
    picture: Path | None = output_file_option(
        "--picture", "PNG", "Picture of mu(t); OUT.png if left out."
    )
    jobs: Jobs = None
    scheduler: Scheduler = None

    def run(self) -> None:
        """Write friction over time for each recording, a picture for a single one, and the summary."""
        from brushgrip.estimation.observe_recording import aligning_measurement_model, observer_factory
        from brushgrip.inputs.command_inputs import staged_files_with_provenance
        from brushgrip.inputs.option_values import chosen_tuning
        from brushgrip.outputs.atomic import is_same_file, table_path
        from brushgrip.running.estimate_batch import (
            EstimateTask,
            estimate_all,
            output_files_beside_tables,
            task_executor,
        )
        from brushgrip.running.summary_table import write_summary
        from symbolic import InvalidInputError

        tuning = chosen_tuning(self.tuning, self.tune)
        aligning = aligning_measurement_model(
            by_direction=self.by_direction, stiffness_state=self.stiffness_state
        )
        factory = observer_factory(self.observer, tuning, aligning)
        alone = len(self.recordings) == 1 and self.summary is None
        finals = output_files_beside_tables(self.out, self.summary, self.picture, alone=alone)
        inputs = self.model_inputs(vehicle=self.vehicle)
        count = len(inputs.paths)
        outs = {name: table_path(self.out, name, count).absolute() for name in inputs.paths if self.out}
        tasks = (
            EstimateTask(
                inputs=one,
                observer=self.observer,
                factory=factory,
                smooth=self.smooth,
                out=outs.get(name),
                budget=alone,
            )
            for name, one in inputs.one_by_one()
        )
        tables = [] if alone else [*outs.values()]
        settings = {
            "observer": self.observer.value,
            "tuning": tuning and tuning.to_dict(),
            "by_direction": self.by_direction,
            "stiffness": {None: "a state by a model found", True: "a state", False: "known"}[
                self.stiffness_state
            ],
        }
        if self.summary and any(is_same_file(self.summary, table) for table in tables):
            raise InvalidInputError(f"{self.summary}: --summary and --out must name different files")
        with staged_files_with_provenance(inputs, finals, settings, tables) as stages:
            if alone:
                # There may be a picture without a table, but no table without its picture.
                own = dict(zip(("picture", "out"), reversed(stages), strict=False))
                tasks = (replace(t, out=own.get("out"), picture=own.get("picture")) for t in tasks)
            with task_executor(inputs, self.jobs, self.scheduler) as (submit, report):
                rows, last = estimate_all(tasks, count, submit, report)
            if alone and last.fault:
                raise last.fault
            if self.summary:
                write_summary(stages[0], rows)
        self._print_estimates(rows, last.lines, finals, inputs.read_found_model())

    def _print_estimates(
        self,
        rows: "Sequence[Row]",
        lines: Sequence[str],
        finals: Sequence[Path],
        found: "FoundModel | None",
    ) -> None:
        """Print what was estimated, of one recording in lines; those that could not be are a fault."""
        from brushgrip.outputs.console import print_line, print_table, show_json
        from brushgrip.report.print_diagnosis_and_fits import print_ground_values
        from brushgrip.wording.diagnosis_in_words import taken_from_model
        from brushgrip.wording.recording_remarks import (
            MAX_NAMED,
            friction_lines_by_ground,
            friction_range,
            printed_rows,
            remark_counts,
            unknown_friction_lines,
        )
        from symbolic import InvalidInputError

        faults = sum(bool(row["fault"]) for row in rows)
        causes = list(islice(unknown_friction_lines(rows), MAX_NAMED + 1))
        if found is not None:
            print_line(f"From {self.model}: {taken_from_model(found)}.")
            told = (row for row in rows if not row["fault"])
            print_ground_values(
                {str(row["recording"]): str(row["ground"]) or None for row in told}, found
            )
        if len(rows) == 1 and not self.summary:
            for line in lines:
                print_line(line)
        else:
            if not self.summary or len(rows) <= MAX_PRINTED:
                title = (
                    "Friction ± 95 % band, last usable, and share usable of the samples with a torque"
                )
                print_table(title, *printed_rows(rows), overflow="fold")
            for line in friction_lines_by_ground(rows):
                print_line(line)
            print_line(
                f"estimated {len(rows) - faults} of {len(rows)} recordings; {friction_range(rows)}"
            )
            unprinted = bool(self.summary) and len(rows) > MAX_PRINTED
            if counts := remark_counts(rows, named=unprinted):
                print_line(counts)
            if unprinted and len(causes) <= MAX_NAMED:
                for line in causes:
                    print_line(line)
        if finals:
            print_line(f"wrote {' and '.join(map(str, finals))}")
        show_json(rows)
        if faults:
            failed = (row for row in rows if row["fault"])
            which = f"; the first is {next(unknown_friction_lines(failed))}"
            if faults > 1 and len(causes) <= MAX_NAMED:
                names = (str(row["recording"]) for row in rows if row["fault"])
                which = f": {', '.join(names)}; the causes are above"
            raise InvalidInputError(f"{faults} of {len(rows)} recordings could not be estimated{which}")
