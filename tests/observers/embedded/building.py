"""Generated code compiled as a library and driven from Python, and the same observer in Python."""

import ctypes
import hashlib
import subprocess
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from observers import Ekf, Estimate, Loop, Mhe, ObserverState, Sample, Tuning
from observers.compiled_step import CompiledStep
from observers.embedded import Real, generate
from symbolic import Model, effects_named
from symbolic.compiled import compiler
from tests.observers.conftest import RIG, K

Array = NDArray[np.float64]
NO_COMPILER = "no C compiler at hand (CC, else cc), or BRUSHGRIP_INTERPRET is set"
STRICT = (
    "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Werror",
)  # fmt: skip
EFFECTS = ["rate_friction", "carcass_torsion"]
FOUND: dict[str, Any] = {
    "model": Model(effects=effects_named(EFFECTS)),
    "values": {"k": K, "rate_friction.c": 0.04, "carcass_torsion.k_t": 390.0},
}
DECLARED: dict[str, Any] = {"model": Model(), "values": {"k": K}}


def observer_of(kind: type[Ekf] | type[Mhe], model: dict[str, Any], sensing: Any, **tuning: Any) -> Any:
    """An observer on the rig's usual tyre."""
    return kind(**model, rig=RIG, measurement_model=sensing, tuning=Tuning(**tuning))


@dataclass(frozen=True, eq=False)
class Built:
    """Generated code in a library, or what it was generated to."""

    observer: Any
    real: Real
    folder: Path

    def follow(self, samples: Array) -> Array:
        """What the code says after samples (n, 5) psi, psi_dot, torque, F_N, dt; (n, 5) as `said_by`."""
        given = np.ascontiguousarray(samples, self.real.dtype)
        said = np.empty_like(given)
        self.library.follow(ctypes.c_int64(len(given)), _pointer(given), _pointer(said))
        return said.astype(float)

    def follow_two(self, samples: Array) -> tuple[Array, Array]:
        """The same for two observers that take turns, the second on the samples backwards."""
        given = np.ascontiguousarray(samples, self.real.dtype)
        said, other = np.empty_like(given), np.empty_like(given)
        self.library.follow_two(ctypes.c_int64(len(given)), *map(_pointer, (given, said, other)))
        return said.astype(float), other.astype(float)

    def fuzz(self, count: int, seed: int, usual: list[float]) -> tuple[int, int]:
        """Of so many samples with random bytes: how many leave no sound estimate, or are refused."""
        refused, number = ctypes.c_int64(), getattr(ctypes, f"c_{self.real.c_type}")
        typical, tuning = np.array(usual, self.real.dtype), self.observer.tuning
        self.library.fuzz.restype = ctypes.c_int64
        unsound = self.library.fuzz(
            ctypes.c_int64(count), ctypes.c_uint64(seed), _pointer(typical),
            number(tuning.least * (1 - 1e-6)), number(tuning.greatest * (1 + 1e-6)),
            ctypes.byref(refused),
        )  # fmt: skip
        return int(unsound), refused.value

    def compile(self, *flags: str, sources: tuple[str, ...], out: str, command: str = "") -> Path:
        """Compile files of the folder, or by absolute path, into one of it."""
        torque = self.observer.channel
        arguments = [command or str(compiler()), f"-DREAL={self.real.c_type}", f"-DTORQUE={torque}"]
        arguments += ["-ffp-contract=off", "-I.", *flags, *sources, "-o", out]
        arguments += [] if {"-c", "-fsyntax-only"} & set(flags) else ["-lm"]
        subprocess.run(arguments, cwd=self.folder, check=True, timeout=300)
        return self.folder / out

    @cached_property
    def library(self) -> ctypes.CDLL:
        """The code with the driver."""
        self.compile(*STRICT, "-O1", "-fPIC", "-c", sources=("brushgrip.c",), out="core.o")
        sources = ("core.o", str(Path(__file__).with_name("follow.c")))
        name = hashlib.sha256((self.folder / "brushgrip.c").read_bytes()).hexdigest()[:12]
        made = self.compile("-O1", "-fPIC", "-shared", sources=sources, out=f"{name}.so")
        return ctypes.CDLL(str(made))


def build(observer: Any, real: Real, folder: Path) -> Built:
    """Generated code in a folder of its own."""
    generate(observer, folder, real)
    return Built(observer, real, folder)


class Interpreted:
    """The observer with casadi's own arithmetic: no compiler fuses or reorders its operations."""

    def __init__(self, observer: Any) -> None:
        """Of an observer."""
        self.observer = observer
        self._compiled_step = CompiledStep(observer.step_function, observer.constants)

    def init(self, first: Sample) -> ObserverState:
        state: ObserverState = self.observer.init(first)
        return state

    def step(self, state: ObserverState, sample: Sample) -> ObserverState:
        return ObserverState(self._compiled_step(state.values, sample), state.layout)

    def estimate(self, state: ObserverState) -> Estimate:
        said: Estimate = self.observer.estimate(state)
        return said


def said_by(observer: Any, samples: Array, turns: bool) -> Array:
    """mu, mu_std, M_z_predicted, informed, status of `Loop` after samples (n, 5)."""
    loop, said = Loop(observer), []
    for psi, psi_dot, torque, F_N, dt in samples.tolist():
        torques = {"M" if turns else "M_z": torque}
        now = loop(Sample(psi=psi, psi_dot=psi_dot, F_N=F_N, dt=dt, **torques))
        said.append([now.mu, now.mu_std, now.M_z_predicted, now.informed, int(now.status)])
    return np.array(said, dtype=float)


def _pointer(array: NDArray[Any]) -> ctypes.c_void_p:
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)
