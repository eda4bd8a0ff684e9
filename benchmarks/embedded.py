"""What generated C costs: on this machine in time, on an emulated Cortex-M4F and M7 in instructions.

    python benchmarks/embedded.py [--every]

The code runs along the ordinary steering of `tests/observers/embedded/ordinary_steering.py`: a wheel
that swings to and fro ever less far, a parking manoeuvre, angles at random, whose patch has 7 corners in
the mean and up to 21. It is compiled with -O2, in single precision where nothing else is said; double
precision is software on these processors. Here it is timed, the least of many runs. The emulator counts
instructions, which are no cycles. `at most` is the longest step also of a patch that is full of corners,
while friction is acquired, and of samples that no wheel gives; flash holds what is needed of math.h and
memcpy, stack is what a step touches; mu off by is the largest difference from Python along the wheel
that swings. `measured run` is the model that `diagnose` found in the measured recordings; --every adds
each effect of the library alone. Then the problem of `observers_step.py`, in C and in Python. Needs gcc
or clang; for the targets arm-none-eabi-gcc with newlib, and qemu-system-arm.
"""

import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import observers_step
from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import DOUBLE, SINGLE, Real
from symbolic import EFFECTS as EFFECTS_OF_LIBRARY
from symbolic import Model, parameter_name
from tests.observers.conftest import K
from tests.observers.embedded.cortex.target import M4F, M7, TOOLS, Board, run_on, tools_installed
from tests.observers.embedded.generated_code import (
    EFFECTS,
    MEASURED_RUN,
    GeneratedCode,
    generate_code,
    observer_of,
    python_estimates,
)
from tests.observers.embedded.ordinary_steering import ORDINARY, samples_along, samples_at_the_cap
from tests.observers.factories import DECLARED

ROUNDS = 30
DOUBLES = (
    ("EKF, declared", Ekf, DECLARED),
    ("MHE of 50, declared", Mhe, DECLARED),
    ("EKF, measured run", Ekf, MEASURED_RUN),
)
TIMER = Path(__file__).with_name("embedded_timer.c")


def microseconds(code: GeneratedCode, rows: np.ndarray) -> float:
    """Time of a step here."""
    rows.astype(np.float32).tofile(code.folder / "samples.bin")
    flags = ("-std=c99", "-O2", "-fno-math-errno")
    timer = code.compile(*flags, sources=(str(TIMER), "brushgrip.c"), out="timer")
    command = [str(timer), str(code.folder / "samples.bin"), str(ROUNDS)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def beside_python() -> None:
    """Print what a step takes in C and in Python, and the ratio."""
    sequence = observers_step.samples(observers_step.PROBLEM)
    rows = np.array([(s.psi, s.psi_dot, s.M_z, s.F_N, s.dt) for s in sequence])
    for kind in (Ekf, Mhe):
        observer = observers_step.ours(kind)
        with tempfile.TemporaryDirectory() as folder:
            fast = microseconds(generate_code(observer, SINGLE, Path(folder)), rows)
        slow = observers_step.microseconds(observer, sequence)
        print(
            f"{kind.__name__.upper()} in C {fast:.2f} us a step; Python {slow:.0f}, {slow / fast:.0f} x"
        )


def adversarial(count: int = 300) -> np.ndarray:
    """Samples (n, 5) that no wheel gives: jumps of angle, load and time, any torque, silence."""
    rng = np.random.default_rng(7)
    jumps = rng.choice([1e-5, 1e-3, 0.05, 0.5], count) * rng.standard_normal(count)
    psi, rate = np.cumsum(jumps), rng.standard_normal(count)
    torque = rng.choice([0.0, 3.0, 300.0], count) * rng.standard_normal(count)
    load, step = 400 * rng.lognormal(0, 0.5, count), 10.0 ** rng.uniform(-4, 0, count)
    rows = np.column_stack([psi, rate, torque, load, step])
    rows[20:, :4][rng.random((count - 20, 4)) < 0.05] = np.nan
    return SINGLE.round(rows)


@dataclass(frozen=True, kw_only=True)
class Counted:
    """What a step takes on a board: bytes, and instructions, also at most in ordinary steering."""

    mean: float
    ordinary: int
    most: int
    flash: int
    state: int
    stack: int


def counted(board: Board, code: GeneratedCode) -> Counted:
    """Counts along ordinary steering, steering that fills the patch, and samples that no wheel gives."""
    paths = [samples_along(targets, code.observer) for targets in ORDINARY.values()]
    usual = [run_on(board, code, SINGLE.round(rows)) for rows in paths]
    worst = [
        run_on(board, code, rows)
        for rows in (SINGLE.round(samples_at_the_cap(code.observer)), adversarial())
    ]
    return Counted(
        mean=float(np.average([cost.instructions for cost in usual], weights=[len(r) for r in paths])),
        ordinary=max(cost.most for cost in usual),
        most=max(cost.most for cost in (*usual, *worst)),
        flash=usual[0].flash,
        state=usual[0].state,
        stack=max(cost.stack for cost in (*usual, *worst)),
    )


def models(every: bool) -> dict[str, dict[str, Any]]:
    """Model and values by name; each effect of the library alone, if asked for."""
    named = {"declared": DECLARED, "torsion, rate friction": EFFECTS, "measured run": MEASURED_RUN}
    for name, effect in EFFECTS_OF_LIBRARY.items() if every else ():
        model = Model(effects=(effect,))
        start = {parameter_name(e, p): p.start for e, p in model.parameters if e is not None}
        named[name] = {"model": model, "values": {"k": K, **start}}
    return named


def row(name: str, observer: Any, real: Real = SINGLE) -> str:
    """A row of the table."""
    rows = real.round(samples_along(ORDINARY["decreasing"], observer))
    with tempfile.TemporaryDirectory() as folder:
        code = generate_code(observer, real, Path(folder))
        off = np.abs(code.run(rows) - python_estimates(observer, rows))[:, 0].max()
        cells = [name, f"{microseconds(code, rows):.2f}", f"{off:.0e}"]
        for board in (M4F, M7) if tools_installed() else ():
            cost = counted(board, code)
            cells += [f"{cost.mean:,.0f}", f"{cost.ordinary:,}", f"{cost.most:,}"]
            cells += [f"{cost.flash:,}", f"{cost.state:,}", f"{cost.stack:,}"]
    return "| " + " | ".join(cells) + " |"


def on_aligning_torque(kind: type[Ekf] | type[Mhe], model: dict[str, Any]) -> Ekf | Mhe:
    """An observer of M_z, k a state with effects, as by a model that was found."""
    return observer_of(kind, model, AligningTorque(stiffness=bool(model["model"].effects)))


def table(every: bool) -> None:
    """Print the table: observer, model and torque against what they cost."""
    heads = ["", "us here", "mu off by"]
    for board in (M4F, M7):
        heads += [f"{board.name}: mean", "ordinary, at most", "at most", "flash", "state", "stack"]
    print("| " + " | ".join(heads) + " |\n|" + "---|" * len(heads), flush=True)
    for name, model in models(every).items():
        for kind, title in ((Ekf, "EKF"), (Mhe, "MHE of 50")):
            print(row(f"{title}, {name}", on_aligning_torque(kind, model)), flush=True)
        if any(effect.sensor for effect in model["model"].effects):
            continue
        for kind, title in ((Ekf, "EKF"), (Mhe, "MHE of 50")):
            steering = observer_of(kind, model, SteeringTorque())
            print(row(f"{title}, {name}, steering torque", steering), flush=True)
    for name, kind, model in DOUBLES:
        print(row(f"{name}, double", on_aligning_torque(kind, model), DOUBLE), flush=True)


def main() -> None:
    """Print the table, and the ratios to Python."""
    table("--every" in sys.argv)
    if not tools_installed():
        print(f"no target: {TOOLS}")
    beside_python()


if __name__ == "__main__":
    main()
