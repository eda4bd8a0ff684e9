"""An observer as a discrete-time system of python-control, for its simulations and interconnections.

It stands outside `import observers`, as control loads matplotlib and takes a second to import:

    from observers.interfaces.control_system import as_system
"""

import control
import numpy as np

from observers.estimators.casadi_observer import CasadiObserver
from observers.layout import ObserverState
from observers.protocol import ESTIMATE, Sample
from symbolic import InvalidInputError
from symbolic.float_array_type import Array


def as_system(
    observer: CasadiObserver, first: Sample, *, direct: bool = True
) -> control.NonlinearIOSystem:
    """The observer as a system with the packed state of `observer.layout` and steps of `first.dt`.

    Inputs are psi, psi_dot, F_N, M_z where the aligning torque is measured, psi, F_N, M where the
    steering torque is; outputs as in `ESTIMATE`. The state begins at `observer.init(first).values`, for
    which a state of zeros, control's default X0, stands too. NaN is a missing measurement as in
    `Sample`; control multiplies it by 0 where it interpolates, so that `input_output_response` loses the
    next sample too, and where it connects, so that an interconnection must have none.

    Args:
        observer: an `Ekf`, an `Mhe` or another `CasadiObserver`.
        first: says where the patch stands at rest, and the time between samples, its dt.
        direct: the output holds the present sample already, as `observers.run` has it. False: it is that
            of the state before, for a controller that chooses the present sample's torque by it. What is
            NaN in an estimate, such as M_z_predicted before the first sample, is 0.

    Raises:
        InvalidInputError: the observer's state is no vector, or `first` has no finite psi and F_N
            of at least 0.001 N.
    """
    if not isinstance(observer, CasadiObserver):
        raise InvalidInputError(
            f"as_system needs an observer whose state is one vector, Ekf or Mhe, got"
            f" {type(observer).__name__}; use observers.Loop or observers.run"
        )
    missing = {"psi": np.nan, "psi_dot": np.nan, "F_N": np.nan}
    start = observer.init(first)

    def state_of(x: Array) -> ObserverState:
        # mu is positive in every state: zeros stand for the state before the first sample.
        return ObserverState(x, start.layout) if x.any() else start

    def step(x: Array, u: Array) -> ObserverState:
        given = missing | dict(zip(observer.channels, u.tolist(), strict=True))
        return observer.step(state_of(x), Sample(dt=first.dt, **given))

    def update(_t: float, x: Array, u: Array, _params: object) -> Array:
        return step(x, u).values

    def output(_t: float, x: Array, u: Array, _params: object) -> Array:
        # Never NaN, which an interconnection would spread.
        return np.nan_to_num(observer.estimate(step(x, u) if direct else state_of(x)).numbers)

    return control.nlsys(
        update,
        output,
        inputs=list(observer.channels),
        outputs=list(ESTIMATE),
        states=[f"{name}[{i}]" for name, rows, cols in start.layout.fields for i in range(rows * cols)],
        dt=first.dt,
        name=observer.name,
    )
