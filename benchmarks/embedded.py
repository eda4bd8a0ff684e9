"""What generated C costs: on this machine in time, on an emulated Cortex-M4F and M7 in instructions.

    python benchmarks/embedded.py [--every]

The code runs along the embedded recording train_a, on the steering torque along a simulated wheel,
compiled with -O2, in single precision where nothing else is said; double precision is software on these
processors. Here it is timed, the least of many runs. The emulator counts instructions, which are no
cycles, and `at most` is the longest step also of samples that no wheel gives; flash holds what is needed
of math.h and memcpy, stack is what a step touches; mu off by is the largest difference from Python.
`measured run` is the model that `diagnose` found in the measured recordings; --every adds each effect of
the library alone. Then the problem of `observers_step.py`, in C, in Python and by do-mpc where it is
installed, all in one run. Needs gcc or clang; for the targets arm-none-eabi-gcc with newlib, and
qemu-system-arm; for do-mpc pip install 'brushgrip[benchmarks]'.
"""

import importlib.util
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import observers_step
from benchmarks.timing import seconds
from benchmarks.with_do_mpc import WARM, Running
from identification import read_recording
from observers import AligningTorque, Ekf, Mhe, SteeringTorque
from observers.embedded import DOUBLE, SINGLE
from reference_rig import make_steering_recording
from symbolic import EFFECTS as EFFECTS_OF_LIBRARY
from symbolic import Model, Tyre, parameter_name
from tests.observers.conftest import RIG, K
from tests.observers.embedded.cortex.target import M4F, M7, TOOLS, run_on, tools_installed
from tests.observers.embedded.generated_code import (
    DECLARED,
    EFFECTS,
    MEASURED_RUN,
    GeneratedCode,
    generate_code,
    observer_of,
    python_estimates,
)
from tests.observers.factories import columns_of, samples_of

ROUNDS = 30
RECORDING = Path(__file__).resolve().parents[1] / "examples" / "recordings" / "train_a.csv"
TIMER = Path(__file__).with_name("embedded_timer.c")


def samples() -> np.ndarray:
    """The recording as samples (n, 5)."""
    recording = read_recording(RECORDING, (RIG, Tyre(k=K, mu=1.2)))
    step = np.diff(recording.t, prepend=2 * recording.t[0] - recording.t[1])
    nothing = np.full(recording.t.size, np.nan)
    return SINGLE.round(np.column_stack([recording.psi, nothing, recording.M_z, recording.F_N, step]))


def microseconds(code: GeneratedCode, rows: np.ndarray) -> float:
    """Time of a step here."""
    rows.astype(np.float32).tofile(code.folder / "samples.bin")
    flags = ("-std=c99", "-O2", "-fno-math-errno")
    timer = code.compile(*flags, sources=(str(TIMER), "brushgrip.c"), out="timer")
    command = [str(timer), str(code.folder / "samples.bin"), str(ROUNDS)]
    return float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def beside_python() -> None:
    """Print what a step takes in C and in Python, and by do-mpc, and the ratios."""
    sequence = observers_step.samples(observers_step.PROBLEM)
    rows = np.array([(s.psi, s.psi_dot, s.M_z, s.F_N, s.dt) for s in sequence])
    for kind in (Ekf, Mhe):
        observer = observers_step.ours(kind)
        with tempfile.TemporaryDirectory() as folder:
            fast = microseconds(generate_code(observer, SINGLE, Path(folder)), rows)
        observers_step.steps(observer, sequence[:100])
        rounds = [seconds(lambda one=observer: observers_step.steps(one, sequence)) for _ in range(5)]
        others = {"Python": 1e6 * float(np.median(rounds)) / len(sequence)}
        if kind is Mhe and importlib.util.find_spec("do_mpc"):
            rival = Running(observers_step.PROBLEM, observers_step.WINDOW, WARM)
            rival.step()
            took = [seconds(rival.step) for _ in range(observers_step.STEPS)]
            others["do-mpc, warm start"] = 1e6 * float(np.median(took))
        print(f"{kind.__name__.upper()} in C {fast:.2f} us a step", end="")
        print("".join(f"; {name} {slow:.0f} us, {slow / fast:.0f} x" for name, slow in others.items()))


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


def steered() -> np.ndarray:
    """A steered wheel as samples (n, 5) with the steering torque."""
    recording = make_steering_recording(5, duration=7.0, rate=100.0)
    sequence = samples_of(columns_of(recording))
    return SINGLE.round(np.array([(s.psi, np.nan, s.M, s.F_N, s.dt) for s in sequence]))


def models(every: bool) -> dict[str, dict[str, Any]]:
    """Model and values by name; each effect of the library alone, if asked for."""
    named = {"declared": DECLARED, "torsion, rate friction": EFFECTS, "measured run": MEASURED_RUN}
    for name, effect in EFFECTS_OF_LIBRARY.items() if every else ():
        model = Model(effects=(effect,))
        start = {parameter_name(e, p): p.start for e, p in model.parameters if e is not None}
        named[name] = {"model": model, "values": {"k": K, **start}}
    return named


def row(name: str, observer: Any, rows: np.ndarray) -> str:
    """A row of the table."""
    with tempfile.TemporaryDirectory() as folder:
        code = generate_code(observer, SINGLE, Path(folder))
        expected = python_estimates(observer, rows)
        off = np.abs(code.run(rows) - expected)[:, 0].max()
        cells = [name, f"{microseconds(code, rows):.2f}", f"{off:.0e}"]
        for board in (M4F, M7) if tools_installed() else ():
            usual, worst = (run_on(board, code, part) for part in (rows, adversarial()))
            most = max(usual.most, worst.most)
            cells += [f"{usual.instructions:.0f}", f"{most}", f"{usual.flash}", f"{usual.state}"]
            cells += [f"{max(usual.stack, worst.stack)}"]
    return "| " + " | ".join(cells) + " |"


def table(every: bool) -> None:
    """Print the table: observer, model and torque against what they cost."""
    heads = ["", "us here", "mu off by"]
    for board in (M4F, M7):
        heads += [f"{board.name}: instructions", "at most", "flash", "state", "stack"]
    print("| " + " | ".join(heads) + " |\n|" + "---|" * len(heads), flush=True)
    aligning = samples()[:700]
    for name, model in models(every).items():
        print(row(f"EKF, {name}", observer_of(Ekf, model, AligningTorque()), aligning), flush=True)
        print(row(f"MHE of 50, {name}", observer_of(Mhe, model, AligningTorque()), aligning), flush=True)
        if any(effect.sensor for effect in model["model"].effects):
            continue
        for kind, title in ((Ekf, "EKF"), (Mhe, "MHE of 50")):
            steering = observer_of(kind, model, SteeringTorque())
            print(row(f"{title}, {name}, steering torque", steering, steered()), flush=True)


def main() -> None:
    """Print the table, what double precision costs, and the ratios to Python and do-mpc."""
    table("--every" in sys.argv)
    rows = samples()
    for name, kind in (("EKF, declared, double", Ekf), ("MHE of 50, the same", Mhe)):
        with tempfile.TemporaryDirectory() as folder:
            code = generate_code(observer_of(kind, DECLARED, AligningTorque()), DOUBLE, Path(folder))
            print(f"{name:22}here {microseconds(code, rows):8.2f} us a step")
            for board in (M4F, M7) if tools_installed() else ():
                cost = run_on(board, code, rows[:700])
                print(
                    f"{'':22}{board.name} {cost.instructions:9.0f} instructions, at most {cost.most:7};"
                    f" flash {cost.flash:6}, state {cost.state:6}, stack {cost.stack:5} bytes"
                )
    if not tools_installed():
        print(f"no target: {TOOLS}")
    beside_python()


if __name__ == "__main__":
    main()
