"""An FMU driven by FMPy, sample by sample, as a co-simulation master drives it."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
OUTPUTS = ("mu", "mu_std", "M_z_predicted", "informed", "status")


class Driven:
    """One instance; rows of samples are its inputs in the order of the model description."""

    def __init__(self, slave: Any, described: Any) -> None:
        """Of an instance that steps."""
        self.slave, self.time = slave, 0.0
        self.inputs = [v.valueReference for v in described.modelVariables if v.causality == "input"]

    def step(self, row: Sequence[float], dt: float = 0.01) -> list[float]:
        """One communication step; what is said at its end."""
        self.slave.setReal(self.inputs, list(row))
        self.slave.doStep(currentCommunicationPoint=self.time, communicationStepSize=dt)
        self.time += dt
        return self.said()

    def steps(self, rows: Array) -> Array:
        """Several communication steps."""
        return np.array([self.step(row) for row in rows])

    def said(self) -> list[float]:
        """The outputs, as in `OUTPUTS`."""
        return [*self.slave.getReal([4, 5, 6]), *self.slave.getBoolean([7]), *self.slave.getInteger([8])]


@contextmanager
def driven(folder: Path, count: int = 1, **state: Any) -> Iterator[list[Driven]]:
    """So many instances of an FMU that is unpacked, initialised unless a state is set anyway."""
    from fmpy import read_model_description
    from fmpy.fmi2 import FMU2Slave

    described = read_model_description(str(folder))
    made = [
        FMU2Slave(
            guid=described.guid,
            unzipDirectory=str(folder),
            modelIdentifier=described.coSimulation.modelIdentifier,
            instanceName=f"instance {number}",
        )
        for number in range(count)
    ]
    for slave in made:
        slave.instantiate()
        if not state:
            initialise(slave)
    try:
        yield [Driven(slave, described) for slave in made]
    finally:
        for slave in made:
            slave.freeInstance()


def initialise(slave: Any) -> None:
    """Into the mode in which it steps."""
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
