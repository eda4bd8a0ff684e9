"""Friction over recordings: observers by name, their estimates, and tracks of friction to draw."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from brushgrip.estimation.friction_by_direction import (
    gated_by_single_friction,
    observer_with_single_friction,
)
from brushgrip.estimation.signal_map_remedy import name_channel_in_remedy
from brushgrip.inputs.option_choices import ObserverName
from brushgrip.inputs.option_values import ChosenTuning
from identification import FoundModel, Recording, Standstills
from identification.fits.least_squares_problem import is_first_torque_zero
from observers import (
    AligningTorque,
    DirectionalFriction,
    Ekf,
    Estimates,
    MeasurementModel,
    Mhe,
    Observer,
    RackForce,
    RootObserver,
    Sample,
    Status,
    SteeringTorque,
    Tuning,
    aligning_torque_for,
    run,
    run_standstills,
    smooth,
    tuning_for,
)
from observers.quality.when_usable import last_uncontradicted, steadily_usable_index, usable_held
from symbolic import InvalidInputError, Model, rig_of
from symbolic.float_array_type import Array

ObserverFactory = Callable[[Recording, FoundModel | None], Observer]
"""Builds the observer for a recording, on the model that a diagnosis found or (None) the declared."""
Aligning = AligningTorque | DirectionalFriction
"""How an observer of a wheel on a rig measures M_z."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionTrack:
    """The effective friction that one observer estimated over a recording; arrays of shape (n,).

    Attributes:
        name: the recording.
        label: observer and model, such as "EKF, assumed model"; tracks of one name share a panel.
        t: time [s].
        mu: estimated effective friction [1], so that tracks of different models compare.
        mu_std: its standard deviation [1]; NaN where the observer has none.
        usable: True where a controller may act on it: informed, and no flag of any kind.
        changes: instants at which the observer detected a change of the ground [s], shape (c,).
        inconsistent: True where model and stated error do not explain the torque: too small a band.
        turn: angle turned since the sample before, as in `Estimates`; None counts every sample alike.
        reference: effective friction to compare with [1], None where unknown.
        reference_label: where the reference comes from.
        last_status: of the last sample.
        usable_share: share of usable samples among those with a torque [1].
        budget: half of the 95 % band at the last usable sample by cause [1]; empty if not asked for.
    """

    name: str
    label: str
    t: Array
    mu: Array
    mu_std: Array
    usable: NDArray[np.bool_]
    changes: Array = field(default_factory=lambda: np.empty(0))
    inconsistent: NDArray[np.bool_] | None = None
    turn: Array | None = None
    reference: float | None = None
    reference_label: str = "declared μ"
    last_status: Status = Status.USED
    usable_share: float = 0.0
    budget: Mapping[str, float] = field(default_factory=dict)

    @property
    def last_usable(self) -> int | None:
        """As `observers.quality.when_usable.last_usable`."""
        return last_uncontradicted(self.usable, self.inconsistent, self._ground_begin, self.turn)

    @property
    def ends_early(self) -> bool:
        """Whether there is a last usable sample, which is not the last one."""
        return self.last_usable not in (None, self.t.size - 1)

    @property
    def usable_since(self) -> int:
        """The sample since which the last usable friction, which there has to be, was steadily so."""
        return steadily_usable_index(self.t, self.usable, self._ground_begin)

    @property
    def _ground_begin(self) -> int:
        return int(np.searchsorted(self.t, self.changes[-1])) if self.changes.size else 0


def model_observer(
    kind: type[Ekf] | type[Mhe],
    recording: Recording,
    found: FoundModel | None = None,
    *,
    tuning: Tuning | None = None,
    by_hand: Mapping[str, float] | None = None,
    aligning: Aligning | None = None,
) -> Ekf | Mhe:
    """EKF or MHE for the torque that was recorded, on the declared model, k as given, or a found one.

    The tuning, None for `real_tyre`, gets the found model's error, then what is set by hand; aligning is
    that of `observers.aligning_torque_for` where it is None.
    """
    by_direction = isinstance(aligning, DirectionalFriction)
    if found is None:
        model, values, rig = Model(), {"k": recording.tyre.k}, recording.rig
    elif recording.standstills is not None:
        raise InvalidInputError(
            "a car takes no model.json: its model is the vehicle file; leave the model out"
        )
    else:
        # A causal observer cannot know what was fitted to a whole recording, such as its torque zero.
        model = found.model
        values = found.values_for_estimation(recording.ground, tared=is_first_torque_zero(recording))
        rig = found.rig_with_k_tolerance(recording.rig, recording.tyre.k, recording.ground)
    measurement_model: MeasurementModel = SteeringTorque()
    if (car := recording.standstills) is not None:
        measurement_model = RackForce.of(car.vehicle, brakes=car.brakes[0])
    elif aligning_torque_is_measured(recording):
        measurement_model = aligning or aligning_torque_for(found)
    if aligning not in (None, AligningTorque(), measurement_model):
        option = "--by-direction" if by_direction else "--stiffness-state"
        raise InvalidInputError(f"{option} needs M_z of a wheel on a rig; leave it out")
    return kind(
        model=model, values=values, rig=rig, measurement_model=measurement_model,
        tuning=tuning_for(found, tuning, by_hand, by_direction=by_direction, car=car is not None),
    )  # fmt: skip


def root_observer_on_declared_model(
    recording: Recording, found: FoundModel | None = None, *, smoothing: float = 0.0
) -> RootObserver:
    """The root solve of [Györök 2022] for every sample, on the declared model alone."""
    if found is not None:
        raise InvalidInputError(
            "--observer root solves the declared zones and knows no effects;"
            " leave --model out, or use ekf or mhe"
        )
    if recording.standstills is not None:
        raise InvalidInputError("--observer root knows no steering gear; for a car use ekf or mhe")
    if not aligning_torque_is_measured(recording):
        raise InvalidInputError("--observer root needs M_z; from M, use ekf or mhe")
    return RootObserver(rig=recording.rig, k=recording.tyre.k, smoothing=smoothing)


def aligning_measurement_model(*, by_direction: bool, stiffness_state: bool | None) -> Aligning | None:
    """How M_z is measured by these options; None for the usual."""
    if by_direction and stiffness_state:
        raise InvalidInputError("--by-direction has no k as a state; leave --stiffness-state out")
    usual = None if stiffness_state is None else AligningTorque(stiffness=stiffness_state)
    return DirectionalFriction() if by_direction else usual


def observer_factory(
    name: ObserverName, chosen: ChosenTuning | None = None, aligning: Aligning | None = None
) -> ObserverFactory:
    """The factory of an observer with a tuning, and how it measures M_z; None for the usual ones."""
    if name is ObserverName.ROOT:
        if chosen is None and aligning is None:
            return root_observer_on_declared_model
        raise InvalidInputError(
            "--observer root has no tuning and one friction; leave these options out, or use ekf or mhe"
        )
    kind: type[Ekf] | type[Mhe] = Ekf if name is ObserverName.EKF else Mhe
    tuning, by_hand = chosen or (None, None)
    return partial(model_observer, kind, tuning=tuning, by_hand=by_hand, aligning=aligning)


def observe(
    factory: ObserverFactory,
    recording: Recording,
    found: FoundModel | None = None,
    *,
    smoothed: bool = False,
) -> Estimates:
    """Friction over a recording, sample by sample, or smoothed; see `observers.smooth`."""
    if recording.standstills is not None:
        if smoothed:
            raise InvalidInputError("--smooth is for a wheel on a rig; for a car leave it out")
        return _over_standstills(factory, recording, recording.standstills, found)
    try:
        observer = factory(recording, found)
    except InvalidInputError as error:
        remedy = name_channel_in_remedy(recording, str(error))
        raise InvalidInputError(f"{recording.name}: {remedy}") from None
    if not smoothed:
        single = observer_with_single_friction(observer)
        estimates = run(observer, **run_arguments(recording))
        # Of a model that was found the diagnosis has seen the scale; one friction may not fit it.
        if found or single is observer:
            return estimates
        return gated_by_single_friction(estimates, run(single, **run_arguments(recording)))
    if not isinstance(observer, Ekf) or isinstance(observer.measurement_model, DirectionalFriction):
        raise InvalidInputError(
            "--smooth works on the stored states of the filter; take --observer ekf, not --by-direction"
        )
    return smooth(observer, **run_arguments(recording))


def _over_standstills(
    factory: ObserverFactory, recording: Recording, standstills: Standstills, found: FoundModel | None
) -> Estimates:
    """Friction of a car, each standstill by an observer of its own."""
    of_brakes = {
        b: factory(with_mean_wheel_rig(recording, standstills, b), found) for b in standstills.brakes
    }
    return run_standstills(
        [of_brakes[brakes] for brakes in standstills.brakes], standstills.stretch, t=recording.t,
        psi=angle_nan_where_imputed(recording), F_N=recording.F_N, M_z=recording.M_z,
    )  # fmt: skip


def with_mean_wheel_rig(recording: Recording, standstills: Standstills, brakes_held: bool) -> Recording:
    """The recording of a car with its mean wheel, brakes held or not."""
    rig, tyre = rig_of(standstills.vehicle, brakes=brakes_held)
    own = replace(standstills, brakes=(brakes_held,))
    return replace(recording, rig=rig, tyre=tyre, standstills=own)


def run_arguments(recording: Recording) -> dict[str, Any]:
    """What `observers.run` takes, by name; the aligning torque where there is one."""
    channel = torque_channel_name(recording)
    return {
        "t": recording.t, "psi": angle_nan_where_imputed(recording), "F_N": recording.F_N,
        "psi_dot": recording.psi_dot if recording.psi_dot_recorded else None,
        "M_z": None, "M": None, channel: getattr(recording, channel),
    }  # fmt: skip


def mu_eff_or_mu(estimates: Estimates) -> Array:
    """Friction that compares between models: mu_eff, or mu of an observer that does not state it [1]."""
    return np.where(np.isfinite(estimates.mu_eff), estimates.mu_eff, estimates.mu)


def angle_nan_where_imputed(recording: Recording) -> Array:
    """The yaw angle as measured, NaN where it was imputed [rad]."""
    measured = True if recording.psi_recorded is None else recording.psi_recorded
    return np.where(measured, recording.psi, np.nan)


def samples_of(recording: Recording) -> Iterator[Sample]:
    """The samples of a recording as a sensor gives them, with the torque that an observer takes."""
    channel = torque_channel_name(recording)
    rate = recording.psi_dot if recording.psi_dot_recorded else np.full(recording.t.size, np.nan)
    columns = zip(
        angle_nan_where_imputed(recording).tolist(), rate.tolist(), recording.F_N.tolist(),
        np.diff(recording.t, prepend=2 * recording.t[0] - recording.t[1]).tolist(),
        np.asarray(getattr(recording, channel)).tolist(), strict=True,
    )  # fmt: skip
    return (Sample(psi=p, psi_dot=w, F_N=F, dt=dt, **{channel: m}) for p, w, F, dt, m in columns)


def aligning_torque_is_measured(recording: Recording) -> bool:
    """True where the aligning torque was measured; it is preferred to the steering torque."""
    return bool(np.isfinite(recording.M_z).any())


def torque_channel_name(recording: Recording) -> str:
    """Name of the torque that an observer takes, "M_z" or "M"."""
    return "M_z" if aligning_torque_is_measured(recording) else "M"


def friction_track(
    observer: ObserverName, recording: Recording, estimates: Estimates, model: str
) -> FrictionTrack:
    """Estimates to draw beside the declared mu; `model` says which model was used."""
    label = observer.value if observer is ObserverName.ROOT else observer.upper()
    return FrictionTrack(
        name=recording.name,
        label=f"{label}, {model}",
        t=estimates.t,
        mu=mu_eff_or_mu(estimates),
        mu_std=estimates.mu_eff_std,
        usable=usable_held(estimates),
        changes=estimates.t[estimates.status & Status.RESET != 0],
        inconsistent=(estimates.status & Status.INCONSISTENT != 0) & estimates.has_measured_torque,
        turn=estimates.turn,
        reference=recording.tyre.mu,
        last_status=Status(int(estimates.status[-1])),
        usable_share=estimates.usable_share,
    )
