"""An FMU of either version that FMPy calls as a co-simulation master, sample by sample."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from symbolic.float_array_type import Array


class Instance:
    """One instance; rows of samples are its inputs in the order of the model description."""

    def __init__(self, slave: Any, description: Any) -> None:
        """Wrap a slave."""
        self.slave, self.time, self.is_3 = slave, 0.0, description.fmiVersion == "3.0"
        self.inputs = [v.valueReference for v in description.modelVariables if v.causality == "input"]
        self.set, self.get, self.integers, self.set_integers = (
            (slave.setFloat64, slave.getFloat64, slave.getInt32, slave.setInt32)
            if self.is_3
            else (slave.setReal, slave.getReal, slave.getInteger, slave.setInteger)
        )

    def initialise(self) -> None:
        """Enter the mode in which the slave steps."""
        if self.is_3:
            self.slave.enterInitializationMode(startTime=0.0)
        else:
            self.slave.setupExperiment(startTime=0.0)
            self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def step(self, row: Sequence[float], dt: float = 0.01) -> list[float]:
        """One communication step; the outputs at its end."""
        self.set(self.inputs, list(row))
        told = self.slave.doStep(currentCommunicationPoint=self.time, communicationStepSize=dt)
        self.time += dt
        if self.is_3:
            assert told[-1] == pytest.approx(self.time) == self.get([13])[0]
        return self.outputs()

    def steps(self, rows: Array) -> Array:
        """Several communication steps."""
        return np.array([self.step(row) for row in rows])

    def outputs(self) -> list[float]:
        """The outputs in the order of `observers.ESTIMATE`."""
        numbers, flags = self.get([4, 5, 6, 9, 10, 11, 12]), self.slave.getBoolean([7, 14])
        return [*numbers[:3], *flags, *numbers[3:], *self.integers([8])]

    def saved(self) -> bytes:
        """The state, serialised."""
        state = self.slave.getFMUState()
        sent: bytes = self.slave.serializeFMUState(state)
        self.slave.freeFMUState(state)
        return sent

    def restore(self, sent: bytes, time: float) -> None:
        """Go on from a state."""
        state = self.slave.deserializeFMUState(sent)
        self.slave.setFMUState(state)
        self.slave.freeFMUState(state)
        self.time = time


@contextmanager
def instances(folder: Path, count: int = 1, *, initialised: bool = True) -> Iterator[list[Instance]]:
    """Instances of an unpacked FMU."""
    from fmpy import read_model_description
    from fmpy.fmi2 import FMU2Slave
    from fmpy.fmi3 import FMU3Slave

    description = read_model_description(str(folder))
    kind = FMU3Slave if description.fmiVersion == "3.0" else FMU2Slave
    slaves = [
        kind(
            guid=description.guid, unzipDirectory=str(folder), instanceName=f"instance {number}",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        for number in range(count)
    ]  # fmt: skip
    made = [Instance(slave, description) for slave in slaves]
    for one in made:
        one.slave.instantiate()
        if initialised:
            one.initialise()
    try:
        yield made
    finally:
        for slave in slaves:
            slave.freeInstance()
