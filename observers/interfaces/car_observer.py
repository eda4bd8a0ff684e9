"""An observer of a car: from its vehicle, its samples, and over the standstills of a recording."""

from collections.abc import Callable, Sequence
from math import inf, isnan, nan
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from observers.estimates import Estimates
from observers.estimators.model_observer import ModelObserver
from observers.interfaces.run import as_estimates, run
from observers.interfaces.tuning_profiles import tuning_for
from observers.measurement.rack_force import RackForce
from observers.protocol import ESTIMATE, Observer, Sample, Status
from symbolic import InvalidInputError, Model
from symbolic.float_array_type import Array
from symbolic.vehicle.mean_wheel import rig_of, wheel_from_rack
from symbolic.vehicle.rack_time_derivatives import RackTimeDerivatives
from symbolic.vehicle.vehicle import Vehicle

Kind = TypeVar("Kind", bound=ModelObserver)
HOLDING = ("mu", "mu_std", "mu_eff", "mu_eff_std", "M_slide")
"""Values that are held while the car rolls."""
FIRST_PERIOD = 0.01
"""Time before the first sample of a standstill, which counts for next to nothing [s]."""


def car_observer(
    kind: Callable[..., Kind], vehicle: Vehicle, *, brakes: bool | None = None, **settings: Any
) -> Kind:
    """An `Ekf` or `Mhe` of the mean front wheel of a vehicle, on the force on the rack.

    Args:
        kind: `Ekf` or `Mhe`.
        vehicle: the vehicle.
        brakes: whether the brakes hold the wheels; None for what the vehicle says.
        settings: further fields of the observer, such as `tuning`.
    """
    rig, tyre = rig_of(vehicle, brakes=brakes)
    given = {
        "model": Model(),
        "values": {"k": tyre.k},
        "measurement_model": RackForce.of(vehicle, brakes=brakes),
        "tuning": tuning_for(None, car=True),
    }
    return kind(**(given | {"rig": rig} | settings))


class RackSampler:
    """Samples of the mean front wheel from the rack, for a `Loop` around a `car_observer`.

    One sampler serves one standstill: begin anew, the loop too, after the car has rolled and whenever
    the brakes are applied or released. All of a sample is of the middle of the last 60 ms, see
    `symbolic.vehicle.rack_time_derivatives`. From the torques of an assisted car,
    `symbolic.vehicle.steering` has `rack_position` and `rack_force`.

    Raises:
        InvalidInputError: the vehicle declares the handwheel's inertia, which a force on the rack does
            not hold.
    """

    def __init__(self, vehicle: Vehicle, *, brakes: bool | None = None) -> None:
        """Begin without a sample; brakes as of `car_observer`."""
        if vehicle.handwheel_inertia:
            raise InvalidInputError("handwheel_inertia is not in a force on the rack: declare 0")
        self.vehicle, self.brakes = vehicle, vehicle.brakes if brakes is None else brakes
        self._motion, self._before = RackTimeDerivatives(), nan

    def __call__(self, t: float, rack: float, force: float) -> Sample:
        """The sample that one more measurement makes known.

        Args:
            t: time, rising [s].
            rack: way of the rack, positive to the left [m]; NaN where it is missing.
            force: of the gear on the rack, positive to the left [N]; NaN where it is missing.

        Raises:
            InvalidInputError: t does not rise; the sample is left out, and the next one may come.
        """
        before = -inf if isnan(self._before) else self._before
        if not before < t < inf:
            raise InvalidInputError(f"time must rise from sample to sample, got {t} s after {before} s")
        psi, M_z = wheel_from_rack(self.vehicle, *self._motion(t, rack, force), brakes=self.brakes)
        dt, self._before = t - self._before, t
        dt = FIRST_PERIOD if isnan(dt) else dt
        return Sample(psi=float(psi), psi_dot=nan, F_N=self.vehicle.wheel_load, dt=dt, M_z=float(M_z))


def run_standstills(
    observers: Sequence[Observer], stretch: NDArray[np.int64], t: Array, psi: Array, F_N: Array,
    M_z: Array,
) -> Estimates:  # fmt: skip
    """Estimate mu over the standstills of a car; between them the last estimate is held.

    While the car rolls, its contacts forget how they were turned: each standstill begins anew, at rest.
    Held estimates have `Status.HELD` and are neither informed nor usable. Each standstill has its
    observer; `stretch` is its number for every sample, -1 for none, shape (n,). Time, angle, load and
    torque are those of the mean wheel, as for `observers.run`.

    Raises:
        InvalidInputError: as of `observers.run`; or there is no standstill.
    """
    if not (stretch >= 0).any():
        raise InvalidInputError("a car must stand at some time, stretch is nowhere 0 or more")
    rows = np.full((len(ESTIMATE), t.size), np.nan)
    rows[ESTIMATE.index("status")] = Status.HELD
    for name in ("informed", "usable"):
        rows[ESTIMATE.index(name)] = 0
    for number, observer in enumerate(observers):
        at = np.flatnonzero(stretch == number)
        if not np.isfinite(M_z[at]).any():
            continue
        part = run(observer, t[at], psi[at], F_N[at], M_z[at])
        for i, name in enumerate(ESTIMATE):
            rows[i, at] = getattr(part, name)
    begin = int(np.argmax(stretch >= 0))
    prior = getattr(observers[0], "prior", None)
    last = np.maximum.accumulate(np.where(rows[ESTIMATE.index("mu")] > 0, np.arange(t.size), 0))
    for name in HOLDING:
        row = rows[ESTIMATE.index(name)]
        row[:begin] = np.where(np.isfinite(row[:begin]), row[:begin], getattr(prior, name, np.nan))
        held = stretch < 0
        row[held] = row[last[held]]
    return as_estimates(np.asarray(t, dtype=float), rows, psi)
