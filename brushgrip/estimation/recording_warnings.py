"""What looks wrong with a recording, in words: its inputs, the noise of its torque, and its rates."""

from collections.abc import Mapping, Sequence
from itertools import islice
from math import exp, hypot, isfinite, nan

import numpy as np
from numpy.typing import NDArray

from brushgrip.estimation.friction_by_direction import observer_with_single_friction
from brushgrip.estimation.observe_recording import (
    ObserverFactory,
    aligning_torque_is_measured,
    angle_nan_where_imputed,
    samples_of,
    torque_channel_name,
    with_mean_wheel_rig,
)
from brushgrip.estimation.signal_map_remedy import TIME, causes_with_map
from brushgrip.wording.formatting import band_decimals
from brushgrip.wording.friction_in_words import LACKING, LACKING_STILL, MIN_REPORTED_SHARE
from identification import FoundModel, Recording
from identification.reading.declared_sensor_range import (
    drop_torques_beyond_range,
    max_measurable_friction,
    share_beyond_range,
)
from identification.reading.undeclared_sensor_limit import detect_saturation
from identification.residuals.residual_structure import white_noise_std
from observers import Ekf, Estimates, Loop, Mhe, Observer, Status, suspicions_of
from observers.estimates import BAND_STDS
from observers.protocol import MAX_SAMPLE_PERIOD, UNINFORMED
from observers.quality.mu_and_scale_from_hypotheses import VERDICT
from observers.tuning import REFERENCE_STEP
from symbolic.effects.asymmetric_friction import ASYMMETRY_RATIO, weaker_share_below_mean
from symbolic.float_array_type import Array

SUSPECTED = "an input looks wrong, so that the result may be void"
"""How the note on it begins in a diagnosis."""
MAY_END = "the sensor may end"
"""How the note begins in a diagnosis where the torque seems to end by its sensor."""
CLEARLY_OFF = 3.0
"""Deviations of ln s from which on the slope, not too little turn, is why mu is not known [1]."""
MAX_REPLAYED_SAMPLES = 20_000
"""Samples that go through the observer once more, one by one."""


def implausibility_lines(recordings: Sequence[Recording]) -> list[str]:
    """A line for each recording that looks like one in other units, or of the other sign."""
    lines = []
    for recording in map(drop_torques_beyond_range, recordings):
        channel, apart = torque_channel_name(recording), float(np.median(np.diff(recording.t)))
        causes: Sequence[str] = [f"{TIME} or less: samples are {apart:g} s apart"]
        if apart <= MAX_SAMPLE_PERIOD:
            causes = suspicions_of(samples_of(recording), recording.rig, channel)
        if suspects := causes_with_map(recording, causes, channel):
            lines.append(f"{recording.name}: {suspects}")
    return lines


def doubtful_inputs(recordings: Sequence[Recording]) -> dict[str, str]:
    """Those lines, and one where a torque seems to end by its sensor, each with its note."""
    noted = {line: f"{SUSPECTED}: {line}" for line in implausibility_lines(recordings)}
    ends = [f"{r.name}: {end}" for r in recordings if (end := suspected_range_note(r))]
    return noted | {line: f"{MAY_END}: {line}" for line in ends}


def suspected_cause(
    factory: ObserverFactory, recording: Recording, found: FoundModel | None, estimates: Estimates
) -> str:
    """The cause of `Status.SUSPECT` with what mends it; empty where nothing is suspected."""
    flagged = np.flatnonzero(estimates.status[:MAX_REPLAYED_SAMPLES] & Status.SUSPECT)
    if flagged.size <= MIN_REPORTED_SHARE * estimates.t.size:
        return ""
    loop = _replayed_control_loop(
        observer_with_single_friction(factory(recording, found)), recording, 0, int(flagged[-1])
    )
    return causes_with_map(recording, loop.suspicions, torque_channel_name(recording))


def why_not_acquired(observer: Observer, recording: Recording, estimates: Estimates) -> str:
    """Why friction was still being acquired at the end, with a remedy; empty where something else was.

    That needs a mu that is known, and a slope of the torque that the tolerance of k allows.
    """
    status = Status(int(estimates.status[-1])) & (UNINFORMED | Status.INCONSISTENT)
    observer = observer_with_single_friction(observer)
    if status != Status.ACQUIRING or not isinstance(observer, Ekf | Mhe):
        return ""
    last = min(estimates.t.size, MAX_REPLAYED_SAMPLES) - 1
    loop = _replayed_control_loop(observer, recording, 0, last)
    verdict = dict(zip(VERDICT, np.ravel(loop.state["verdict"]).tolist(), strict=True))
    off = hypot(verdict["var_log_gain"] ** 0.5, observer.effective_tuning.error)
    if verdict["verified"] or abs(verdict["log_gain"]) <= CLEARLY_OFF * off:
        return "turned too little: turn on, or turn back once; else check the torque's unit and gear"
    k, others = "k", "a and F_N"
    if recording.standstills is not None:
        k, others = "stiffness", "half_length and front_axle_load"
    return (
        f"{k} does not fit: the torque rises {exp(verdict['log_gain']):.2g} times as steeply as {k},"
        f" {others} say; correct {k} or its tolerance, or check the torque's unit and gear"
    )


def car_force_slope_note(factory: ObserverFactory, recording: Recording, at: int) -> str:
    """That a car's force rises otherwise than declared, up to sample `at`; empty if not clearly so."""
    if (car := recording.standstills) is None:
        return ""
    number = int(car.stretch[at])
    held = with_mean_wheel_rig(recording, car, car.brakes[number])
    observer, first = factory(held, None), int(np.argmax(car.stretch == number))
    if not isinstance(observer, Ekf | Mhe):
        return ""
    loop = _replayed_control_loop(observer, held, max(first, at - MAX_REPLAYED_SAMPLES), at)
    verdict = dict(zip(VERDICT, np.ravel(loop.state["verdict"]).tolist(), strict=True))
    slope, variance = exp(verdict["log_gain"]), verdict["var_log_gain"]
    known = observer.effective_tuning.stiffness_std
    if abs(verdict["log_gain"]) < 2 * hypot(known, variance**0.5):
        return ""
    way, causes = "low", "suspension, column or tyres yield, or the contact is shorter"
    if slope > 1:
        way, causes = "high", "the tyres are stiffer, or the contact is longer"
    return (
        f"the force rises about {slope:.2g} times as steeply as declared: {causes}, or the force reads"
        f" too {way} (unit, motor_ratio), and friction is told too {way} by up to that factor"
    )


def _replayed_control_loop(observer: Observer, recording: Recording, first: int, last: int) -> Loop:
    """The loop of an observer after these samples of a recording."""
    loop = Loop(observer)
    for sample in islice(samples_of(recording), first, last + 1):
        loop(sample)
    return loop


def hardly_turned_note(recording: Recording) -> str:
    """That the wheel turned too little for anything but ice to slide; empty where it did."""
    turn, seconds = np.ptp(recording.psi), np.ptp(recording.t)
    told = f"the wheel hardly turned: by {turn:.2g} rad in {seconds:.2g} s;"
    return f"{told} on dry ground it slides after 0.05 rad" * bool(turn < LEAST_TURN)


BEYOND, LEAST_TURN = 1.5, 0.02
"""Noise seen over noise stated from which on it is told, and residual over its white noise [1]; range
of the angle below which nothing but ice slides [rad]."""
OTHER_RATE, REGULAR = 1.5, 0.9
"""Ratio of two rates that differ [1]; share of the periods that are alike in a rate [1]."""
OUTSIDE, SELDOM = 0.1, 0.1
"""Share by which a load is beyond those behind a model from which on it is told [1]: friction is wrong
by the share that a load is, and a tenth is what a band at least reaches; share of the samples that may
be beyond, untold [1]."""
FULL_SLIDE = 3 / 8
"""Torque of full slide at mu = 1 over F_N a [1]."""


def inconsistency_remedy(
    observer: Observer, recording: Recording, estimates: Estimates, *, of_found: bool = False
) -> str:
    """What mends an aligning torque that model and stated error do not explain; empty if not known.

    Noise is advised where the residual is white, else a diagnosis, with this recording if the model is
    of one. It is that from sample to sample while the wheel turns slower than half of the time, of as
    many samples as 10 ms have.
    """
    lacking = LACKING_STILL if of_found else LACKING
    of_rig = recording.standstills is None and aligning_torque_is_measured(recording)
    if not (of_rig and isinstance(observer, Ekf | Mhe)):
        return ""
    innovation, inconsistent = recording.M_z - estimates.M_z_predicted, Status.INCONSISTENT
    known = np.isfinite(recording.M_z)
    residual = np.where(estimates.status & inconsistent, innovation, np.nan)[known]
    shown = np.abs(residual[np.isfinite(residual)])
    if shown.size and np.median(shown) / 0.6745 > BEYOND * white_noise_std(residual) > 0:
        if of_found and observer_with_single_friction(observer) is not observer:
            return f"leave --by-direction out, or {lacking}; more noise would not explain it"
        return f"{lacking}; more noise would not explain it"
    rate = np.abs(recording.psi_dot[known])
    seen = white_noise_std(np.where(rate <= np.median(rate), recording.M_z[known], np.nan))
    seen *= min(1.0, float(np.median(np.diff(recording.t[known])) / REFERENCE_STEP)) ** 0.5
    rig = recording.rig
    slide = FULL_SLIDE * float(np.median(recording.F_N)) * rig.a
    stated = observer.tuning.noise * slide if rig.noise is None else rig.noise
    if seen <= BEYOND * stated:
        return ""
    against = "none declared" if rig.noise is None else f"{stated:.2g} declared"
    return (
        f"torque noise seen {seen:.2g} N m, {against}: declare [sensor] noise = {seen:.2g}"
        f" in the rig file; where that does not help, {lacking}"
    )


def load_outside_model_note(F_N: Array, loads: tuple[float, float] | None) -> str:
    """That loads [N], NaN where missing, are outside those behind a model; empty if not, or unknown."""
    known = F_N[F_N > 0]
    if loads is None or not known.size:
        return ""
    (least, greatest), (low, high) = loads, np.quantile(known, (SELDOM, 1 - SELDOM))
    if least * (1 - OUTSIDE) <= low and high <= greatest * (1 + OUTSIDE):
        return ""
    own = " to ".join(dict.fromkeys((f"{low:.0f}", f"{high:.0f}")))
    return (
        f"load more than a tenth outside the model's: {own} N, found at {least:.0f} to {greatest:.0f} N;"
        " friction is off by the share that the load is: check it; where it is right, half-length, k and"
        " effects may be others here: diagnose with a recording at this load"
    )


def constant_load_note(recording: Recording) -> str:
    """That the load never changes, as no measured one does; empty if it does, or has a tolerance."""
    known = recording.standstills is not None or recording.rig.tolerances.load is not None
    told = (
        f"load the same in every sample, as if it was not measured: {recording.F_N[0]:.4g} N; friction"
        " is off by the share that this is: weigh it, and declare [rig] load = { tolerance = ... }"
    )
    return told * bool(not known and np.ptp(recording.F_N) == 0)


def direction_deficit_and_note(
    values: Mapping[str, float], mu_eff: float = nan, mu_eff_std: float = nan
) -> tuple[float, str]:
    """Share of mu_eff that the weaker direction of a found model holds less; in words from 1 % on.

    They tell the lower end of its 95 % band where mu_eff and its standard deviation [1] are given.
    """
    below = weaker_share_below_mean(values)
    told = f"{100 * below:.0f} % less than mu_eff turning to "
    told += f"{'positive' if values.get(ASYMMETRY_RATIO, 1.0) < 1 else 'negative'} psi"
    if isfinite(mu_eff + mu_eff_std):
        half = BAND_STDS * mu_eff_std
        low = max(0.0, mu_eff * (1 - below) - half)
        told += f", down to {low:.{band_decimals(half)}f}"
    told += ": friction differs by direction, mu_eff and M_slide are the mean of both"
    return below, told * bool(below >= MIN_REPORTED_SHARE)


def range_reached_note(recording: Recording) -> str:
    """That the torque reached its sensor's range, and what follows; empty if not, or none is known."""
    share = share_beyond_range(recording)
    if share <= MIN_REPORTED_SHARE:
        return ""
    return (
        f"torque at its sensor's range, {recording.rig.range:g} N m, left out: in {100 * share:.0f} % of"
        f" the samples; friction above {max_measurable_friction(recording):.2f} cannot be told with this"
        " sensor at this load"
    )


def suspected_range_note(recording: Recording) -> str:
    """That the sensor of the torque seems to end, where no range is declared; empty if it does not."""
    if recording.standstills is not None or recording.rig.range is not None:
        return ""
    return torque_saturation_note(recording.aligning_or_steering_torque, recording.psi, recording.F_N)


def torque_saturation_note(torque: Array, psi: Array, F_N: Array) -> str:
    """That a torque seems to end by its sensor, arguments as of `detect_saturation`; empty if not."""
    if (end := detect_saturation(torque, psi, F_N)) is None:
        return ""
    return (
        f"the torque seems to end at {end.torque:.2g} N m by its sensor, not by the ground: {end.sign};"
        " friction may be higher than told: declare up to where the sensor is straight ([sensor] range)"
    )


def differing_sample_rates_note(recording: Recording) -> str:
    """The rates of torque and angle where both are regular and differ; empty where they do not."""
    measured = (recording.aligning_or_steering_torque, angle_nan_where_imputed(recording))
    rates = [_rate(recording.t[np.isfinite(values)]) for values in measured]
    if min(rates) <= 0 or max(rates) < OTHER_RATE * min(rates):
        return ""
    return f"torque at {rates[0]:.4g} Hz, angle at {rates[1]:.4g} Hz: normal"


def _rate(t: NDArray[np.float64]) -> float:
    """Samples a second [Hz]; 0 where their periods differ."""
    periods = np.diff(t)
    if not periods.size:
        return 0.0
    period = float(np.median(periods))
    alike = np.abs(periods - period) < period / 2
    return 1 / period if alike.mean() >= REGULAR else 0.0
