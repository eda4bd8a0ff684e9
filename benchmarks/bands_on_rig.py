"""Bands of mu_eff on the independent rig where effects act that nobody declares, or that were found."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import product

import numpy as np

from identification.fits.autocorrelation import autocorrelation_time
from observers import PROFILES, AligningTorque, Ekf, Status, causal_rate, run, tuning_for
from reference_rig import (
    OTHER_LAWS,
    RIG_EFFECTS,
    UNMODELLED_EFFECTS,
    RigDrive,
    RigRecording,
    build_effects,
    full_slide_moment,
    make_recording,
    plant_effect,
    simulate_bristles,
)
from symbolic import (
    FoundModel,
    Model,
    ModelError,
    Rig,
    effects_named,
    full_slide_torque,
    simulate,
)
from symbolic.float_array_type import Array

RATE, SECONDS = 0.1, 25.0
"""Full slide of which mu_eff is the torque [rad/s], [s]."""
NOT_OF_THE_GROUND = {
    "bearing_friction", "steering_return", "torque_offset", "sensor_delay", "pretwist", "gust",
    "slide_oscillation", "backlash", "play", "friction_drift",
}  # fmt: skip
"""Effects whose torque is not the ground's, or that pass; the drift is counted by its own law."""
STAYS = replace(PROFILES["clean"], mu_walk=0.0, zero_walk=0.0)
"""On the rig neither the ground nor the zero of the torque drifts, and the half-length is known."""
OWN = ("torque_offset", "pretwist", "tared_pretwist", "zero_drift")
"""Effects whose parameters belong to one recording: nobody knows them for the next."""


def true_friction(recording: RigRecording) -> Array:
    """mu_eff of a recording [1], shape (n,): half the difference of two long slides on the rig."""
    planted = {n: p for n, p in recording.effects.items() if n not in NOT_OF_THE_GROUND}
    t, F_N = np.arange(0, SECONDS, 0.02), float(np.mean(recording.F_N_true))
    ends = []
    for rate in (RATE, -RATE):
        drive = RigDrive(
            t=t, psi=rate * t, psi_dot=np.full_like(t, rate), F_N=np.full_like(t, F_N), psi_virgin=0.0
        )
        history = simulate_bristles(drive, recording.tyre, build_effects(planted), bristles=300)
        ends.append(history.M_z[-1])
    level = (ends[1] - ends[0]) / 2 / full_slide_moment(recording.tyre, F_N)
    drift = recording.effects.get("friction_drift", {"gain": 0.0, "scale": 1.0})
    travel = np.cumsum(np.abs(np.diff(recording.psi_true, prepend=recording.psi_true[0])))
    return np.asarray(level * (1 + drift["gain"] * (1 - np.exp(-travel / drift["scale"]))))


def judged(observer: Ekf, recording: RigRecording, *, own: bool = False) -> tuple[float, bool]:
    """Share of the informed samples whose 95 % band holds the truth, and whether any is flagged.

    The truth is that of mu_eff, or that of the model's own mu.
    """
    estimates = run(observer, recording.t, recording.psi, recording.F_N, recording.M_z)
    mu, std = (estimates.mu, estimates.mu_std) if own else (estimates.mu_eff, estimates.mu_eff_std)
    error = np.abs(mu - (recording.tyre.mu if own else true_friction(recording)))
    error, band = error[estimates.informed], 1.96 * std[estimates.informed]
    covered = float(np.mean(error < band)) if error.size else 1.0
    return covered, bool(np.any(estimates.status & Status.INCONSISTENT))


def _declared(task: tuple[str | None, int]) -> tuple[float, bool]:
    name, seed = task
    recording = plant_effect(name, seed)
    tyre = recording.tyre
    observer = Ekf(model=Model(), values={"k": tyre.k}, rig=Rig(a=tyre.a, e=tyre.e))
    return judged(observer, recording)


def undeclared_effects(runs: int) -> None:
    """The declared model and the usual tuning, effects in turn; then nothing planted."""
    seeds = range(-(-runs // len(RIG_EFFECTS)))
    tasks: list[tuple[str | None, int]] = list(product(RIG_EFFECTS, seeds))
    controls: list[tuple[str | None, int]] = [(None, 1000 + seed) for seed in range(runs)]
    print(f"\nundeclared effects, declared model, real_tyre: {len(tasks)} runs")
    with ProcessPoolExecutor() as pool:
        outcomes = list(pool.map(_declared, tasks, chunksize=4))
        for name in RIG_EFFECTS:
            of = [o for (n, _), o in zip(tasks, outcomes, strict=True) if n == name]
            right = np.mean([flagged or covered >= 0.9 for covered, flagged in of])
            means = np.mean(of, axis=0)
            print(f"{name:26} covered {means[0]:.2f}  flagged {means[1]:.2f}  right {right:.2f}")
        right = [flagged or covered >= 0.9 for covered, flagged in outcomes]
        print(f"flagged or covered: {sum(right)} of {len(right)}", flush=True)
        quiet = list(pool.map(_declared, controls, chunksize=4))
    print(
        f"nothing planted: {sum(flagged for _, flagged in quiet)} of {len(quiet)} flagged, covered"
        f" {np.mean([covered for covered, _ in quiet]):.3f}",
        flush=True,
    )


def found_model(name: str, recording: RigRecording, values: dict[str, float]) -> FoundModel:
    """The model with the planted effect, and its error on another recording of the same tyre."""
    model = Model(effects=effects_named([name]))
    rates = causal_rate(recording.t, recording.psi)
    steps = np.diff(recording.t, prepend=2 * recording.t[0] - recording.t[1])
    theta = np.asarray(model.theta({**values, "mu": recording.tyre.mu})).ravel()
    geometry = np.array([recording.tyre.a, recording.tyre.e])
    torque = simulate(model, np.vstack([recording.psi, rates, recording.F_N, steps]), theta, geometry)
    share = (torque.M_z - recording.M_z) / full_slide_torque(recording.F_N, recording.tyre.a)
    time = autocorrelation_time(share) * float(np.median(steps))
    error = ModelError(spread=float(np.sqrt(np.mean(share**2))), correlation_time=time)
    return FoundModel(model=model, tyre=values, own={}, error=error)


def _found(task: tuple[str, int]) -> tuple[float, bool]:
    name, seed = task
    recording = plant_effect(name, seed)
    planted, tyre = recording.effects[name], recording.tyre
    values = {"k": tyre.k, **{f"{name}.{p}": v for p, v in planted.items()}}
    # Another path and another noise of the same tyre and effect.
    other = make_recording(seed + 500, recording.effects, **vars(tyre), bristles=800)
    found = found_model(name, other, values)
    observer = Ekf(
        model=found.model, values=found.values_for_estimation(), rig=Rig(a=tyre.a, e=tyre.e),
        measurement_model=AligningTorque(stiffness=True), tuning=tuning_for(found, STAYS),
    )  # fmt: skip
    return judged(observer, recording, own=True)


def found_models(runs: int) -> None:
    """The model that was found, tuned by its own error, without a floor: the rig's a is known."""
    beyond = {*UNMODELLED_EFFECTS, *OTHER_LAWS, *OWN}
    names = [n for n in RIG_EFFECTS if n not in beyond]
    tasks = list(product(names, range(-(-runs // len(names)))))
    print(f"\nthe model found: {len(tasks)} runs")
    with ProcessPoolExecutor() as pool:
        outcomes = list(pool.map(_found, tasks))
    for name in names:
        of = [o for (n, _), o in zip(tasks, outcomes, strict=True) if n == name]
        print(f"{name:26} covered {np.mean(of, axis=0)[0]:.3f}  flagged {np.mean(of, axis=0)[1]:.2f}")
    print(f"covered {np.mean(outcomes, axis=0)[0]:.3f}", flush=True)
