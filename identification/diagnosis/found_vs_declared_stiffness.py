"""The stiffness that was found beside the declared one, and what it says of friction."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from identification.fits.fitting import AT_BOUND, Fit
from identification.reading.car_as_mean_wheel import Standstills
from identification.reading.car_torques_beside_tyres import JACKING
from identification.reading.recordings import Recording
from symbolic import USUAL, InvalidInputError
from symbolic.tables.found_model import has_implausible_stiffness
from symbolic.vehicle.contact_about_kingpin import contact_growth_at_full_lock
from symbolic.vehicle.steering import OF_LOCK, inclination_for_return_torque, jacking_torque, lock_angle

OFF_STIFFNESS = "the fitted stiffness k is"
"""How the note on k beyond its tolerance begins."""


@dataclass(frozen=True, kw_only=True)
class StiffnessComparison:
    """The stiffness found beside the declared one, of the recording where it is farthest from that.

    Attributes:
        found: in the model found [N/m^2].
        declared: in the rig or vehicle file [N/m^2].
        tolerance: of the declared one [N/m^2].
        assumed: whether nobody declared the tolerance.
        several: whether recordings have several, as of grounds.
    """

    found: float
    declared: float
    tolerance: float
    assumed: bool
    several: bool = False

    @property
    def ratio(self) -> float:
        """The stiffness found over the declared one [1]; 1 within its tolerance."""
        within = max(self.tolerance, AT_BOUND * self.declared)
        return self.found / self.declared if abs(self.found - self.declared) > within else 1.0


def compare_stiffness(k: float, recording: Recording) -> StiffnessComparison:
    """A found stiffness [N/m^2] beside that of a recording, with the usual tolerance for none."""
    declared, tolerance = recording.tyre.k, recording.rig.tolerances.k
    assumed = tolerance is None
    known = USUAL["k"] * declared if tolerance is None else tolerance
    return StiffnessComparison(found=float(k), declared=declared, tolerance=known, assumed=assumed)


def compare_fitted_stiffness(fitted: Fit, recordings: Sequence[Recording]) -> StiffnessComparison:
    """That of these recordings."""
    known = dict.fromkeys(compare_stiffness(fitted.values.of(one)["k"], one) for one in recordings)
    farthest = max(known, key=lambda one: abs(float(np.log(one.found / one.declared))))
    return replace(farthest, several=len(known) > 1)


def farthest_stiffness_ratio(fitted: Fit, recordings: Sequence[Recording]) -> float:
    """That of these recordings which is farthest from 1 either way [1]."""
    ratios = [compare_stiffness(fitted.values.of(one)["k"], one).ratio for one in recordings]
    return max(ratios, key=lambda ratio: max(ratio, 1 / ratio))


def stiffness_note(k: float, recording: Recording) -> str:
    """What a found stiffness [N/m^2] beyond the tolerance of the declared one means; empty within.

    Before anything slides the torque goes with k a (a^2 + 3 e^2), in full slide with mu and an arm that
    grows no faster than a. So a wrong a moves mu by the cube root of the ratio of k at most. What is in
    series with a car's tyres lowers k, and leaves full slide as it is.
    """
    ratio, declared = compare_stiffness(k, recording).ratio, recording.tyre.k
    if ratio == 1:
        return ""
    factor = max(ratio, 1 / ratio)
    off = f"{100 * abs(ratio - 1):.0f} % {'above' if ratio > 1 else 'below'}"
    high, low, long, soft, fast = "low", "high", "long", "soft", "slower"
    if ratio > 1:
        high, low, long, soft, fast = "high", "low", "short", "stiff", "faster"
    torque, where, like = "torque", "unit, gear ratio between sensor and wheel", "the tyre is"
    if recording.standstills is not None:
        torque, where = "force", "unit, motor_ratio"
        like = "the tyres are" if ratio > 1 else "suspension, column or tyres are"
    note = (
        f"{OFF_STIFFNESS} {k / 1e6:.3g}·10⁶ N/m², {off if 0.1 < ratio < 2 else f'{ratio:.2g} times'} the"
        f" declared {declared / 1e6:.3g}·10⁶: if the {torque} reads too {high} ({where}),"
        f" friction is told too {high} by as much, a factor of about {factor:.2f} if nothing else is"
        f" wrong; if the declared half-length of the contact is too {long}, by a factor of"
        f" {factor ** (1 / 3):.2f} at most; if {like} really so {soft}, friction is as told; if the"
        f" angle reads too {low}, friction is that of {fast} turning"
    )
    refused = has_implausible_stiffness(k, declared, recording.rig.tolerances.k)
    return f"{note} (estimate refuses this model)" if refused else note


def kingpin_inclination_note(
    car: Standstills, stiffness: float, std: float, share: float
) -> tuple[str, float | None]:
    """What a stiffness [N m/rad] beside this share of the declared return torque says of the kingpin.

    Then the inclination that makes it [rad], None where the declared one may.
    """
    vehicle, angle = car.vehicle, OF_LOCK * lock_angle(car.vehicle)
    growth = contact_growth_at_full_lock(vehicle, brakes=car.brakes[0]).torque * np.sin(angle) ** 2
    if not (declared := float(jacking_torque(vehicle, angle))):
        return "the declared kingpin makes no return torque: declare its inclination", None
    by_stiffness = angle * (1 + growth) / declared
    factor, band = share + stiffness * by_stiffness, 2 * std * abs(by_stiffness)
    note = f"{factor:.2f} ± {band:.2f} times the declared return torque, known to ± {2 * JACKING:.0%}"
    if abs(factor - 1) <= 2 * JACKING:
        return f"{note}: within its tolerance, declare nothing", None
    note = f"{note}: beyond its tolerance"
    try:
        inclination = round(inclination_for_return_torque(vehicle, factor), 3)
    except InvalidInputError as error:
        return f"{note}; {error}", None
    return f"{note}; inclination = {inclination:.3f} in the vehicle file makes it", inclination
