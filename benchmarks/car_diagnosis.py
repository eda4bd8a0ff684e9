"""What `diagnose --vehicle` finds in independent cars of which the vehicle file leaves something out.

    python benchmarks/car_diagnosis.py --cars 5 --seed 52000

Each car is steered by three drives on one ground, mu = 0.6 to 1.0, brakes on, every declared value off
within its tolerance; the drives are left out in turn. Planted, one at a time: play of 0.5 deg in the tie
rods, gear friction of twice what is declared, a return torque of twice the true one (inclination times
the root of 2), and a column of 150 N m/rad above the torsion bar of a car without assistance,
whose handwheel is what is measured. Beside them the same cars with nothing planted. An effect is named
where it is found or listed as indistinguishable from one that is; clearly where its grade is strong or
ambiguous. Half a minute a diagnosis, ten seconds a drive.
"""

import argparse
import tempfile
from dataclasses import dataclass, replace
from math import radians
from pathlib import Path

import numpy as np

from benchmarks.car_files import vehicle_toml, write_recording
from brushgrip.wording.diagnosis_in_words import headline
from identification import diagnose, read_recording, read_vehicle
from reference_rig import Car, FleetCar, draw_car, handwheel_path, record_car, simulate_car
from symbolic.vehicle.candidate_effects import CAR_EFFECTS

PLANTED = {
    "nothing": "",
    "play": "play_of_joints",
    "gear": "gear_friction",
    "jacking": "jacking",
    "hand_nothing": "",
    "hand_column": "compliance_of_steering",
}
"""What is planted, `hand` from the handwheel of a car without assistance -> the effect to name."""
PLAY, COLUMN, TWICE = radians(0.5), 150.0, 2.0
DRIVES = ("one", "two", "three")
CLEAR = ("strong", "ambiguous")


@dataclass(frozen=True, kw_only=True)
class CarOutcome:
    """What was named of one car, and clearly so; what was clearly named beside it."""

    named: bool
    clearly: bool
    too_many: int
    said: str


def planted(kind: str, drawn: FleetCar) -> Car:
    """The car with what its owner does not know of."""
    car, declared = drawn.car, drawn.declared
    if kind == "play":
        return replace(car, rod=replace(car.rod, play=car.rod.play + PLAY * declared["lever"]))
    if kind == "gear":
        return replace(car, friction=replace(car.friction, level=TWICE * declared["gear_friction"]))
    if kind == "jacking":
        leaning = TWICE**0.5 * car.kingpin.inclination
        return replace(car, kingpin=replace(car.kingpin, inclination=leaning))
    return replace(car, column=COLUMN) if kind == "hand_column" else car


def write_drives(folder: Path, kind: str, seed: int) -> None:
    """The vehicle file and the recordings of a car."""
    by_hand = kind.startswith("hand")
    drawn = draw_car(seed, assisted=not by_hand, brake=True)
    mu = float(np.random.default_rng([seed, 31]).uniform(0.6, 1.0))
    drawn = replace(drawn, car=replace(drawn.car, mu=(mu, mu)))
    car = planted(kind, drawn)
    folder.mkdir()
    (folder / "car.toml").write_text(vehicle_toml(drawn.declared, brake=True), encoding="utf-8")
    for number, name in enumerate(DRIVES):
        own = 1000 * seed + number
        path = handwheel_path(own, car.lock / car.pinion_radius, by_hand=not drawn.by_rack)
        path = path * car.pinion_radius if drawn.by_rack else path
        motion = simulate_car(car, path, by_rack=drawn.by_rack)
        seen = record_car(own, car, motion, bus=drawn.bus, name=name)
        write_recording(folder / f"{name}.csv", seen, "handwheel" if by_hand else "rack")


def judge(folder: Path, kind: str) -> CarOutcome:
    """Diagnose the recordings of a car."""
    vehicle = read_vehicle(folder / "car.toml")
    recordings = [read_recording(folder / f"{name}.csv", vehicle=vehicle) for name in DRIVES]
    diagnosis = diagnose(recordings, candidates=CAR_EFFECTS.values(), jobs=1)
    wanted = PLANTED[kind]
    own = [e for e in diagnosis.effects if wanted in (e.name, *e.indistinguishable_from)]
    clear = [e for e in diagnosis.effects if e.grade in CLEAR]
    return CarOutcome(
        named=bool(own),
        clearly=any(e.grade in CLEAR for e in own),
        too_many=sum(e not in own for e in clear),
        said=headline(diagnosis),
    )


def main() -> None:
    """Print a line for each car, and the counts."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cars", type=int, default=5)
    parser.add_argument("--seed", type=int, default=41_000, help="first of the cars' seeds")
    parser.add_argument("--kinds", nargs="+", choices=list(PLANTED), default=list(PLANTED))
    given = parser.parse_args()
    outcomes: dict[str, list[CarOutcome]] = {kind: [] for kind in given.kinds}
    with tempfile.TemporaryDirectory() as name:
        for seed in range(given.seed, given.seed + given.cars):
            for kind in given.kinds:
                folder = Path(name) / f"{kind}_{seed}"
                write_drives(folder, kind, seed)
                outcomes[kind].append(judge(folder, kind))
                print(f"{seed} {kind}: {outcomes[kind][-1].said}", flush=True)
    print(f"\n{'planted':14}{'cars':>6}{'named':>7}{'clearly':>9}{'too many':>10}")
    for kind, found in outcomes.items():
        of = [sum(getattr(one, which) for one in found) for which in ("named", "clearly", "too_many")]
        shown = ["-", "-", of[2]] if not PLANTED[kind] else of
        print(f"{kind:14}{len(found):6}{shown[0]:>7}{shown[1]:>9}{shown[2]:>10}")


if __name__ == "__main__":
    main()
