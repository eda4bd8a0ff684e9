"""The filter in single precision: its C generated, compiled and run on random but valid samples."""

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from pathlib import Path
from typing import Any, ClassVar

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from observers import AligningTorque, Ekf, Sample, SteeringTorque, Tuning
from observers.embedded.scalar_type import SINGLE, in_type
from observers.estimators.ekf import build_step
from observers.protocol import OUTPUT
from symbolic import Model, Rig, compiler, effects_named
from tests.compile_once import compile_once

Floats = NDArray[np.float32]
RIG, K = Rig(a=0.045, e=0.009, J_A=0.15, b_t=1.0), 2.4e6
FIRST = Sample(psi=0.0, psi_dot=0.0, F_N=400.0, dt=0.01)
FAULTS = ("sound", "not finite", "not positive")
NO_COMPILER = "no C compiler at hand (CC, else cc), or BRUSHGRIP_INTERPRET is set"
# C99 without GNU's extensions also keeps the compiler from fusing operations: the same on every machine.
FLAGS = ("-std=c99", "-O2", "-ftree-vectorize", "-march=native", "-fPIC", "-Wall", "-Werror")

ONE, THREE = AligningTorque(zero=False), AligningTorque(stiffness=True)
WHEEL, FIVE = SteeringTorque(), SteeringTorque(zero=True, stiffness=True)
SHARP: dict[str, Any] = {"noise": 1e-3, "error": inf, "gate": 5.0}
TRUSTING: dict[str, Any] = SHARP | {"gate": inf, "mu_walk": 0.0, "zero_walk": 0.0}
OPEN: dict[str, Any] = {
    "mu_std": 1e3, "zero_std": 1e2, "stiffness_std": 1e2, "psi_dot_std": 1e2, "least": 1e-4,
    "greatest": 1e3,
}  # fmt: skip
BRISTLES: dict[str, Any] = {"model": Model(discretised=True, bristles=40), "measurement_model": THREE}
FOUND: dict[str, Any] = {
    "model": Model(effects=effects_named(["rate_friction", "carcass_torsion"])),
    "values": {"k": K, "rate_friction.c": 0.04, "carcass_torsion.k_t": 390.0},
}


@dataclass(frozen=True, kw_only=True)
class Case:
    """A filter to be tried.

    Attributes:
        settings: of the filter, its tuning aside.
        tuning: settings of its tuning.
    """

    settings: Mapping[str, Any] = field(default_factory=dict)
    tuning: Mapping[str, Any] = field(default_factory=dict)

    @property
    def observer(self) -> Ekf:
        """The filter."""
        usual = {
            "model": Model(),
            "values": {"k": K},
            "rig": RIG,
            "acquire": False,
            "tuning": Tuning(**self.tuning),
        }
        return Ekf(**{**usual, **self.settings})


CASES = {
    "as it comes": Case(),
    "tiny noise": Case(tuning=SHARP),
    "tiny noise, no walk, no gate": Case(tuning=TRUSTING),
    "huge prior": Case(tuning=OPEN),
    "huge prior, tiny noise": Case(tuning=OPEN | SHARP),
    "mu alone, huge prior, no walk": Case(settings={"measurement_model": ONE}, tuning=OPEN | TRUSTING),
    "3 states": Case(settings={"measurement_model": THREE}),
    "3 states, huge prior, tiny noise": Case(settings={"measurement_model": THREE}, tuning=OPEN | SHARP),
    "3 states, huge prior, no walk": Case(settings={"measurement_model": THREE}, tuning=OPEN | TRUSTING),
    "3 states, huge prior, 3 iterations": Case(
        settings={"measurement_model": THREE, "iterations": 3}, tuning=OPEN | SHARP
    ),
    "3 states, bristles": Case(settings=BRISTLES, tuning=SHARP),
    "carcass and rate friction": Case(settings=FOUND, tuning=SHARP),
    "steering": Case(settings={"measurement_model": WHEEL}),
    "steering, 5 states": Case(settings={"measurement_model": FIVE}),
    "steering, 5 states, huge prior": Case(settings={"measurement_model": FIVE}, tuning=OPEN | SHARP),
    "steering, 5 states, no walk": Case(settings={"measurement_model": FIVE}, tuning=OPEN | TRUSTING),
}
"""Filters by what is special about them."""


@dataclass(frozen=True, kw_only=True)
class Trial:
    """What the sensors do beside measuring, one sample in twenty missing in any case.

    Attributes:
        bouts: share of the samples at which a channel fails for 2 to 300 samples [1].
        wildest: greatest wild number, over the size of an ordinary one [1].
        heaviest: greatest load; a wild one beyond is negative instead, and so none at all [N].
    """

    bouts: float = 0.0
    wildest: float = 1e6
    heaviest: float = 5e3


PLAIN, HARSH = Trial(), Trial(bouts=3e-4, wildest=1e35, heaviest=inf)


class Setup(ctypes.Structure):
    """`struct setup` of the driver."""

    _fields_: ClassVar[Sequence[Any]] = (
        *((name, ctypes.c_longlong) for name in (
            "size", "n", "factor", "last", "last_size", "status", "steering",
        )),
        *((name, ctypes.c_float) for name in ("a", "J_A", "b_t", "bouts", "wildest", "heaviest")),
    )  # fmt: skip


class Report(ctypes.Structure):
    """`struct report` of the driver: samples by what became of them, the fault, extremes of U and D."""

    _fields_: ClassVar[Sequence[Any]] = (
        *((name, ctypes.c_longlong) for name in (
            "steps", "missing", "held", "rejected", "resets", "bound", "fault", "at",
        )),
        *((name, ctypes.c_double) for name in ("least_D", "greatest_D", "greatest_U")),
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of a run.

    Attributes:
        report: counts and extremes.
        state: the last state; the one at fault if there is any.
        before: the state before it.
        sample: the sample between them, in the order of `observers.SAMPLE`.
    """

    report: Report
    state: Floats
    before: Floats
    sample: Floats

    @property
    def fault(self) -> str:
        """`sound`, or what is wrong with `state`."""
        return FAULTS[self.report.fault]


@dataclass(frozen=True)
class Single:
    """A filter in single precision.

    Attributes:
        observer: the filter.
        library: its C, compiled with the driver by `build`.
    """

    observer: Ekf
    library: Path

    def drive(self, steps: int, seed: int, trial: Trial = PLAIN, state: Floats | None = None) -> Outcome:
        """Random samples, from the start where no state is given, until a state is not sound."""
        state = self.start(FIRST) if state is None else state.copy()
        before, sample, report = np.empty_like(state), np.empty(6, np.float32), Report()
        rig = self.observer.rig
        tyre, geometry = np.array([1.0, K], np.float32), np.array([rig.a, rig.e], np.float32)
        self._loaded.drive(
            ctypes.byref(self._setup(trial)),
            ctypes.c_longlong(steps),
            ctypes.c_uint64(seed),
            *map(_pointer, (self._constants, tyre, geometry, state, before, sample)),
            ctypes.byref(report),
        )
        return Outcome(report=report, state=state, before=before, sample=sample)

    def follow(self, samples: Floats) -> Floats:
        """What the filter says of samples (n, 6) in the order of `observers.SAMPLE`, one row each."""
        psi, psi_dot, F_N, dt, *_ = samples[0].tolist()
        state = self.start(Sample(psi=psi, psi_dot=psi_dot, F_N=F_N, dt=dt))
        said = np.empty((len(samples), len(OUTPUT)), np.float32)
        self._loaded.follow(
            ctypes.c_longlong(state.size),
            ctypes.c_longlong(len(samples)),
            *map(_pointer, (samples, self._constants, state, state.copy(), said)),
        )
        return said

    def start(self, first: Sample) -> Floats:
        """The state before the first sample."""
        return self.observer.init(first).values[: self.observer.layout.size].astype(np.float32)

    @cached_property
    def _loaded(self) -> ctypes.CDLL:
        return ctypes.CDLL(str(self.library))

    @cached_property
    def _constants(self) -> Floats:
        return self.observer.constants.astype(np.float32)

    def _setup(self, trial: Trial) -> Setup:
        layout, rig = self.observer.layout, self.observer.rig
        at = {name: place for name, (place, _) in layout.places.items()}
        return Setup(
            size=layout.size, n=len(self.observer.states), factor=at["factor"].start,
            last=at["last"].start, last_size=at["last"].stop - at["last"].start,
            status=at["output"].start + OUTPUT.index("status"),
            steering="psi" in self.observer.states,
            a=rig.a, J_A=rig.J_A, b_t=rig.b_t, bouts=trial.bouts, wildest=trial.wildest,
            heaviest=trial.heaviest,
        )  # fmt: skip


def _pointer(array: Floats) -> ctypes.c_void_p:
    """Where a contiguous array of floats begins."""
    assert array.dtype == np.float32
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)


def in_single(*functions: ca.Function) -> str:
    """C of Functions in which no number is of double precision."""
    generator = ca.CodeGenerator("single.c", {"casadi_real": "float"})
    for function in functions:
        generator.add(function)
    return in_type(generator.dump(), SINGLE)


def build(observer: Ekf, folder: Path) -> Single:
    """The filter compiled with the driver, in a folder of its own; needs a compiler."""
    tyre = Model(corners=16).step
    symbols = [ca.MX.sym(tyre.name_in(i), tyre.size1_in(i)) for i in range(tyre.n_in())]
    renamed = ca.Function("tyre", symbols, tyre.call(symbols, True, False))
    step = build_step(observer.model, observer.measurement_model, observer.iterations)
    (folder / "step.c").write_text(in_single(step, renamed), "utf-8")
    command, library = compiler(), folder / "single.so"
    if command is None:
        raise RuntimeError(NO_COMPILER)
    driver = str(Path(__file__).with_name("float32.c"))
    for arguments in (
        # No warning of this kind is the proof that nothing is computed in double precision.
        ("-Wdouble-promotion", "-c", "step.c", "-o", "step.o"),
        ("-c", driver, "-o", "driver.o"),
        ("-shared", "step.o", "driver.o", "-lm", "-o", library.name),
    ):
        compile_once([command, *FLAGS, *arguments], folder, arguments[-1])
    return Single(observer, library)
