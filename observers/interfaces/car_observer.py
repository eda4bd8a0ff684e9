"""An observer of a car: from its vehicle, and over the standstills of a recording."""

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from observers.estimates import Estimates
from observers.estimators.model_observer import ModelObserver
from observers.interfaces.run import as_estimates, run
from observers.interfaces.tuning_profiles import tuning_for
from observers.measurement.rack_force import RackForce
from observers.protocol import ESTIMATE, Observer, Status
from symbolic import InvalidInputError, Model
from symbolic.array_alias import Array
from symbolic.vehicle.mean_wheel import rig_of
from symbolic.vehicle.vehicle import Vehicle

Kind = TypeVar("Kind", bound=ModelObserver)
HOLDING = ("mu", "mu_std", "mu_eff", "mu_eff_std", "M_slide")
"""Values that are held while the car rolls."""


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


def run_standstills(
    observers: Sequence[Observer],
    stretch: NDArray[np.int64],
    t: Array,
    psi: Array,
    F_N: Array,
    M_z: Array,
) -> Estimates:
    """Estimate mu over the standstills of a car; between them the last estimate is held.

    While the car rolls, its contacts forget how they were turned: each standstill begins anew, at rest.
    Held estimates have `Status.HELD` and are neither informed nor usable.

    Args:
        observers: of each standstill.
        stretch: number of the standstill that a sample belongs to, -1 for none, shape (n,).
        t: time [s]; this and the following as for `observers.run`.
        psi: angle of the mean wheel [rad].
        F_N: its load [N].
        M_z: its torque [N m].

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
