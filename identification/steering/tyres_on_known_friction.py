"""Torque of full slide and stiffness of a car's tyres, from lock to lock on ground of known friction.

Full slide measures mu F_N l / r: of load, arm l of the contact and lever r only the product shows. It is
told as a factor on what the vehicle file makes of them. Over the angle in which the torque builds up,
k shows. Both, the zero, and shares of gear friction, return torque, damping and growth that the vehicle
file declares with tolerances, are one fit of the mean wheel: bounded least squares with exact
derivatives of `symbolic.Model`, see `identification.fits`.

What ground friction is wrong by, the factor is wrong by; no measurement shows it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import hypot

import numpy as np

from identification.fits.covariance import standard_deviations
from identification.fits.fitting import Fit, fit
from identification.fits.least_squares_problem import signals_of
from identification.fits.values_by_ground_and_recording import ParameterEstimate
from identification.reading.car_torques_beside_tyres import widest_standstill_less_gear
from identification.reading.car_units_and_signs import require_unclipped
from identification.reading.recordings import Recording
from symbolic import InvalidInputError, Model, full_slide_arm, simulate
from symbolic.rig_and_tyre import Tolerances
from symbolic.vehicle.mean_wheel import mu_std_by_cause
from symbolic.vehicle.vehicle import STD_PER_TOLERANCE, Vehicle, VehicleTolerances

DAMPING_TOLERANCE = 0.95
"""Of a damping that plates have not told [1]: the gear's is in it, which is not declared."""
FULL_SLIDE = 0.97
"""Share of full slide that the torque must reach to either side [1]."""
MAX_RMS = 0.07
"""Root mean square of what the fit leaves over the torque of full slide, at most [1]; 24 simulated cars
have up to 0.045."""
MODEL_ERROR = 0.025
"""Standard deviation of the factor by what the mean wheel leaves out [1]."""
STIFFNESS_ERROR = 0.09
"""The same of the stiffness, twice what it differs by between grounds [1]: an observer takes longer to
confirm a k that is declared closer."""
MAX_STIFFNESS_RATIO = 3.0
"""Stiffness over the declared one, and the reverse, at most [1]."""


@dataclass(frozen=True, kw_only=True)
class TyresResult:
    """What was identified on ground of known friction."""

    # Torque of full slide over that of the declared load, half-length and lever [1]; the tolerance of
    # the ground's friction is in its standard deviation.
    slide_factor: ParameterEstimate
    stiffness: ParameterEstimate  # Distributed lateral stiffness k of a tyre [N/m^2].
    samples: int  # Number of them that were used.
    rms: float  # Of what is left of the torque of the mean wheel [N m].
    rest: float  # The same over the torque of full slide, of the recording with the most [1].
    # Logarithm of the slide factor over its standard deviation by what the vehicle file declares without
    # a slide factor, and by the ground [1].
    deviations: float

    @property
    def parameters(self) -> dict[str, ParameterEstimate]:
        """All of them by name."""
        return {"slide_factor": self.slide_factor, "stiffness": self.stiffness}


def identify_tyres(
    recordings: Sequence[Recording], vehicle: Vehicle, *, friction: float, tolerance: float
) -> TyresResult:
    """Fit the mean wheel to recordings of a car that steers from lock to lock on one ground.

    Friction of the ground is known to the tolerance, either way [1].

    Raises:
        InvalidInputError: full slide was not reached, or what was found is not to be relied on.
    """
    if not 0 <= tolerance < friction:
        raise InvalidInputError(
            f"friction of the ground must be known to less than itself, got {friction:g} ± {tolerance:g}"
        )
    used = [_prepare_steered_standstill(one) for one in recordings]
    names = ", ".join(one.name for one in used)
    if len({one.tyre.k for one in used}) > 1:
        raise InvalidInputError(
            f"{names}: the brakes held in some, not in others, and the tyres turn about another point;"
            " identify them from recordings of one kind"
        )
    fitted = fit(Model(), used)
    stds = dict(zip(fitted.labels, standard_deviations(fitted, used), strict=True))
    frictions = np.array([fitted.values.own[one.name]["mu"] for one in used])
    factor = float(frictions.mean() / friction)
    ratio = float(fitted.values.tyre["k"] / used[0].tyre.k)
    known = (vehicle.slide_factor or 1.0) * factor
    declared_std = _checked_slide_factor_std(names, vehicle, known, ratio, friction, tolerance)
    rest = max(_checked_full_slide_rms(fitted, one) for one in used)
    of_fit = max(stds[one.name, "mu"] / m for one, m in zip(used, frictions, strict=True))
    between = float(frictions.std(ddof=1) / frictions.mean()) if len(used) > 1 else 0.0
    factor_std = hypot(of_fit, between, MODEL_ERROR, STD_PER_TOLERANCE * tolerance / friction)
    k_std = hypot(stds[None, "k"] / fitted.values.tyre["k"], STIFFNESS_ERROR)

    residuals = np.concatenate([fitted.residuals[one.name] for one in used])
    return TyresResult(
        slide_factor=ParameterEstimate(value=known, std=factor_std * known, unit="1"),
        stiffness=ParameterEstimate(
            value=ratio * vehicle.k, std=k_std * ratio * vehicle.k, unit="N/m^2"
        ),
        samples=int(np.isfinite(residuals).sum()),
        rms=float(np.sqrt(np.nanmean(residuals**2))),
        rest=rest,
        deviations=float(np.log(known) / declared_std),
    )


def _prepare_steered_standstill(recording: Recording) -> Recording:
    """The standstill with the most steering, load and lengths exact, the damping known roughly."""
    one, _ = widest_standstill_less_gear(recording)
    car = one.standstills
    if car is None:
        raise InvalidInputError(f"{recording.name}: is no recording of a car")
    require_unclipped(recording.name, car.at_limit, "full slide")
    declared = car.vehicle.tolerances.damping
    damping = declared if declared < VehicleTolerances().damping else DAMPING_TOLERANCE
    tolerances = replace(car.vehicle.tolerances, damping=damping)
    roughly = replace(car, vehicle=replace(car.vehicle, tolerances=tolerances))
    rig = replace(one.rig, tolerances=Tolerances(zero=one.rig.tolerances.zero))
    return replace(one, rig=rig, standstills=roughly)


def _checked_slide_factor_std(
    names: str, vehicle: Vehicle, factor: float, ratio: float, friction: float, tolerance: float
) -> float:
    """Standard deviation of the factor by what is declared, ground and model; they must explain it."""
    # A slide factor that was measured before is none of these: it may be what is wrong.
    before, load = "the vehicle file", vehicle.tolerances.load
    if vehicle.slide_factor is not None:
        before += f" without its slide_factor {vehicle.slide_factor:.3g}"
        # What it says now is what the load has changed by since.
        load = max(load, VehicleTolerances().load)
    declared = replace(vehicle, slide_factor=None, tolerances=replace(vehicle.tolerances, load=load))
    shares = mu_std_by_cause(declared, brakes=vehicle.brakes).values()
    most = sum(shares) / STD_PER_TOLERANCE + tolerance / friction + 3 * MODEL_ERROR
    least, greatest = np.exp([-most, most])
    if not least < factor < greatest:
        raise InvalidInputError(
            f"{names}: the torque of full slide is {factor:.2f} times that of mu {friction:g} and"
            f" {before}; allowed: {least:.2f} to {greatest:.2f}; check --ground-friction,"
            " front_axle_load and half_length, and that the wheels stand on that ground, not on plates"
        )
    if not 1 / MAX_STIFFNESS_RATIO < ratio < MAX_STIFFNESS_RATIO:
        raise InvalidInputError(
            f"{names}: the stiffness is {ratio:.2f} times that of the vehicle file; allowed: up to"
            f" {MAX_STIFFNESS_RATIO:g} times, either way; check steering_arm and stiffness"
        )
    return hypot(*shares, STD_PER_TOLERANCE * tolerance / friction, MODEL_ERROR)


def _checked_full_slide_rms(fitted: Fit, recording: Recording) -> float:
    """Rms of what is left over the torque of full slide [1], which has to be reached and explained."""
    values = fitted.values.of(recording)
    rig, slide = recording.rig, values["mu"] * float(np.median(recording.F_N))
    slide *= float(full_slide_arm(rig.a, rig.e))
    theta = np.asarray(Model().theta(values)).ravel()
    M_z = simulate(Model(), signals_of(recording), theta, np.array([rig.a, rig.e])).M_z
    reached = min(M_z.max(), -M_z.min()) / slide
    if not reached > FULL_SLIDE:
        raise InvalidInputError(
            f"{recording.name}: the torque reaches {100 * reached:.0f} % of full slide to one side;"
            f" allowed: from {100 * FULL_SLIDE:.0f} % on; turn from lock to lock"
        )
    left = float(np.sqrt(np.nanmean(fitted.residuals[recording.name] ** 2))) / slide
    if not left < MAX_RMS:
        raise InvalidInputError(
            f"{recording.name}: {100 * left:.1f} % of the torque of full slide is left unexplained;"
            f" allowed: up to {100 * MAX_RMS:.0f} %; brushgrip diagnose --vehicle finds what is missing"
        )
    return left
