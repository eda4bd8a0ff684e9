"""`brushgrip simulate`."""

from dataclasses import dataclass

from brushgrip.commands.options import ModelRunRequest, OutFile, option


@dataclass(frozen=True, kw_only=True)
class SimulateRequest(ModelRunRequest):
    """Simulate the aligning torque for the angle and the load of recordings: t,M_z.

    No M_z is needed. mu, a and e are those of the model file where it was fitted to this very file, else
    those declared; --mu goes before both.
    Several recordings go to OUT_<recording>.csv.
    """

    out: OutFile
    mu: float | None = option(
        "--mu",
        "MU",
        "Friction of the model's own law, in place of what model file, recording and rig say; which"
        " mu_eff that is, is printed.",
    )

    def run(self) -> None:
        """Write the torque that the model predicts for recordings."""
        from brushgrip.estimation.model_torque_for_recording import (
            simulated_torque,
            simulation_model_and_values,
            values_in_words,
        )
        from brushgrip.inputs.command_inputs import staged_files_with_provenance
        from brushgrip.outputs.atomic import table_path, write_utf8
        from brushgrip.outputs.console import print_line, show_json
        from brushgrip.report.print_diagnosis_and_fits import print_ground_values
        from brushgrip.wording.formatting import csv_text
        from symbolic import InvalidInputError

        if self.mu is not None and not 0 < self.mu < float("inf"):
            raise InvalidInputError(f"--mu must be finite and greater than 0, got {self.mu:g}")
        inputs = self.model_inputs()
        finals = [table_path(self.out, name, len(inputs.paths)) for name in inputs.paths]
        settings = {"mu": self.mu, "ground": list(self.ground or ())}
        with staged_files_with_provenance(inputs, finals, settings, out=self.out) as stages:
            recordings, found = inputs.recordings(torque_required=False), inputs.read_found_model()
            models = [simulation_model_and_values(recording, found, self.mu) for recording in recordings]
            for recording, (model, values), stage in zip(recordings, models, stages, strict=True):
                torque = simulated_torque(recording, model, values, found)
                write_utf8(stage, csv_text({"t": recording.t, "M_z": torque}))
        for recording, (_, values) in zip(recordings, models, strict=True):
            print_line(values_in_words(recording, values, found, self.mu))
        print_ground_values({recording.name: recording.ground for recording in recordings}, found)
        for final in finals:
            print_line(f"wrote {final}")
        show_json({"wrote": list(map(str, finals))})
