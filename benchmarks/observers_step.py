"""What a sample costs the observers, alone and beside other software, as ratios within one run.

    python benchmarks/observers_step.py

The two of a pair run in turn and the ratio is the median over the rounds; times are those of the machine
at hand. Every rival solves the same problem with the same physics (`problem.py`), and how far its mu is
from ours is printed: filterpy's is the same filter, do-mpc's the same least-squares problem over the
first full window. Later those two differ in what they make of the samples that have left the window.
do-mpc is optional: pip install 'brushgrip[benchmarks]'.
"""

import importlib.util
from collections.abc import Callable
from functools import partial

import numpy as np

from benchmarks.problem import MODEL, RIG, TUNING, VALUES, K, TimedProblem
from benchmarks.timing import compare, seconds
from benchmarks.with_do_mpc import VARIANTS, Running
from benchmarks.with_filterpy import filter_all, in_place, through_casadi
from observers import (
    AligningTorque,
    Ekf,
    Estimates,
    Loop,
    Mhe,
    ObserverState,
    RackSampler,
    Sample,
    SteeringTorque,
    car_observer,
    run,
)
from symbolic import Model, Rig, Vehicle, effects_named

WINDOW = 50
STEPS = 20
"""Samples in a round beside do-mpc."""
Observer = Ekf | Mhe
PROBLEM = TimedProblem()
CAR = Vehicle(front_axle_load=8000.0, tyre_width=0.2, pressure=2.4e5, wheelbase=2.6, track=1.5)


def samples(problem: TimedProblem) -> list[Sample]:
    """The problem as a control loop hands it over."""
    rows = zip(*problem.signals.tolist(), problem.M_z.tolist(), strict=True)
    return [Sample(psi=p, psi_dot=r, F_N=F, dt=dt, M_z=M, M=-M) for p, r, F, dt, M in rows]


def steps(
    observer: Observer, sequence: list[Sample], state: ObserverState | None = None
) -> ObserverState:
    """Sample by sample, from the start where no state is given."""
    state = observer.init(sequence[0]) if state is None else state
    for sample in sequence:
        state = observer.step(state, sample)
    return state


def whole(observer: Observer) -> Estimates:
    """The whole problem in one call."""
    psi, psi_dot, F_N, _ = PROBLEM.signals
    return run(observer, PROBLEM.t, psi, F_N, PROBLEM.M_z, psi_dot)


def microseconds(observer: Observer, sequence: list[Sample]) -> float:
    """What a step called from Python takes: the median over some rounds, once all is compiled."""
    steps(observer, sequence[:200])
    rounds = [seconds(partial(steps, observer, sequence)) for _ in range(5)]
    return 1e6 * float(np.median(rounds)) / len(sequence)


def ours(kind: Callable[..., Observer], **settings: object) -> Observer:
    """An observer for the problem; rivals do not acquire friction among hypotheses."""
    return kind(model=MODEL, values=VALUES, rig=RIG, tuning=TUNING, acquire=False, **settings)


def alone() -> None:
    """Print what a step takes, called from Python, for several models and measurements."""
    sequence = samples(PROBLEM)
    with_effects = Model(effects=effects_named(["rate_friction", "carcass_torsion"]))
    values = {"k": K, "rate_friction.c": 0.04, "carcass_torsion.k_t": 390.0}
    wheel = Rig(a=RIG.a, e=RIG.e, J_A=0.15, b_t=1.0)
    found = AligningTorque(stiffness=True)
    cases = {
        "declared model, aligning torque": (MODEL, VALUES, RIG, AligningTorque()),
        "declared model, steering torque": (MODEL, VALUES, wheel, SteeringTorque()),
        "carcass and rate friction, aligning torque": (with_effects, values, RIG, found),
    }
    print(f"\n| a step from Python | EKF [µs] | MHE, window {WINDOW} [µs] |\n|---|---:|---:|")
    for label, (model, parameters, rig, torque) in cases.items():
        given = {"model": model, "values": parameters, "rig": rig, "measurement_model": torque}
        by_ekf, by_mhe = (microseconds(kind(**given, tuning=TUNING), sequence) for kind in (Ekf, Mhe))
        print(f"| {label} | {by_ekf:.1f} | {by_mhe:.0f} |")


def turn_rack(ekf: Ekf, rate: float) -> None:
    """A car's loop: a made-up standstill of as many samples as the problem, so many a second."""
    loop, sample_of = Loop(ekf), RackSampler(CAR)
    t = np.arange(PROBLEM.count) / rate
    force = 3000 * np.tanh(20 * np.cos(t))
    for measured in zip(t.tolist(), (0.05 * np.sin(t)).tolist(), force.tolist(), strict=True):
        loop(sample_of(*measured))


def car_beside_rig() -> None:
    """Print a car's whole step over that of a rig's EKF: its sampler keeps a window of 60 ms."""
    ekf, rig, sequence = car_observer(Ekf, CAR), ours(Ekf), samples(PROBLEM)
    print("\n| a car's sampler, EKF and loop | over a rig's EKF | a sample [µs] |\n|---|---:|---:|")
    for rate in (100, 1000):
        pair = compare(partial(turn_rack, ekf, rate), partial(steps, rig, sequence))
        print(f"| at {rate} Hz | {pair.ratio:.1f} | {1e6 * pair.slow / PROBLEM.count:.0f} |")


def beside_filterpy() -> float:
    """The filter of filterpy over ours; how far apart their mu are at most."""
    observer, sequence = ours(Ekf), samples(PROBLEM)
    print("\n| filterpy's EKF | over ours | a sample [µs] | ours [µs] |\n|---|---:|---:|---:|")
    for label, wrap in (
        ("Functions called in place", in_place),
        ("Functions called as casadi offers", through_casadi),
    ):
        pair = compare(partial(filter_all, PROBLEM, wrap), partial(steps, observer, sequence))
        slow, fast = (1e6 * time / PROBLEM.count for time in (pair.slow, pair.fast))
        print(f"| {label} | {pair.ratio:.1f} | {slow:.1f} | {fast:.1f} |")
    return float(np.abs(filter_all(PROBLEM, in_place) - whole(observer).mu).max())


def beside_do_mpc() -> None:
    """Print do-mpc's estimator over ours, and how far its mu is from that of ours, converged.

    What is compared: the time of a sample called from Python, both on the problem of `problem.py` with
    a window of 50 samples. Ours takes one Gauss-Newton step a sample, in compiled C; do-mpc solves the
    window's least squares by IPOPT, to convergence or for one iteration. `solver alone` is IPOPT's own
    time, without do-mpc around it.
    """
    observer, sequence = ours(Mhe, window=WINDOW), samples(PROBLEM)
    full = steps(observer, sequence[:WINDOW])
    after = sequence[WINDOW : WINDOW + STEPS]
    converged = ours(Mhe, window=WINDOW, iterations=5)
    expected = converged.estimate(steps(converged, sequence[:WINDOW])).mu
    print("\n| do-mpc's MHE | over ours | solver alone over ours | a sample [µs] | mu off by |")
    print("|---|---:|---:|---:|---:|")
    for label, options in VARIANTS.items():
        rival = Running(PROBLEM, WINDOW, options)
        first = rival.step()
        pair = compare(partial(rival.steps, STEPS), partial(steps, observer, after, full))
        slow, fast = pair.slow / STEPS, pair.fast / STEPS
        solver = float(np.median(rival.solver_times)) / fast
        off = abs(first - expected)
        print(f"| {label} | {pair.ratio:.0f} | {solver:.0f} | {1e6 * slow:.0f} | {off:.0e} |")
    ours_off = abs(observer.estimate(full).mu - expected)
    print(f"| ours, one Gauss-Newton step | 1 | | {1e6 * fast:.0f} | {ours_off:.0e} |")
    print(
        "\nmu off by: over the first full window, from our MHE with five steps. do-mpc weighs the oldest"
    )
    print("state of the window by a constant matrix, ours by the covariance of what has left it.")


def main() -> None:
    """Print the tables."""
    alone()
    car_beside_rig()
    print(f"\nfilterpy: mu differs by {beside_filterpy():.0e} at most")
    if importlib.util.find_spec("do_mpc"):
        beside_do_mpc()
    else:
        print("\ndo-mpc skipped: not installed, pip install 'brushgrip[benchmarks]'")


if __name__ == "__main__":
    main()
