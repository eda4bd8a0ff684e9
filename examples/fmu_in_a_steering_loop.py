"""The observer as an FMU in a steering loop
=========================================

The steering loop of `steering_controller.py` with the observer as an FMU, driven by FMPy beside it.

Wheel and controller are python-control's, the observer is co-simulated: in every step the loop is asked
for its sensors, with the last estimate of the FMU; the FMU is given them and makes its step, and the
loop makes its own. The result is compared with the same loop with the observer in Python. Needs FMPy
(pip install fmpy) and a C compiler, which builds the FMU.
"""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

import control
import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

import steering_controller as loop
from observers.embedded import DOUBLE, generate_fmu
from steering_controller import LOAD, NOISE, STEP


@contextmanager
def running_fmu() -> Iterator[tuple[FMU2Slave, dict[str, int]]]:
    """The FMU, ready to step, and its value references by name."""
    with tempfile.TemporaryDirectory() as folder:
        archive = str(generate_fmu(loop.EKF, folder, DOUBLE))
        described, unpacked = fmpy.read_model_description(archive), fmpy.extract(archive)
        fmu = FMU2Slave(
            guid=described.guid,
            unzipDirectory=unpacked,
            modelIdentifier=described.coSimulation.modelIdentifier,
            instanceName="observer",
        )
        try:
            fmu.instantiate()
            fmu.setupExperiment(startTime=0.0)
            fmu.enterInitializationMode()
            fmu.exitInitializationMode()
            yield fmu, {v.name: v.valueReference for v in described.modelVariables}
            fmu.terminate()
            fmu.freeInstance()
        finally:
            shutil.rmtree(unpacked)


def run() -> tuple[float, float, float]:
    """The rms of the tracking error [rad], the last mu_eff, its standard deviation."""
    t, psi_ref, *_ = loop.reference()
    noise = NOISE * np.random.default_rng(1).standard_normal(t.size)
    plant = control.interconnect(
        [loop.wheel(), loop.controller(compensates=True)],
        inputs=["noise", "mu_eff", "usable"],
        outputs=["angle", "psi", "M"],
        check_unused=False,
    )
    x, error = np.zeros(plant.nstates), np.empty(t.size)
    with running_fmu() as (fmu, at):
        inputs, outputs = [at["psi"], at["M"], at["F_N"]], [at["mu_eff"], at["mu_eff_std"]]
        for n, now in enumerate(t):
            mu_eff, _ = fmu.getReal(outputs)
            (usable,) = fmu.getBoolean([at["usable"]])
            given = [noise[n], mu_eff if usable else 0.0, float(usable)]
            angle, psi, M = plant.output(now, x, given)
            error[n] = angle - psi_ref[n]
            fmu.setReal(inputs, [psi, M, LOAD])
            fmu.doStep(currentCommunicationPoint=now, communicationStepSize=STEP)
            x = plant.dynamics(now, x, given)
        mu_eff, mu_eff_std = fmu.getReal(outputs)
    return float(np.sqrt(np.mean(error**2))), mu_eff, mu_eff_std


def main() -> None:
    """Track the reference with the FMU's friction, then with the Python observer's."""
    error, mu_eff, mu_eff_std = run()
    print(
        f"mu_eff at the end, by the FMU: {mu_eff:.4f} ± {mu_eff_std:.4f} (the ground has {loop.GROUND})"
    )
    print(f"control error with the FMU: {1000 * error:.3f} mrad rms")
    in_python, *_ = loop.run()
    print(f"with the observer in Python: {1000 * in_python:.3f} mrad rms")


if __name__ == "__main__":
    main()
