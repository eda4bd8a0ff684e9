"""The filter in single precision: its C generated, compiled and run on random but valid samples."""

import ctypes
import re
import subprocess
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import inf
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from observers import AligningTorque, Ekf, Sample, SteeringTorque, Tuning
from observers.ekf import build_step
from symbolic import Model, Rig, effects_named
from symbolic.compiled import compiler

Floats = NDArray[np.float32]
RIG, K = Rig(a=0.045, e=0.009, J_A=0.15, b_t=1.0), 2.4e6
FLAGS = ("-std=c99", "-O2", "-fPIC", "-Wall", "-Werror")
LITERAL = re.compile(r"(?<![\w.])(?:\d+\.\d*(?:[eE][+-]?\d+)?|\d+[eE][+-]?\d+)(?![\w.])")
FAULTS = ("sound", "not finite", "not positive")

SHARP: dict[str, Any] = {"noise": 1e-3, "error": inf, "gate": 5.0}
TRUSTING: dict[str, Any] = {"noise": 1e-3, "error": inf, "gate": inf, "mu_walk": 0.0, "zero_walk": 0.0}
OPEN: dict[str, Any] = {
    "mu_std": 1e3, "zero_std": 1e2, "stiffness_std": 1e2, "psi_dot_std": 1e2, "least": 1e-4,
    "greatest": 1e3,
}  # fmt: skip
FOUND = Model(effects=effects_named(["rate_friction", "carcass_torsion"]))
BRISTLES = Model(discretised=True, lengthways=40)


@dataclass(frozen=True, kw_only=True)
class Case:
    """A filter to be tried.

    Attributes:
        settings: of the filter, those of its tuning aside.
        tuning: settings of its tuning.
    """

    settings: Mapping[str, Any] = field(default_factory=dict)
    tuning: Mapping[str, Any] = field(default_factory=dict)

    @property
    def observer(self) -> Ekf:
        """The filter."""
        usual = {"model": Model(), "values": {"k": K}, "rig": RIG, "tuning": Tuning(**self.tuning)}
        return Ekf(**{**usual, **self.settings})


ONE, THREE = AligningTorque(zero=False), AligningTorque(stiffness=True)
WHEEL, FIVE = SteeringTorque(), SteeringTorque(zero=True, stiffness=True)
FOUND_VALUES = {"k": K, "rate_friction.c": 0.04, "carcass_torsion.k_t": 390.0}
CASES = {
    "as it comes": Case(),
    "tiny noise": Case(tuning=SHARP),
    "tiny noise, no walk, no gate": Case(tuning=TRUSTING),
    "huge prior": Case(tuning=OPEN),
    "huge prior, tiny noise": Case(tuning=OPEN | SHARP),
    "mu alone, huge prior, tiny noise, no walk": Case(settings={"sensing": ONE}, tuning=OPEN | TRUSTING),
    "3 states": Case(settings={"sensing": THREE}),
    "3 states, huge prior, tiny noise": Case(settings={"sensing": THREE}, tuning=OPEN | SHARP),
    "3 states, huge prior, no walk": Case(settings={"sensing": THREE}, tuning=OPEN | TRUSTING),
    "3 states, 3 iterations, huge prior": Case(
        settings={"sensing": THREE, "iterations": 3}, tuning=OPEN | SHARP
    ),
    "steering": Case(settings={"sensing": WHEEL}),
    "steering, 5 states": Case(settings={"sensing": FIVE}),
    "steering, 5 states, huge prior": Case(settings={"sensing": FIVE}, tuning=OPEN | SHARP),
    "steering, 5 states, no walk": Case(settings={"sensing": FIVE}, tuning=OPEN | TRUSTING),
    "bristles, 3 states": Case(settings={"sensing": THREE, "model": BRISTLES}, tuning=SHARP),
    "carcass and rate friction": Case(settings={"model": FOUND, "values": FOUND_VALUES}, tuning=SHARP),
}
"""Filters by what is special about them."""


class Setup(ctypes.Structure):
    """`struct setup` of the driver."""

    _fields_ = (
        *((name, ctypes.c_longlong) for name in (
            "size", "n", "factor", "last", "last_size", "status", "steering"
        )),
        *((name, ctypes.c_float) for name in ("a", "J_A", "b_t")),
    )  # fmt: skip


class Report(ctypes.Structure):
    """`struct report` of the driver: samples by what became of them, the fault, and extremes of U and D."""

    _fields_ = (
        *((name, ctypes.c_longlong) for name in (
            "steps", "missing", "held", "rejected", "resets", "bound", "fault", "at"
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
        sample: the sample between them.
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
    """A filter in single precision; `library` is made by `build`."""

    observer: Ekf
    library: Path

    def start(self, first: Sample) -> Floats:
        """The state before the first sample."""
        return self.observer.init(first).values.astype(np.float32)

    @property
    def constants(self) -> Floats:
        """The constants of a step."""
        return self.observer.constants.astype(np.float32)

    @cached_property
    def _loaded(self) -> ctypes.CDLL:
        return ctypes.CDLL(str(self.library))

    @cached_property
    def _setup(self) -> Setup:
        layout, rig = self.observer.layout, self.observer.rig
        at = {name: place.start for name, (place, _) in layout.places.items()}
        return Setup(
            size=layout.size, n=len(self.observer.states), factor=at["factor"], last=at["last"],
            last_size=layout.places["last"][1][0], status=layout.places["said"][0].stop - 1,
            steering=self.observer.sensing.turns, a=rig.a, J_A=rig.J_A or 0, b_t=rig.b_t or 0,
        )  # fmt: skip

    def drive(self, steps: int, seed: int) -> Outcome:
        """Random samples, until a state is not sound."""
        state = self.start(Sample(psi=0.0, psi_dot=0.0, F_N=400.0, dt=0.01))
        outcome = Outcome(
            report=Report(), state=state, before=state.copy(), sample=np.zeros(6, np.float32)
        )
        rig = self.observer.rig
        given = (self.constants, np.array([1.0, K], np.float32), np.array([rig.a, rig.e], np.float32))
        made = (state, outcome.before, outcome.sample)
        if self._loaded.drive(
            ctypes.byref(self._setup),
            ctypes.c_longlong(steps),
            ctypes.c_uint64(seed),
            *(array.ctypes.data_as(ctypes.c_void_p) for array in (*given, *made)),
            ctypes.byref(outcome.report),
        ):
            raise MemoryError("no memory for the driver")
        return outcome


def source(function: ca.Function, *others: ca.Function) -> str:
    """C of Functions in which no number is of double precision."""
    generator = ca.CodeGenerator("single.c", {"casadi_real": "float"})
    for each in (function, *others):
        generator.add(each)
    # casadi writes sqrt, not sqrtf, and constants as doubles.
    return "#include <tgmath.h>\n" + LITERAL.sub(lambda found: f"{found.group()}f", generator.dump())


def build(observer: Ekf, folder: Path) -> Single:
    """The filter compiled with the driver in a folder of its own; the caller knows there is a compiler."""
    tyre = Model(corners=16).step
    arguments = [ca.MX.sym(tyre.name_in(i), tyre.size1_in(i)) for i in range(tyre.n_in())]
    named = ca.Function("tyre", arguments, tyre.call(arguments, True, False))
    step = build_step(observer.model, observer.sensing, observer.iterations)
    (folder / "single.c").write_text(source(step, named), "utf-8")
    driver = Path(__file__).with_name("single.c")
    command = compiler() or "cc"
    library = folder / "single.so"
    for arguments in (
        ("-Wdouble-promotion", "-c", "single.c", "-o", "step.o"),
        ("-c", driver, "-o", "driver.o"),
        ("-shared", "step.o", "driver.o", "-o", library, "-lm"),
    ):
        subprocess.run([command, *FLAGS, *arguments], cwd=folder, check=True, timeout=300)
    return Single(observer, library)
