"""What commands share: locate the inputs, read them, refuse to write over them, stage tables."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import TypeVar

import numpy as np

from brushgrip.inputs.recording_files import (
    locate_recording,
    parse_ground_by_recording,
    refuse_overwriting,
    shares_samples,
    unique_labels,
)
from brushgrip.inputs.user_effects import effect_files, import_user_effects
from brushgrip.outputs.atomic import staged_files, write_utf8
from brushgrip.outputs.provenance import (
    Provenance,
    labels_model_was_found_from,
    provenance_file,
    provenance_of,
    warn_of_another_rig,
)
from brushgrip.wording.formatting import json_text
from identification import (
    Decay,
    FoundModel,
    Recording,
    SignalMap,
    read_decay,
    read_model,
    read_recording,
    read_rig,
    read_signals,
    read_vehicle,
)
from identification.reading.checked_file_reading import read_bytes
from identification.reading.map_for_recording import with_steering_ratio
from identification.reading.readers import companion_files
from identification.reading.signal_map import parse_maps
from identification.reading.trimming_and_thinning import trimmed
from symbolic import Effect, InvalidInputError
from symbolic.tables.toml_and_json_parsing import MAX_TABLES_SIZE, parse_toml
from symbolic.tables.vehicle_from_tables import VEHICLE

Content = TypeVar("Content")
WHOLE = (None, None)
"""Span of a whole recording."""


@dataclass(frozen=True, kw_only=True)
class Inputs:
    """What a command reads, located: recordings and models are read when they are asked for."""

    paths: Mapping[str, Path]  # Of the recordings in order, by a label of their own.
    files: tuple[Path, ...]  # These, sources of the user's effects, and what is read along; each once.
    rig: Path | None
    model: Path | None
    signals: SignalMap
    vehicle: Path | None = None
    effects: tuple[Effect, ...]
    grounds: Mapping[str, str]  # What `--ground` says, by label.
    span: tuple[float | None, float | None] = WHOLE  # That is used of each recording [s].
    steering_ratio: float | None = None  # Angle recorded of the steering wheel over the wheel's.

    def recordings(
        self, *, torque_required: bool = True, causal: bool = False, inclination: float | None = None
    ) -> list[Recording]:
        """The recordings in order, each on its ground; `causal` fills gaps from the past alone.

        An inclination [rad] goes before that of the vehicle.
        """
        nominal = None if self.rig is None else read_rig(self.rig)
        vehicle = None if self.vehicle is None else read_vehicle(self.vehicle)
        if vehicle is not None and inclination is not None:
            vehicle = replace(vehicle, inclination=inclination)
        read_one = partial(
            read_recording, torque_required=torque_required, causal=causal, signals=self.signals
        )
        read = [read_one(path, nominal, vehicle=vehicle) for path in self.paths.values()]
        if torque_required:
            where = ", either for training or held out"
            _require_distinct(self.paths.values(), read, shares_samples, where)
        return [
            trimmed(
                replace(recording, name=label, ground=self.grounds.get(label, recording.ground)),
                *self.span,
            )
            for label, recording in zip(self.paths, read, strict=True)
        ]

    def decays(self) -> list[Decay]:
        """The free vibrations in order."""
        nominal = None if self.rig is None else read_rig(self.rig)
        read = [read_decay(path, nominal, signals=self.signals) for path in self.paths.values()]
        _require_distinct(self.paths.values(), read, lambda a, b: np.array_equal(a.psi, b.psi))
        return [replace(decay, name=name) for name, decay in zip(self.paths, read, strict=True)]

    def read_found_model(self) -> FoundModel | None:
        """The model that a diagnosis found; None for the declared one.

        It keeps the values of recordings at hand alone, and of these only where the file is the same:
        another of the same name is as good as any other recording to come.
        """
        if self.model is None:
            return None
        found = read_model(self.model, effects=self.effects)
        named = {label: path for label, path in self.paths.items() if label in found.own}
        same = labels_model_was_found_from(self.model, named)
        own, rig = ({n: v for n, v in of.items() if n in same} for of in (found.own, found.rig))
        return replace(found, own=own, rig=rig)

    def one_by_one(self) -> Iterator[tuple[str, "Inputs"]]:
        """Label and inputs of each recording; of several with absolute paths, for processes."""
        if len(self.paths) == 1:
            yield from dict.fromkeys(self.paths, self).items()
            return
        named = {n: getattr(self, n) for n in ("rig", "model", "vehicle")}
        absolute = {name: path and path.absolute() for name, path in named.items()}
        for label, path in self.paths.items():
            own = path.absolute()
            grounds = {label: self.grounds[label]} if label in self.grounds else {}
            yield label, replace(self, paths={label: own}, files=(own,), grounds=grounds, **absolute)

    def part(self, of: slice) -> "Inputs":
        """Inputs of the recordings in a slice, labelled anew so that labels differ within it."""
        paths = list(self.paths.values())[of]
        return replace(self, paths=dict(zip(unique_labels(paths), paths, strict=True)))

    def refuse_overwriting(self, outputs: Sequence[Path], others: Sequence[Path] = ()) -> None:
        """Refuses outputs that would overwrite what is read; `others` are read as well."""
        named = [path for path in (self.rig, self.model, self.vehicle) if path is not None]
        refuse_overwriting(outputs, [*self.files, *named, *others])

    def provenance(self, **settings: object) -> Provenance:
        """The provenance of what is written now; settings are options that change the result."""
        if self.span != WHOLE:
            settings["span"] = list(self.span)
        if self.steering_ratio is not None:
            settings["steering_ratio"] = self.steering_ratio
        rig = self.vehicle if self.rig is None else self.rig
        return provenance_of(self.files, rig, self.model, self.signals.to_dict(), **settings)


def gather_inputs(
    recordings: Sequence[str] = (),
    *,
    rig: Path | None = None,
    channel_map: Sequence[str] | None = None,
    steering_ratio: float | None = None,
    span: tuple[float | None, float | None] = WHOLE,
    model: Path | None = None,
    effects: Sequence[str] | None = None,
    ground: Sequence[str] | None = None,
    vehicle: Path | None = None,
) -> Inputs:
    """The inputs that options of these names give; modules of effects are imported."""
    if rig is not None and vehicle is not None:
        raise InvalidInputError("--rig and --vehicle are both given; name the one that was recorded")
    if steering_ratio is not None and vehicle is not None:
        raise InvalidInputError("--steering-ratio: that of a car is steering_ratio in its vehicle file")
    if vehicle is not None and model is not None:
        raise InvalidInputError(
            "a car takes no model.json: its model is the vehicle file; leave --model out, and declare"
            " what was found there (report.html names the key)"
        )
    warn_of_another_rig(rig, model)
    own = import_user_effects(effects)
    located = [locate_recording(name, of_car=vehicle is not None) for name in recordings]
    by_file: dict[tuple[int, int], list[Path]] = {}
    for path in located:
        by_file.setdefault(((there := path.stat()).st_dev, there.st_ino), []).append(path)
    for same in by_file.values():
        _require_distinct(same, same, lambda *_: True)
    signals = SignalMap() if (described := rig or vehicle) is None else read_signals(described)
    if channel_map is not None:
        signals = signals.updated(parse_maps(channel_map))
    if steering_ratio is not None:
        signals = with_steering_ratio(signals, steering_ratio)
    labels = unique_labels(located)
    grounds = parse_ground_by_recording(labels, ground)
    # Results tell values of grounds and of recordings by name.
    apart = {n: f"{n}_recording" for n in grounds.values() if f"{n}_recording" not in labels}
    paths = {apart.get(n, n): path for n, path in zip(labels, located, strict=True)}
    files = [*located, *effect_files(effects, own), *companion_files(located, signals)]
    return Inputs(
        paths=paths,
        files=tuple(dict.fromkeys(files)),
        rig=rig,
        model=model,
        signals=signals,
        vehicle=vehicle,
        effects=own,
        grounds={apart.get(n, n): named for n, named in grounds.items()},
        span=span,
        steering_ratio=steering_ratio,
    )


def _require_distinct(
    paths: Iterable[Path],
    read: Sequence[Content],
    same: Callable[[Content, Content], bool],
    where: str = "",
) -> None:
    for (one, first), (other, second) in combinations(zip(paths, read, strict=True), 2):
        if same(first, second):
            raise InvalidInputError(
                f"{other}: is the same recording as {one}; each is allowed once{where}"
            )


@contextmanager
def staged_files_with_provenance(
    inputs: Inputs,
    final_paths: Sequence[Path],
    settings: Mapping[str, object],
    other_paths: Sequence[Path] = (),
    out: Path | None = None,
) -> Iterator[list[Path]]:
    """Paths to write to, in the order of the final files, with their provenance in a file beside `out`.

    That is the first of all if left out; `other_paths` are written elsewhere.
    """
    written = [*([] if out is None else [out]), *final_paths, *other_paths]
    if not written:
        yield []
        return
    told = provenance_file(written[0])
    inputs.refuse_overwriting([*other_paths, *final_paths, told])
    made = json_text(inputs.provenance(**settings))
    with staged_files([*final_paths, told]) as (*stages, origin):
        write_utf8(origin, made)
        yield stages


def require_brakes_known(file: Path | None, recordings: Sequence[Recording]) -> None:
    """Refuse recordings of which nothing says whether the brakes held the wheels."""
    section = parse_toml(read_bytes(file, MAX_TABLES_SIZE))[VEHICLE] if file else {}
    for one in recordings:
        recorded = one.standstills is not None and one.standstills.brakes_recorded
        if not (recorded or (isinstance(section, dict) and "brakes" in section)):
            raise InvalidInputError(
                f"{one.name}: whether the brakes held the wheels is not known: map brake, or declare"
                f" brakes = true or false in {file}"
            )
