"""Is low friction seen as low, and is anything usable and wrong? Seeded runs on the rig.

    python benchmarks/ice.py --runs 400

mu is log-uniform in 0.02 to 2, 4 to 15 s by hand; the truth of half-length, load, k and the torque's
zero is drawn from the tolerances that an observer reckons with where the rig file declares none. Per
band of mu: coverage of the 95 % band over usable samples; runs in which more than 1 % of the samples
are usable and beyond three deviations; median deviation over mu after 0.3 rad of travel; median travel
until the first usable sample; share of usable samples; runs that never have one. With --effects an
effect of the rig moves the torque by 5 % of its range: the observer has the declared model, or that
with the effect. --effect names one in place of these, such as backlash.
"""

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.bands_on_rig import true_friction
from observers import (
    PROFILES,
    AligningTorque,
    Ekf,
    Estimates,
    Mhe,
    SteeringTorque,
    Tuning,
    run,
)
from observers.measurement.measurement_model import GAIN_SHARE, MeasurementModel
from observers.quality.mu_and_scale_from_hypotheses import GAIN_FREE
from observers.tuning import REFERENCE_STEP, tuning_with_tolerances
from reference_rig import (
    Hand,
    RigTyre,
    Wheel,
    constant_friction,
    make_recording,
    make_steering_recording,
    plant_effect,
)
from symbolic import Model, Rig, effects_named

BANDS = ((0.02, 0.05), (0.05, 0.1), (0.1, 0.3), (0.3, 1.0), (1.0, 2.0))
"""Bands of mu, drawn in turn [1]."""
RIG, K = Rig(a=0.045, e=0.009, J_A=Wheel().J_A, b_t=Wheel().b_t), 2.4e6
OFF = {"a": 0.002, "load": 0.02, "k": 0.2, "zero": 0.03, "e": 0.002}
"""How far off half-length and caster [m], load and k [1], and the zero over 3/8 F_N a [1] may be."""
EFFECTS = (
    "rate_friction", "carcass_torsion", "patch_width", "pressure_shape", "stribeck",
    "viscoelastic_relaxation", "asymmetric_friction",
)  # fmt: skip
MIN_TURN = 1e-9
"""Turn that counts as none [rad]."""
FIRST_SEED = 100_000
"""Seeds below 10,000 were used to choose constants."""
TRAVEL = 0.3
"""Travel after which the deviation is stated [rad]."""
KINDS = {"ekf": Ekf, "mhe": Mhe}
TORQUES: dict[str, MeasurementModel] = {"M_z": AligningTorque(), "M": SteeringTorque()}
"""How friction is measured, by the torque's name."""
STEERING_RATE = 500.0
"""Samples of a steering torque a second [Hz]."""


@dataclass(frozen=True, kw_only=True)
class IceCase:
    """What is run: observer, torque, tuning, effects (none, declared, found), stated errors, effect."""

    observer: str = "ekf"
    torque: str = "M_z"
    tuning: str = "real_tyre"
    effects: str = "none"
    stated: bool = False
    effect: str = ""


@dataclass(frozen=True, kw_only=True)
class IceOutcome:
    """One run: true friction, and what its usable samples are worth."""

    mu: float
    held: int
    usable: int
    beyond: float
    share: float
    deviation: float
    travel: float


def outcome(task: tuple[IceCase, int]) -> IceOutcome:
    """One run of a case."""
    case, seed = task
    rng = np.random.default_rng([seed, 777])
    mu = float(np.exp(rng.uniform(*np.log(BANDS[seed % len(BANDS)]))))
    a, k = RIG.a + _even(rng, "a"), K * (1 + _even(rng, "k"))
    late = np.random.default_rng([seed, 778])
    stiffness_std = tuning_with_tolerances(Tuning(), RIG, K).stiffness_std
    gain = 1 + case.stated * gain_error(late, k / K - 1, stiffness_std)
    k /= gain
    tyre = RigTyre(a=a, e=RIG.e + case.stated * _even(late, "e"), k=k, mu=mu)
    load, duration = float(rng.uniform(250, 600)), float(rng.uniform(4, 15))
    factor, zero = 1 + _even(rng, "load"), _even(rng, "zero") * 0.375 * load * RIG.a
    pace = float(np.exp(rng.uniform(*np.log([0.1, 0.35]))))
    hand = Hand(pace=pace, amplitude=float(rng.uniform(0.25, 0.5)))
    model, values, truth = Model(), {"k": K}, np.array(mu)
    settings = {"tuning": PROFILES[case.tuning], "measurement_model": TORQUES[case.torque]}
    made: Any
    if case.torque == "M":
        made = make_steering_recording(
            seed, constant_friction(mu), tyre=tyre, load=load, duration=min(duration, 8.0),
            rate=STEERING_RATE,
        )  # fmt: skip
        columns = {"M": made.M + zero}
    elif case.effects != "none":
        name = case.effect or EFFECTS[seed % len(EFFECTS)]
        made = plant_effect(name, seed, tyre=tyre, load=load, duration=duration, share=0.05)
        columns, truth = {"M_z": made.M_z + zero}, true_friction(made)
        if case.effects == "found":
            model = Model(effects=effects_named([name]))
            settings["measurement_model"] = AligningTorque(stiffness=True)
            values |= {f"{name}.{p}": v for p, v in made.effects[name].items()}
    else:
        made = make_recording(seed, **vars(tyre), load=load, duration=duration, hand=hand, bristles=600)
        columns = {"M_z": made.M_z + zero}
        if case.stated:
            columns["M_z"] = _stated(late, gain * made.M_z, made.psi, load, PROFILES[case.tuning]) + zero
    observer = KINDS[case.observer](model=model, values=values, rig=RIG, **settings)
    estimates = run(observer, made.t, made.psi, made.F_N * factor, **columns)
    return _judged(estimates, made.psi, truth, mu)


def gain_error(rng: np.random.Generator, off: float, std: float) -> float:
    """How far off the torque's gain is [1], as an observer reckons with where k is off by so much [1].

    `std` is the deviation of k that it was told [1].
    """
    return GAIN_SHARE * max(0.0, abs(off) - GAIN_FREE * std) * float(rng.standard_normal())


def error_kept(turned: Any, tuning: Tuning) -> Any:
    """Correlation of the model's error with that before a turn [rad], [1]."""
    return np.exp(-2 * turned / max(tuning.error_travel, MIN_TURN))


def _stated(rng: np.random.Generator, M_z: Any, psi: Any, load: float, tuning: Tuning) -> Any:
    """The torque [N m] with the errors that the tuning states: of the model, noise, and the zero's walk.

    The model's error is a share of the torque and follows the turn of the wheel: an autoregression of
    which `error_travel` is worth one independent sample.
    """
    slide = 0.375 * load * RIG.a
    white = rng.standard_normal((3, psi.size))
    kept = error_kept(np.abs(np.diff(psi, prepend=psi[0])), tuning)
    error = white[0]
    for i in range(1, error.size):
        error[i] = kept[i] * error[i - 1] + np.sqrt(1 - kept[i] ** 2) * error[i]
    share = tuning.error if tuning.error_travel > 0 else 0.0
    walk = tuning.zero_walk * np.sqrt(REFERENCE_STEP) * np.cumsum(white[2])
    return M_z * (1 + share * error) + slide * (tuning.noise * white[1] + walk)


def _even(rng: np.random.Generator, name: str) -> float:
    return float(rng.uniform(-OFF[name], OFF[name]))


def _judged(estimates: Estimates, psi: Any, truth: Any, mu: float) -> IceOutcome:
    usable = estimates.usable
    normal = np.abs(estimates.mu_eff - truth) / estimates.mu_eff_std
    travel = np.cumsum(np.abs(np.diff(psi, prepend=psi[0])))
    at = min(int(np.searchsorted(travel, TRAVEL)), usable.size - 1)
    return IceOutcome(
        mu=mu,
        held=int(np.count_nonzero(normal[usable] < 1.96)),
        usable=int(np.count_nonzero(usable)),
        beyond=float(np.mean(usable & (normal > 3))),
        share=float(np.mean(usable)),
        deviation=float(estimates.mu_std[at] / estimates.mu[at]),
        travel=float(travel[np.argmax(usable)]) if usable.any() else float("nan"),
    )


def table(case: IceCase, outcomes: Sequence[IceOutcome]) -> None:
    """The rows of a case, one a band, as Markdown."""
    for low, high in BANDS:
        of = [o for o in outcomes if low <= o.mu < high]
        if not of:
            continue
        counted = sum(o.usable for o in of)
        coverage = sum(o.held for o in of) / counted if counted else float("nan")
        print(
            f"| {case.observer} | {case.torque} | {case.tuning} | {case.effects} | {low}–{high} |"
            f" {len(of)} | {coverage:.3f} | {sum(o.beyond > 0.01 for o in of)} |"
            f" {100 * np.median([o.deviation for o in of]):.1f} % |"
            f" {np.nanmedian([o.travel for o in of]):.3f} |"
            f" {100 * np.mean([o.share for o in of]):.0f} % | {sum(not o.usable for o in of)} |",
            flush=True,
        )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--runs", type=int, default=400)
    parser.add_argument("--seed", type=int, default=FIRST_SEED, help="of the first run")
    parser.add_argument("--observer", choices=list(KINDS), default="ekf")
    parser.add_argument("--torque", choices=list(TORQUES), default="M_z")
    parser.add_argument("--tuning", choices=list(PROFILES), default="real_tyre")
    parser.add_argument("--effects", choices=["none", "declared", "found"], default="none")
    parser.add_argument("--effect", default="", help="that one of the rig in place of several")
    parser.add_argument("--stated", action="store_true", help="draw all errors that the tuning states")
    options = parser.parse_args()
    case = IceCase(
        observer=options.observer, torque=options.torque, tuning=options.tuning,
        effects=options.effects, stated=options.stated, effect=options.effect,
    )  # fmt: skip
    print(
        "| observer | torque | tuning | effects | μ | runs | coverage |"
        " runs with > 1 % usable beyond 3 σ | σ/μ after 0.3 rad | usable from [rad] | usable | never |\n"
        "|---|---|---|---|---|---:|---:|---:|---:|---:|---:|---:|"
    )
    with ProcessPoolExecutor() as pool:
        tasks = [(case, options.seed + i) for i in range(options.runs)]
        table(case, list(pool.map(outcome, tasks, chunksize=4)))


if __name__ == "__main__":
    main()
