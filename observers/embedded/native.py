"""Generated C compiled for this machine, to be run along recordings before there is a target."""

import ctypes
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from observers.embedded.codegen import generate
from observers.embedded.jinja_templates import render
from observers.embedded.scalar_type import SINGLE, Real
from observers.estimates import Estimates
from observers.interfaces.run import as_estimates
from observers.protocol import ESTIMATE, FunctionObserver
from symbolic import InvalidInputError, compiler
from symbolic.compilation.operating_system import LIBRARY_SUFFIX
from symbolic.compilation.toolchain import compiler_command, run_compiler
from symbolic.float_array_type import Array

COMPILER_FLAGS = ("-std=c99", "-O2", "-fno-math-errno", "-fPIC", "-shared", "-I.")
"""The flags of a target: no instructions of one processor."""
_NAME = "native"


@dataclass(frozen=True, kw_only=True, eq=False)
class NativeObserver:
    """An observer in machine code."""

    real: Real  # The type of its numbers.
    library: ctypes.CDLL  # Contains `run` of templates/run.c, which one thread at a time may call.

    def run(
        self, t: Array, psi: Array, F_N: Array, torque: Array, psi_dot: Array | None = None
    ) -> Estimates:
        """The estimates along a recording, sample by sample, as `observers.run` returns them.

        Arguments are as there, all of shape (n,); torque is the one that the observer uses [N m].

        Raises:
            InvalidInputError: shapes differ.
        """
        channels = [psi, np.full(t.shape, np.nan) if psi_dot is None else psi_dot, torque, F_N]
        if t.ndim != 1 or t.size < 2 or any(channel.shape != t.shape for channel in channels):
            raise InvalidInputError("all channels must have the shape of t, (n,) with n >= 2")
        dt = np.diff(t, prepend=2 * t[0] - t[1])
        samples = np.column_stack([*channels, dt]).astype(self.real.dtype)
        outputs = np.empty((t.size, len(ESTIMATE)), self.real.dtype)
        pointers = (ctypes.c_void_p(array.ctypes.data) for array in (samples, outputs))
        self.library.run(ctypes.c_int64(t.size), *pointers)
        return as_estimates(t, outputs.T.astype(float), psi)


def compile_native(observer: FunctionObserver, real: Real = SINGLE) -> NativeObserver:
    """Generate an observer and compile it for this machine.

    Raises:
        InvalidInputError: as for `generate`; there is no C compiler (`CC`, else cc), or it fails.
    """
    command = compiler()
    if command is None:
        raise InvalidInputError("no C compiler was found; set CC, or put cc on the path")
    terms = {"name": _NAME, "real": real.c_type, "torque": observer.channel, "estimate": ESTIMATE}
    # What is loaded stays on Windows.
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as temporary:
        folder = Path(temporary)
        generate(observer, folder, real, name=_NAME)
        (folder / "run.c").write_text(render("run.c", terms), encoding="utf-8")
        library = f"{_NAME}{LIBRARY_SUFFIX}"
        try:
            run_compiler(
                compiler_command(command, [f"{_NAME}.c", "run.c"], library, COMPILER_FLAGS), folder
            )
            return NativeObserver(real=real, library=ctypes.CDLL(str(folder / library)))
        except (OSError, subprocess.SubprocessError) as error:
            raise InvalidInputError(f"the generated C was not compiled by {command}: {error}") from None
