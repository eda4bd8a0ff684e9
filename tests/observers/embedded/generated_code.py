"""Generated code as a library that Python calls, and the same observer in Python."""

import ctypes
import hashlib
import subprocess
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from observers import (
    ESTIMATE,
    AligningTorque,
    DirectionalFriction,
    Ekf,
    Estimate,
    Loop,
    Mhe,
    ObserverState,
    Sample,
    SteeringTorque,
    Tuning,
)
from observers.compiled_step import CompiledStep
from observers.embedded import Real, Tunable, generate
from observers.embedded.compact_codegen import compact_patch
from reference_rig import RigRecording, SteeringRecording
from symbolic import compiler
from symbolic.float_array_type import Array
from tests.compile_once import OPTIMISATION, compile_once
from tests.observers.conftest import RIG
from tests.observers.factories import DECLARED, columns_of, found_model, samples_of

NO_COMPILER = "no C compiler installed (CC, else cc), or BRUSHGRIP_INTERPRET is set"
needs_compiler = pytest.mark.skipif(compiler() is None, reason=NO_COMPILER)
STRICT = (
    "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Werror",
)  # fmt: skip
_COMPLIANT = {"rate_friction.c": 0.04, "carcass_torsion.k_t": 390.0}
EFFECTS = found_model(_COMPLIANT)
FEW_BRISTLES = found_model(_COMPLIANT, bristles=8)
"""The same effects for tests of the code, in which the number of bristles does not matter."""
_MAXWELL = {"viscoelastic_relaxation.gain": 0.3, "viscoelastic_relaxation.time": 0.5}
RELAXING = found_model(_MAXWELL, bristles=8)
"""Bristles without a compliance, each with a Maxwell branch."""
CREEP = found_model({"frictional_creep.c": 0.14, "carcass_torsion.k_t": 330.0}, bristles=12)
"""Frictional creep behind a compliance."""
MEASURED_RUN = found_model(
    {"frictional_creep.c": 0.1132, "tared_pretwist.psi_0": 0.0, "tared_pretwist.M_0": 0.0}
    | {"pressure_skew.skew": -0.95, "friction_drift.scale": 0.256, "friction_drift.gain": 0.211},
    k=2.956e6,
)
"""The model of docs/evidence/measured.md."""
_CREEPING = {"frictional_creep.c": 0.1, "carcass_torsion.k_t": 300.0}
FOUND = found_model(_CREEPING | {"asymmetric_friction.ratio": 1.1})
"""The same effects on the rig's usual tyre."""
TORSION = found_model({"carcass_torsion.k_t": 300.0})
SPRING = found_model({"steering_return.stiffness": 6.0, "bearing_friction.M_c": 0.1})
"""Effects that add to the torque of the patch."""
KINDS: dict[str, Any] = {"ekf": Ekf, "mhe": Mhe}
MODELS = {
    "declared": DECLARED, "effects": EFFECTS, "few": FEW_BRISTLES, "relaxing": RELAXING, "creep": CREEP,
    "measured": MEASURED_RUN, "torsion": TORSION, "found": FOUND,
    "spring": SPRING,
}  # fmt: skip
TORQUES: dict[str, Any] = {
    "aligning": AligningTorque(),
    "steering": SteeringTorque(),
    "direction": DirectionalFriction(),
    "aligning,k": AligningTorque(stiffness=True),
    "steering,k,M_0": SteeringTorque(zero=True, stiffness=True),
}


def observer_of(
    kind: type[Ekf] | type[Mhe],
    model: dict[str, Any],
    measurement_model: Any,
    *,
    acquire: bool = True,
    **tuning: Any,
) -> Any:
    """An observer on the rig's usual tyre."""
    own = {"measurement_model": measurement_model, "acquire": acquire, "tuning": Tuning(**tuning)}
    return kind(**model, rig=RIG, **own)


def observer_named(name: str, **settings: Any) -> Any:
    """An observer by kind, model and torque, as "ekf declared aligning"."""
    kind, model, torque = name.split()
    return observer_of(KINDS[kind], MODELS[model], TORQUES[torque], **settings)


def observer_of_budget(name: str) -> tuple[Any, list[str]]:
    """The observer of a row of instructions.toml, and the words after its name."""
    words = name.split()
    return observer_named(" ".join(words[:3]), acquire="plain" not in words), words[3:]


def tunable_of(words: list[str]) -> Tunable:
    """What is taken at run time, of such words."""
    return "all" if "all" in words else "tuning" if "tuning" in words else ""


def cases(quick: str, long: str = "", *more: Any) -> list[Any]:
    """Parameters of a test: names, separated by semicolons, of the quick tier and of the other.

    Each is followed by `more`.
    """
    marked = [(name, ()) for name in quick.split("; ")]
    marked += [(name, (pytest.mark.long,)) for name in long.split("; ") if name]
    return [pytest.param(name, *more, id=name.replace(" ", "-"), marks=marks) for name, marks in marked]


@dataclass(frozen=True, eq=False)
class GeneratedCode:
    """Generated code in its folder, and compiled on demand."""

    observer: Any
    real: Real
    folder: Path

    def run(self, samples: Array) -> Array:
        """Estimates as `python_estimates` for samples (n, 5) psi, psi_dot, torque, F_N, dt."""
        return RunningCode(self).run(samples)

    def compile(self, *flags: str, sources: tuple[str, ...], out: str, command: str = "") -> Path:
        """Compile sources, relative to the folder, into a file of it."""
        torque = self.observer.channel
        arguments = [command or str(compiler()), f"-DREAL={self.real.c_type}", f"-DTORQUE={torque}"]
        arguments += ["-ffp-contract=off", "-I.", *flags, *sources, "-o", out]
        arguments += [] if {"-c", "-fsyntax-only"} & set(flags) else ["-lm"]
        if "-fsyntax-only" in flags:
            subprocess.run(arguments, cwd=self.folder, check=True, timeout=300)
        else:
            compile_once(arguments, self.folder, out)
        return self.folder / out

    @cached_property
    def core(self) -> Path:
        """The object file of the code alone."""
        return self.compile(*STRICT, OPTIMISATION, "-fPIC", "-c", sources=("brushgrip.c",), out="core.o")

    @cached_property
    def library(self) -> ctypes.CDLL:
        """The code with the driver run.c."""
        sources = (self.core.name, str(Path(__file__).with_name("run.c")))
        name = hashlib.sha256((self.folder / "brushgrip.c").read_bytes()).hexdigest()[:12]
        flags = (OPTIMISATION, "-fPIC", "-shared")
        return ctypes.CDLL(str(self.compile(*flags, sources=sources, out=f"{name}.so")))


class RunningCode:
    """A state of generated code that goes on from call to call.

    `usual` are the sizes of psi [rad], psi_dot [rad/s], torque [N m], and F_N [N] and dt [s] themselves.
    """

    def __init__(self, code: GeneratedCode) -> None:
        """Begin with a virgin patch."""
        self.code, library = code, code.library
        for name in ("state_size", "fuzz", "wander"):
            getattr(library, name).restype = ctypes.c_int64
        self._state = ctypes.create_string_buffer(library.state_size() + 64)
        library.brushgrip_init(self.at)

    def reset(self) -> None:
        """Forget everything."""
        self.code.library.brushgrip_reset(self.at)

    def run(self, samples: Array) -> Array:
        """Estimates after samples (n, 5), as `GeneratedCode.run`."""
        inputs = np.ascontiguousarray(samples, self.code.real.dtype)
        estimates = np.empty((len(inputs), len(ESTIMATE)), self.code.real.dtype)
        count = ctypes.c_int64(len(inputs))
        self.code.library.run_on(self.at, count, _pointer(inputs), _pointer(estimates))
        return estimates.astype(float)

    def fuzz(self, count: int, seed: int, usual: list[float]) -> tuple[int, int]:
        """Of count samples with random bytes: how many leave an invalid estimate, or are refused."""
        refused = ctypes.c_int64()
        invalid = self.code.library.fuzz(
            self.at, ctypes.c_int64(count), ctypes.c_uint64(seed), *self._numbers(usual),
            ctypes.byref(refused),
        )  # fmt: skip
        return int(invalid), refused.value

    def wander(self, count: int, seed: int, usual: list[float], turn: float) -> int:
        """How many estimates are invalid along a wheel at random, by `turn` [rad] a sample at most."""
        typical, *bounds = self._numbers(usual)
        numbers = ctypes.c_int64(count), ctypes.c_uint64(seed), typical, type(bounds[0])(turn), *bounds
        return int(self.code.library.wander(self.at, *numbers))

    @property
    def at(self) -> ctypes.c_void_p:
        """The state, aligned as any type of C may have to be."""
        return ctypes.c_void_p(-(-ctypes.addressof(self._state) // 64) * 64)

    def _numbers(self, usual: list[float]) -> list[Any]:
        """Usual sizes, least and greatest valid mu."""
        number, tuning = getattr(ctypes, f"c_{self.code.real.c_type}"), self.code.observer.tuning
        self._usual = np.array(usual, self.code.real.dtype)
        bounds = tuning.least * (1 - 1e-6), tuning.greatest * (1 + 1e-6)
        return [_pointer(self._usual), *map(number, bounds)]


def generate_code(observer: Any, real: Real, folder: Path, *, tunable: Tunable = "") -> GeneratedCode:
    """Generate an observer into a folder of its own."""
    generate(observer, folder, real, tunable=tunable)
    return GeneratedCode(observer, real, folder)


class InterpretedObserver:
    """The observer in CasADi's virtual machine: no compiler fuses or reorders its operations."""

    def __init__(self, observer: Any) -> None:
        """Take over an observer."""
        self.observer, self.channel = observer, observer.channel
        self.sample_limits = observer.sample_limits
        self._compiled_step = CompiledStep(observer.screened_step, observer.constants)

    def init(self, first: Sample) -> ObserverState:
        state: ObserverState = self.observer.init(first)
        return state

    def step(self, state: ObserverState, sample: Sample) -> ObserverState:
        return ObserverState(self._compiled_step(state.values, sample), state.layout)

    def estimate(self, state: ObserverState) -> Estimate:
        estimate: Estimate = self.observer.estimate(state)
        return estimate


def python_estimates(observer: Any, samples: Array) -> Array:
    """Estimates of `Loop` after samples (n, 5), a row each in the order of `observers.ESTIMATE`."""
    loop, rows = Loop(observer), []
    for psi, psi_dot, torque, F_N, dt in samples.tolist():
        now = loop(Sample(psi=psi, psi_dot=psi_dot, F_N=F_N, dt=dt, **{observer.channel: torque}))
        rows.append(now.numbers)
    return np.array(rows)


def assert_same(code: GeneratedCode, rows: Array, *, atol: float = 1e-10, mu: float = 1e-8) -> None:
    """C estimates what Python's Functions do without a compiler, and the rows tell it something of mu.

    Compact code takes other operations than Python; what CasADi writes takes the same. `mu` is the
    largest difference of mu and its standard deviation, `atol` that of all else beside 1e-9 of it.
    """
    expected = python_estimates(InterpretedObserver(code.observer), rows)
    estimates = code.run(rows)
    if compact_patch(code.observer, code.real) is None:
        np.testing.assert_array_equal(estimates, expected)
    else:
        np.testing.assert_allclose(estimates, expected, rtol=1e-9, atol=atol)
        np.testing.assert_allclose(estimates[:, :2], expected[:, :2], rtol=0, atol=mu)
        np.testing.assert_array_equal(estimates[:, [3, 4, -1]], expected[:, [3, 4, -1]])
    assert np.ptp(estimates[:, 0]) > 0.005, "no measurement corrected mu"


def rows_of(recording: RigRecording | SteeringRecording, torque: str = "") -> Array:
    """Samples (n, 5) psi, psi_dot, torque, F_N, dt of a recording; its own torque if none is named."""
    torque = torque or ("M_z" if isinstance(recording, RigRecording) else "M")
    samples = samples_of(columns_of(recording))
    return np.array([(s.psi, s.psi_dot, getattr(s, torque), s.F_N, s.dt) for s in samples])


def swinging(count: int) -> Array:
    """Samples (n, 5) of a wheel that swings, without a rate, under a torque that is none of its tyre."""
    t = 0.01 * np.arange(count)
    columns = 0.2 * np.sin(5 * t), t * np.nan, -8 * np.sin(5 * t), 400 + 0 * t, 0.01 + 0 * t
    return np.column_stack(columns)


def _pointer(array: NDArray[Any]) -> ctypes.c_void_p:
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)
