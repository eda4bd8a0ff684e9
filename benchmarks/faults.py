"""What does a faulty input do to an estimate? Faults by name, on the rig, with default tuning.

    python benchmarks/faults.py --seeds 5
    python benchmarks/faults.py --only torque --k 0.05
    python benchmarks/faults.py --torque M

Each fault at mu = 0.05, 0.3, 0.8 and 1.5, for 5 s and 14 s, on an otherwise exact rig, and once more
with k, half-length and load drawn from the tolerances that count where none is declared. With
--torque M the steering torque of a wheel with inertia and damping is measured; their faults come beside.
Counted are runs in which more than 1 % of the samples are usable and beyond three deviations. A load
that is off by a factor is friction off by that factor: below what any ground holds, nothing tells them
apart. With --k, k is declared with this tolerance, and drawn within it. With --found the rig has one of
seven effects, 5 % of the torque's range, and the observer the model with it; without the faults of a
patch that was twisted. With --range the rig declares that its torque sensor is straight up to this share
of the greatest torque. The last but one column counts the wrong runs, exact / drawn, in brackets all,
where `estimate` says that the sensor of the torque seems to end; the last has the travel of both kinds
until the run is suspect.
"""

import argparse
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from benchmarks.bands_on_rig import true_friction
from benchmarks.faulty_inputs import (
    BRISTLES,
    FAULTS,
    INVISIBLE,
    LOAD,
    OF_THE_PATCH,
    OF_THE_WHEEL,
    TOLERATED,
    Inputs,
)
from benchmarks.ice import EFFECTS, KINDS, OFF, RIG, STEERING_RATE, TORQUES, K
from identification.reading.undeclared_sensor_limit import detect_saturation
from observers import AligningTorque, MeasurementModel, Status, run
from reference_rig import (
    RigRecording,
    RigTyre,
    SteeringRecording,
    make_recording,
    make_steering_recording,
    plant_effect,
)
from symbolic import Model, Tolerances, effects_named

FIRST_SEED = 200_000
FRICTIONS, DURATIONS = (0.05, 0.3, 0.8, 1.5), (5.0, 14.0)


@dataclass(frozen=True, kw_only=True)
class FaultCase:
    """What is run: observer, torque, tolerance of k [1], whether the model with an effect is found.

    `range` is that of the torque sensor over the greatest torque [1]; None where it is not declared.
    """

    observer: str = "ekf"
    torque: str = "M_z"
    k: float = OFF["k"]
    found: bool = False
    range: float | None = None

    @property
    def sensing(self) -> MeasurementModel:
        """What is measured, with k as a state by a model that was found."""
        return AligningTorque(stiffness=True) if self.found else TORQUES[self.torque]


@dataclass(frozen=True, kw_only=True)
class RunBeforeFault:
    """A recording before its fault: time [s] and the true mu_eff [1] have the shape (n,)."""

    inputs: Inputs
    t: Any
    truth: Any
    effects: tuple[str, ...]
    values: Mapping[str, float]


def run_before_fault(task: tuple[FaultCase, float, float, int, bool]) -> RunBeforeFault:
    """A recording on the rig, with one of the effects if the model is to be found."""
    case, mu, duration, seed, is_drawn = task
    off = np.random.default_rng([seed, 4]).uniform(-1, 1, 3) * is_drawn
    tyre = RigTyre(a=RIG.a + OFF["a"] * off[0], e=RIG.e, k=K * (1 + case.k * off[1]), mu=mu)
    effects, values, truth = (), {}, mu
    made: RigRecording | SteeringRecording
    if case.torque == "M":
        made = make_steering_recording(seed, tyre=tyre, load=LOAD, duration=duration, rate=STEERING_RATE)
        of_torque = {"torque": made.M, "ground": made.M_z_true, "sign": -1, "period": 1 / STEERING_RATE}
        of_torque |= {"angle": made.psi_true, "rate": made.psi_dot_true}
    else:
        if case.found:
            effects = (EFFECTS[seed % len(EFFECTS)],)
            made = plant_effect(effects[0], seed, tyre=tyre, duration=duration, share=0.05)
            found = made.effects[effects[0]]
            values, truth = {f"{effects[0]}.{n}": v for n, v in found.items()}, true_friction(made)
        else:
            made = make_recording(seed, **vars(tyre), load=LOAD, duration=duration, bristles=BRISTLES)
        of_torque = {"torque": made.M_z, "ground": made.M_z, "sign": 1, "period": (period := 0.01)}
        of_torque |= {"angle": made.psi, "rate": np.gradient(made.psi, period)}
    inputs = {"psi": made.psi, "F_N": made.F_N * (1 + OFF["load"] * off[2]), "tyre": tyre, **of_torque}
    inputs |= {"a": RIG.a, "k": K, "J_A": RIG.J_A, "b_t": RIG.b_t}
    return RunBeforeFault(inputs=inputs, t=made.t, truth=truth, effects=effects, values=values)


def outcome(task: tuple[FaultCase, str, int, RunBeforeFault]) -> tuple[bool, float, int, bool, float]:
    """Whether a run is usable and wrong, its share of usable samples, its flags, whether it is told.

    Last the travel until it is suspect [rad].
    """
    case, name, seed, one = task
    inputs = FAULTS[name](one.inputs, np.random.default_rng([seed, 3]))
    rig = replace(
        RIG, **{n: inputs[n] for n in ("a", "J_A", "b_t")}, tolerances=Tolerances(k=case.k * inputs["k"])
    )
    if case.range is not None:
        rig = replace(rig, range=case.range * float(np.abs(one.inputs["torque"]).max()))
    observer = KINDS[case.observer](
        model=Model(effects=effects_named(one.effects)), values={"k": inputs["k"], **one.values},
        rig=rig, measurement_model=case.sensing,
    )  # fmt: skip
    torque = {case.torque: inputs["torque"]}
    estimates = run(observer, one.t, inputs["psi"], inputs["F_N"], **torque)
    wrong = estimates.usable & (np.abs(estimates.mu_eff - one.truth) > 3 * estimates.mu_eff_std)
    flags = 0
    for flag in Status:
        flags |= int(flag) * bool(np.mean(estimates.status & flag != 0) > 0.3)
    told = detect_saturation(inputs["torque"], inputs["psi"], inputs["F_N"]) is not None
    suspect = estimates.status & Status.SUSPECT != 0
    travel = np.cumsum(np.abs(np.diff(inputs["psi"], prepend=inputs["psi"][0])))
    named = float(travel[np.argmax(suspect)]) if suspect.any() else np.inf
    return bool(np.mean(wrong) > 0.01), float(np.mean(estimates.usable)), flags, told, named


def faults_of(case: FaultCase, only: str) -> list[str]:
    """Names of the faults that a case has, with this in them."""
    without = (OF_THE_PATCH if case.found else set()) | (set() if case.torque == "M" else OF_THE_WHEEL)
    return [name for name in FAULTS if only in name and name not in without]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--seed", type=int, default=FIRST_SEED, help="the first one")
    parser.add_argument("--observer", choices=list(KINDS), default="ekf")
    parser.add_argument("--torque", choices=list(TORQUES), default="M_z")
    parser.add_argument("--only", default="", help="faults whose name has this in it")
    parser.add_argument("--k", type=float, default=OFF["k"], help="tolerance of k, as a share of it")
    parser.add_argument("--found", action="store_true", help="the rig has an effect, and the model too")
    parser.add_argument("--range", type=float, help="of the torque sensor, over the greatest torque")
    options = parser.parse_args()
    if options.torque == "M" and options.found:
        parser.error("--found goes with M_z")
    case = FaultCase(
        observer=options.observer, torque=options.torque, k=options.k, found=options.found,
        range=options.range,
    )  # fmt: skip
    runs = list(product(FRICTIONS, DURATIONS, range(options.seed, options.seed + options.seeds)))
    print(
        "| fault | usable and wrong, else exact | usable | the same, tolerances drawn | usable |"
        " flags in most runs | | wrong and told (told) | suspect from [rad], half, 9 of 10 |\n"
        "|---|---:|---:|---:|---:|---|---|---|---|"
    )
    with ProcessPoolExecutor() as pool:
        recordings = []
        for is_drawn in (False, True):
            tasks = [(case, *one, is_drawn) for one in runs]
            made = pool.map(run_before_fault, tasks, chunksize=4)
            recordings.append(list(zip((one[-1] for one in runs), made, strict=True)))
        for name in faults_of(case, options.only):
            exact, drawn = (
                list(pool.map(outcome, [(case, name, *one) for one in of], chunksize=4))
                for of in recordings
            )
            often = [f.name for f in Status if f and np.mean([(o[2] & f) != 0 for o in exact]) > 0.5]
            note = "within tolerance" if name in TOLERATED else "invisible" if name in INVISIBLE else ""
            counts = (
                f"{sum(o[0] for o in of)} of {len(of)} | {100 * np.mean([o[1] for o in of]):.0f} %"
                for of in (exact, drawn)
            )
            told = " / ".join(
                f"{sum(o[0] and o[3] for o in of)} ({sum(o[3] for o in of)})" for of in (exact, drawn)
            )
            travels = [o[4] for of in (exact, drawn) for o in of]
            named = ", ".join(
                f"{turn:.3f}" for turn in np.quantile(travels, (0.5, 0.9), method="higher")
            )
            flags = ", ".join(map(str, often))
            print(f"| {name} | {' | '.join(counts)} | {flags} | {note} | {told} | {named} |", flush=True)


if __name__ == "__main__":
    main()
