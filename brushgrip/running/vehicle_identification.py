"""`brushgrip identify --vehicle`: what a workshop identifies of a car."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class VehicleIdentification:
    """What was asked of `brushgrip identify` about a car; see there."""

    vehicle: Path
    plates: Sequence[str]
    channel_map: str | None
    out: Path | None
    written: Path | None

    def run(self) -> None:
        """Write what was identified, and the vehicle file with it."""
        from brushgrip.inputs.pipeline import locate_inputs, staged_files, write_text
        from brushgrip.outputs.atomic import is_same_file
        from brushgrip.outputs.console import print_table, print_text, say, show
        from brushgrip.outputs.identified_vehicle import identified_vehicle_text, with_plates
        from brushgrip.outputs.provenance import KEY
        from brushgrip.wording.formatting import json_text, listed, quantity
        from identification import read_vehicle
        from identification.reading.car import read_rack
        from identification.steering.plates import identify_on_plates
        from symbolic import InvalidInputError

        finals = [path for path in (self.out, self.written) if path]
        if self.out and self.written and is_same_file(self.out, self.written):
            raise InvalidInputError(
                f"{self.written}: --write-vehicle and --out must name different files"
            )
        inputs = locate_inputs(self.plates, vehicle=self.vehicle, channel_map=self.channel_map)
        inputs.keep(finals)
        car = read_vehicle(self.vehicle)
        with staged_files(finals) as stages:
            result = identify_on_plates(
                [read_rack(path, car, inputs.signals) for path in inputs.paths.values()], car
            )
            values = {
                name: {"value": one.value, "std": one.std, "unit": one.unit}
                for name, one in result.parameters.items()
            }
            fit = {"samples": result.samples, "rms": result.rms, "note": result.note}
            document = {"plates": {**values, **fit}, KEY: inputs.provenance()}
            if self.out:
                write_text(stages[0], json_text(document))
            if self.written:
                text = identified_vehicle_text(self.vehicle, with_plates(car, result))
                write_text(stages[-1], text)
        rows = [(name, quantity(one)) for name, one in result.parameters.items()]
        print_table("Steering, wheels on plates", ("", "value ± standard deviation"), rows)
        if result.note:
            print_text(f"note: {result.note}")
        if finals:
            say(f"wrote {listed(list(map(str, finals)))}")
        show(document)
