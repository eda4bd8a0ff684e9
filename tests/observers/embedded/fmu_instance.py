"""An FMU that FMPy calls as a co-simulation master, sample by sample."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Instance:
    """One instance; rows of samples are its inputs in the order of the model description."""

    def __init__(self, slave: Any, description: Any) -> None:
        """Wrap a slave."""
        self.slave, self.time = slave, 0.0
        self.inputs = [v.valueReference for v in description.modelVariables if v.causality == "input"]

    def step(self, row: Sequence[float], dt: float = 0.01) -> list[float]:
        """One communication step; the outputs at its end."""
        self.slave.setReal(self.inputs, list(row))
        self.slave.doStep(currentCommunicationPoint=self.time, communicationStepSize=dt)
        self.time += dt
        return self.outputs()

    def steps(self, rows: Array) -> Array:
        """Several communication steps."""
        return np.array([self.step(row) for row in rows])

    def outputs(self) -> list[float]:
        """The outputs in the order of `observers.ESTIMATE`."""
        flags, status = self.slave.getBoolean([7, 14]), self.slave.getInteger([8])
        numbers = self.slave.getReal([4, 5, 6, 9, 10, 11, 12])
        return [*numbers[:3], *flags, *numbers[3:], *status]


@contextmanager
def instances(folder: Path, count: int = 1, **state: Any) -> Iterator[list[Instance]]:
    """Instances of an unpacked FMU, initialised unless a state is set."""
    from fmpy import read_model_description
    from fmpy.fmi2 import FMU2Slave

    description = read_model_description(str(folder))
    slaves = [
        FMU2Slave(
            guid=description.guid,
            unzipDirectory=str(folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=f"instance {number}",
        )
        for number in range(count)
    ]
    for slave in slaves:
        slave.instantiate()
        if not state:
            initialise(slave)
    try:
        yield [Instance(slave, description) for slave in slaves]
    finally:
        for slave in slaves:
            slave.freeInstance()


def initialise(slave: Any) -> None:
    """Enter the mode in which the slave steps."""
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
