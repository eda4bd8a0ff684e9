"""What generated C costs: on this machine in time, on an emulated Cortex-M4F and M7 in instructions.

    python benchmarks/embedded.py

The code runs along the embedded recording train_a, compiled with -O2, in single precision where nothing
else is said; double precision is software on these processors. Here it is timed, the least of many runs.
The emulator counts instructions, which are no cycles; flash holds what is needed of math.h and memcpy,
stack is what a step touches. `effects` is a model with carcass torsion and rate friction, which stays on
casadi's own vectors. Then the problem of `observers_step.py`, in C, in Python and by do-mpc where it is
installed, all in one run. Needs gcc or clang; for the targets arm-none-eabi-gcc with newlib, and
qemu-system-arm; for do-mpc pip install 'brushgrip[benchmarks]'.
"""

import importlib.util
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks import observers_step
from benchmarks.timing import seconds
from benchmarks.with_do_mpc import WARM, Running
from identification import read_recording
from observers import AligningTorque, Ekf, Mhe
from observers.embedded import DOUBLE, SINGLE
from symbolic import Tyre
from tests.observers.conftest import RIG, K
from tests.observers.embedded.cortex.target import M4F, M7, TOOLS, run_on, tools_installed
from tests.observers.embedded.generated_code import (
    DECLARED,
    EFFECTS,
    GeneratedCode,
    generate_code,
    observer_of,
)

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


def main() -> None:
    """Print a line for every observer and model, and the ratios."""
    rows = samples()
    for name, kind, model, real in (
        ("EKF, declared", Ekf, DECLARED, SINGLE),
        ("MHE of 50, declared", Mhe, DECLARED, SINGLE),
        ("EKF, effects", Ekf, EFFECTS, SINGLE),
        ("MHE of 50, effects", Mhe, EFFECTS, SINGLE),
        ("EKF, declared, double", Ekf, DECLARED, DOUBLE),
        ("MHE of 50, the same", Mhe, DECLARED, DOUBLE),
    ):
        with tempfile.TemporaryDirectory() as folder:
            code = generate_code(observer_of(kind, model, AligningTorque()), real, Path(folder))
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
