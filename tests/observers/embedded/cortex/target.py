"""Generated code on an emulated Cortex-M: compiled, run along samples, cost counted in instructions."""

import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from symbolic.float_array_type import Array
from tests.observers.embedded.generated_code import GeneratedCode

HERE = Path(__file__).parent
COMPILER, EMULATOR = "arm-none-eabi-gcc", "qemu-system-arm"
TOOLS = "needs arm-none-eabi-gcc with newlib, and qemu-system-arm"
CODE = (
    *("-std=c99", "-O2", "-fno-math-errno", "-ffp-contract=off", "-ffunction-sections"),
    *("-Wall", "-Wextra", "-Werror"),
)


@dataclass(frozen=True, kw_only=True)
class Board:
    """A processor and a board that the emulator knows with it."""

    name: str
    flags: tuple[str, ...]


M4F = Board(
    name="mps2-an386", flags=("-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard")
)
M7 = Board(
    name="mps2-an500", flags=("-mcpu=cortex-m7", "-mthumb", "-mfpu=fpv5-sp-d16", "-mfloat-abi=hard")
)


@dataclass(frozen=True, kw_only=True)
class Cost:
    """Cost of the code.

    Attributes:
        estimates: after each sample, a row in the order of `observers.ESTIMATE`.
        flash: bytes of code and constants, what it needs of math.h and memcpy included.
        state: bytes of one observer.
        stack: bytes of stack that a step touches.
        instructions: a step takes on average.
        most: instructions of the longest step, to within the resolution of 40.
    """

    estimates: Array
    flash: int
    state: int
    stack: int
    instructions: float
    most: int


def tools_installed() -> bool:
    """True where all of `TOOLS` is installed."""
    return all(shutil.which(command) for command in (COMPILER, EMULATOR))


def run_on(board: Board, code: GeneratedCode, samples: Array) -> Cost:
    """Single-precision code along samples (n, 5) psi, psi_dot, torque, F_N, dt."""
    folder = code.folder
    (folder / "samples.h").write_text(_samples(samples), "utf-8")
    torque = code.observer.channel
    _compile(folder, board, *CODE, "-c", "brushgrip.c", "-o", "target.o")
    usual = ("-O1", f"-DTORQUE={torque}", "-I.", "-nostartfiles")
    program = [str(HERE / name) for name in ("startup.c", "run.c")]
    _compile(
        folder, board, *usual, *program, "target.o", "-T", str(HERE / "memory.ld"),
        "--specs=rdimon.specs", "-lm", "-o", "run.elf",
    )  # fmt: skip
    _compile(
        folder, board, *usual, str(HERE / "probe.c"), "target.o", "-Wl,--gc-sections,-e,probe,-u,probe",
        "--specs=nosys.specs", "-lm", "-o", "probe.elf",
    )  # fmt: skip
    lines = _emulated(folder, board)
    numbers = {name: int(value) for name, value in (line.split() for line in lines[:5])}
    return Cost(
        estimates=np.array([_estimate(line) for line in lines[5:]]),
        flash=_flash(folder / "probe.elf"),
        state=numbers["state"],
        stack=numbers["stack"],
        instructions=numbers["tick"] * numbers["spent"] / len(samples),
        most=numbers["tick"] * numbers["most"],
    )


def _compile(folder: Path, board: Board, *arguments: str) -> None:
    subprocess.run([COMPILER, *board.flags, *arguments], cwd=folder, check=True, timeout=300)


def _emulated(folder: Path, board: Board) -> list[str]:
    command = [EMULATOR, "-M", board.name, "-nographic", "-monitor", "none", "-serial", "none"]
    command += ["-icount", "shift=0", "-semihosting-config", "enable=on,target=native"]
    command = [*command, "-kernel", "run.elf"]
    emulation = subprocess.run(
        command, cwd=folder, check=True, timeout=300, capture_output=True, text=True
    )
    return emulation.stdout.splitlines()


def _flash(program: Path) -> int:
    """Bytes of code and constants."""
    command = ["arm-none-eabi-size", str(program)]
    listed = subprocess.run(command, check=True, capture_output=True, text=True)
    return int(listed.stdout.splitlines()[1].split()[0])


def _samples(samples: Array) -> str:
    rows = (",".join("NAN" if np.isnan(v) else f"{v:.9e}f" for v in row) for row in samples)
    table = ",\n".join(f"{{{row}}}" for row in rows)
    head = (
        f"#include <math.h>\n#define COUNT {len(samples)}\nstatic const float SAMPLES[COUNT][5] = {{\n"
    )
    return f"{head}{table}\n}};\n"


def _estimate(line: str) -> list[float]:
    numbers = line.split()
    informed, usable, status = (float(numbers.pop(at)) for at in (3, 3, -1))
    reals = np.array([int(number, 16) for number in numbers], np.uint32).view(np.float32).astype(float)
    return [*reals[:3].tolist(), informed, usable, *reals[3:].tolist(), status]
