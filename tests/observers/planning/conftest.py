import numpy as np
import pytest

from observers import Ekf, Estimate, Sample, profile
from observers.planning.steering_limits_and_paths import SteeringPath
from reference_rig import RigTyre, free_path, simulate_bristles
from symbolic import Model, Rig
from symbolic.float_array_type import Array

LOAD, K = 400.0, 2.4e6
RIG = Rig(a=0.045, e=0.009)


@pytest.fixture(scope="session")
def acquiring() -> Ekf:
    """A filter that acquires friction, with a clean torque."""
    return Ekf(model=Model(), values={"k": K}, rig=RIG, tuning=profile("clean"))


def observe_on_rig(observer: Ekf, path: SteeringPath, mu: float) -> tuple[list[Estimate], Array]:
    """Estimates along a path on the independent rig's bristles, and their M_z [N m]."""
    t, psi = np.append(0, path.t), np.append(path.begin, path.psi)
    tyre = RigTyre(a=RIG.a, e=RIG.e, k=K, mu=mu)
    drive = free_path(t, psi, load=LOAD)
    torque = np.interp(path.t, drive.t, simulate_bristles(drive, tyre, bristles=1000).M_z)
    state, estimates = observer.init(Sample(psi=path.begin, psi_dot=0.0, F_N=LOAD, dt=path.dt)), []
    for angle, rate, M_z in zip(path.psi, path.psi_dot, torque, strict=True):
        state = observer.step(state, Sample(psi=angle, psi_dot=rate, F_N=LOAD, dt=path.dt, M_z=M_z))
        estimates.append(observer.estimate(state))
    return estimates, torque
