"""The generated C compiled for this machine, to be taken along recordings as the target would be.

It shows what the code says and how long it takes before there is a target.
"""

import ctypes
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from observers.embedded.codegen import generate
from observers.embedded.scalar_type import SINGLE, Real
from observers.embedded.templating import filled
from observers.protocol import Estimates, FunctionObserver
from observers.run import as_estimates
from symbolic import InvalidInputError
from symbolic.compiled import compiler

Array = NDArray[np.float64]
FLAGS = ("-std=c99", "-O2", "-fno-math-errno", "-fPIC", "-shared", "-I.")
"""As a target would have them: nothing of this one processor."""
_NAME = "hosted"


@dataclass(frozen=True, kw_only=True, eq=False)
class Hosted:
    """An observer in machine code.

    Attributes:
        real: the type of its numbers.
        library: holds `along`, see templates/along.c; one thread at a time.
    """

    real: Real
    library: ctypes.CDLL

    def along(
        self, t: Array, psi: Array, F_N: Array, torque: Array, psi_dot: Array | None = None
    ) -> Estimates:
        """What the code says of a recording, sample by sample, as `observers.run` does.

        Args:
            t: time, increasing, shape (n,) with n >= 2 [s].
            psi: yaw angle, shape (n,), NaN where missing [rad].
            F_N: vertical load, shape (n,), NaN where missing [N].
            torque: the torque that the observer hears, shape (n,), NaN where missing [N m].
            psi_dot: yaw rate where it is measured, shape (n,) [rad/s]; None takes it from psi.

        Raises:
            InvalidInputError: shapes differ.
        """
        channels = [psi, np.full(t.shape, np.nan) if psi_dot is None else psi_dot, torque, F_N]
        if t.ndim != 1 or t.size < 2 or any(channel.shape != t.shape for channel in channels):
            raise InvalidInputError("all channels must have the shape of t, (n,) with n >= 2")
        steps = np.diff(t, prepend=2 * t[0] - t[1])
        samples = np.column_stack([*channels, steps]).astype(self.real.dtype)
        said = np.empty_like(samples)
        pointers = (ctypes.c_void_p(array.ctypes.data) for array in (samples, said))
        self.library.along(ctypes.c_int64(t.size), *pointers)
        return as_estimates(t, said.T.astype(float))


def host(observer: FunctionObserver, real: Real = SINGLE) -> Hosted:
    """Generate an observer and compile it for this machine.

    Raises:
        InvalidInputError: there is no C compiler (`CC`, else cc), or it fails.
    """
    command = compiler()
    if command is None:
        raise InvalidInputError("no C compiler at hand; set CC, or put cc on the path")
    torque = observer.channel
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        generate(observer, folder, real, name=_NAME)
        terms = {"name": _NAME, "real": real.c_type, "torque": torque}
        (folder / "along.c").write_text(filled("along.c", terms), encoding="utf-8")
        arguments = [command, *FLAGS, f"{_NAME}.c", "along.c", "-o", "hosted.so", "-lm"]
        try:
            subprocess.run(arguments, cwd=folder, check=True, capture_output=True, timeout=300)
            return Hosted(real=real, library=ctypes.CDLL(str(folder / "hosted.so")))
        except (OSError, subprocess.SubprocessError) as error:
            raise InvalidInputError(f"the generated C was not compiled by {command}: {error}") from None
