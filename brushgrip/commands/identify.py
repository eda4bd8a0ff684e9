"""`brushgrip identify`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from brushgrip.commands.options import ChannelMap, OutJson, RigFile, file_option, option


@dataclass(frozen=True, kw_only=True)
class IdentifyRequest:
    """Identify k and b_t from free vibrations, with standard deviations.

    A recording needs t and psi alone; lines such as '# a = 0.045' before the header override the rig
    for that recording. a, e and J_A are required. A picture of the fit goes beside ID.json.
    """

    free_decay: Annotated[
        list[str],
        option(
            "--free-decay",
            metavar="REC...",
            help="Recordings of the wheel swinging freely after an impact: one or more after the flag.",
        ),
    ]
    out: OutJson = None
    rig: RigFile = None
    channel_map: ChannelMap = None
    write_rig: Annotated[
        Path | None,
        file_option("--write-rig", "R", "Rig file to write: that of --rig with the k and b_t found."),
    ] = None

    def run(self) -> None:
        """Write k and b_t from free vibrations, and a picture of the fit."""
        import identification
        from brushgrip.inputs.pipeline import locate_inputs, staged_files, write_text
        from brushgrip.outputs.atomic import is_same_file
        from brushgrip.outputs.console import say, show
        from brushgrip.outputs.identified_rig import declared_rig, identified_rig_text
        from brushgrip.outputs.provenance import KEY
        from brushgrip.pictures import draw_free_decay
        from brushgrip.report.printed import print_free_decay
        from brushgrip.wording.formatting import free_decay_document, json_text, listed
        from identification.thesis import estimate_by_decrement
        from symbolic import BrushgripError, InvalidInputError

        written = self.write_rig
        results = [self.out, self.out.with_suffix(".png")] if self.out else []
        if len(set(results)) == 1:
            raise InvalidInputError(
                f"{self.out}: the result needs a name such as .json; .png is its picture"
            )
        if written and any(is_same_file(written, other) for other in results):
            raise InvalidInputError(f"{written}: --write-rig and --out must name different files")
        finals = [*results, *([written] if written else [])]
        inputs = locate_inputs(self.free_decay, rig=self.rig, channel_map=self.channel_map)
        inputs.keep(finals)
        decays = inputs.decays()
        declared = declared_rig(decays, self.rig) if written else None
        with staged_files(finals) as stages:
            result = identification.identify_free_decay(decays)
            if not result.converged:
                raise BrushgripError(f"k and b_t were {result.status}: {result.remedy}")
            decrement = estimate_by_decrement(decays)
            document = free_decay_document(result, decrement) | {KEY: inputs.provenance()}
            if results:
                write_text(stages[0], json_text(document))
                draw_free_decay(stages[1], result, decrement)
            if declared:
                write_text(stages[-1], identified_rig_text(*declared, self.rig, result))
        print_free_decay(result, decrement)
        if finals:
            say(f"wrote {listed(list(map(str, finals)))}")
        show(document)
